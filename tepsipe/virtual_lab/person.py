"""A person standing with both feet on the belt: four rigid bodies, five muscles, two delayed loops.

Generalised coordinates: y belt position (m); th_1, th_2, th_3 angles of shanks, thighs and upper body from
the vertical, positive when they tip towards +y (rad), both legs as one. The feet move with the belt and do
not rotate. With m_i mass, r_i centre of mass from the lower joint, l_i length, I_i inertia of segment i, and
a_ij lever of angle j on the centre of mass of segment i (l_j below it, r_i in it, 0 above it):

    H_jk = sum_i m_i a_ij a_ik + I_j (j = k),     p_j = sum_i m_i a_ij,     M = belt, feet and segments

    M y'' + sum_j p_j (cos th_j th_j'' - sin th_j th_j'^2)                                  = u - c y'
    p_j cos th_j y'' + sum_k H_jk (cos(th_j - th_k) th_k'' + sin(th_j - th_k) th_k'^2)
                                                                = p_j g sin th_j + Q_j

    Q_1 = -tau_ankle + tau_knee,    Q_2 = -tau_knee + tau_hip,    Q_3 = -tau_hip

A joint's torque resists its angle phi (ankle th_1, knee th_2 - th_1, hip th_3 - th_2) and has two parts:

    tau = tau_0 + K (phi - phi_0) + B phi'   intrinsic: without delay
        + sum_m F_m (x_m - tone_m)           active: from the drive of the muscles, delayed

Muscle m is driven by e_m = [tone_m + stretch reflex + balance]_+ . Its reflex responds to the stretch
velocity a latency L_m earlier, s = sum w_mj phi_j' (t - L_m), above a threshold: G_m [s - s_0]_+ . Balance
responds to the centre of mass a longer delay earlier, and has a random part. Force follows the drive as a
critically damped twitch of second order, T^2 x'' + 2 T x' + x = e.

The reaction on the plate is the rate of the body's linear and angular momentum, differentiated numerically:
no free-body equation is used here.
"""

import math
from array import array
from dataclasses import dataclass

import numpy as np
import scipy

from tepsipe.virtual_lab.anthropometry import Segment, feet, shanks, thighs, upper_body
from tepsipe.virtual_lab.belt import BeltMotion, DriveTruth
from tepsipe.virtual_lab.integrate import stepper
from tepsipe.virtual_lab.motion_capture import MarkerPath

# names of the person's markers, in the strober's order
MARKERS = ("foot1", "foot2", "ankle", "shank1", "shank2", "thigh1", "thigh2", "thigh3")
MUSCLES = ("TA", "SOL", "GAS", "BF", "RF")


@dataclass(frozen=True)
class PersonTruth:
    """Hidden constants of the body.

    Attributes
    ----------
    mass_kg, stature_m : float
        Of the whole body (kg, m).
    ankle_height_m, foot_com_m : float
        Ankle above the belt; centre of mass of the feet in front of the ankle (m), half as high as it.
    stance_rad : list of 3 float
        Angles of shanks, thighs and upper body in quiet standing (rad).
    position_x_m, position_y_m : float
        Where the ankles are on the plate (m).
    gravity_m_per_s2 : float
        Acceleration of gravity (m/s²).
    """

    mass_kg: float
    stature_m: float
    ankle_height_m: float
    foot_com_m: float
    stance_rad: list
    position_x_m: float
    position_y_m: float
    gravity_m_per_s2: float


@dataclass(frozen=True)
class MuscleTruth:
    """Hidden constants of one muscle, of both legs.

    Attributes
    ----------
    latency_s : float
        From stretch to the reflex in its drive (s): L.
    stretch : list of 3 float
        Lengthening per angle of ankle, knee and hip (-): w.
    force_Nm : list of 3 float
        Torque of full drive that resists the angles of ankle, knee and hip (N·m): F.
    balance_per_Nm : list of 2 float
        Drive per wanted torque at the ankle, while that is positive and negative (1/N·m).
    """

    latency_s: float
    stretch: list
    force_Nm: list
    balance_per_Nm: list


@dataclass(frozen=True)
class TaskTruth:
    """Hidden constants that depend on the instruction, relax or stiff.

    Attributes
    ----------
    stiffness_Nm_per_rad, damping_Nms_per_rad : list of 3 float
        Intrinsic K and B of ankle, knee and hip, both legs.
    tone : list of 5 float
        Drive of the muscles in quiet standing (-).
    reflex_s_per_rad : list of 5 float
        Drive per stretch velocity (s/rad): G.
    """

    stiffness_Nm_per_rad: list
    damping_Nms_per_rad: list
    tone: list
    reflex_s_per_rad: list


@dataclass(frozen=True)
class NervesTruth:
    """Hidden constants of the loops that the instruction does not change.

    Attributes
    ----------
    reflex_threshold_rad_per_s : float
        Stretch velocity that reflexes need (rad/s): s_0.
    twitch_s : float
        Time constant of the muscles' force (s): T.
    balance_delay_s : float
        From the centre of mass to the drive (s).
    balance_Nm_per_rad, balance_Nms_per_rad : float
        Wanted torque at the ankle per lean of the centre of mass, and per its rate.
    wander_Nm, wander_s : float
        Standard deviation and correlation time of what balance adds of itself (N·m, s).
    """

    reflex_threshold_rad_per_s: float
    twitch_s: float
    balance_delay_s: float
    balance_Nm_per_rad: float
    balance_Nms_per_rad: float
    wander_Nm: float
    wander_s: float


@dataclass(frozen=True)
class PersonMarkers:
    """Where the markers sit on the right leg.

    Attributes
    ----------
    foot_m : list of [along, up]
        On the foot: forward of the ankle and above the belt (m).
    shank_m, thigh_m : list of [across, along]
        In front of the segment's axis, and along it from its lower joint (m).
    lateral_m : float
        Position of all markers across the belt, from the middle between the feet (m).
    """

    foot_m: list
    shank_m: list
    thigh_m: list
    lateral_m: float


@dataclass(frozen=True)
class PersonMotion(BeltMotion):
    """Exact motion of the rig; the feet move with the belt.

    Attributes
    ----------
    angles, rates : ndarray, shape (n, 3)
        Angles of shanks, thighs and upper body from the vertical (rad) and their rates (rad/s).
    drive : ndarray, shape (n, 5)
        Drive of the muscles (-), in the order of `MUSCLES`.
    """

    angles: np.ndarray
    rates: np.ndarray
    drive: np.ndarray


def segments(person: PersonTruth) -> tuple[Segment, Segment, Segment]:
    """Shanks, thighs and upper body (kg, m, kg·m²)."""
    size = person.mass_kg, person.stature_m
    return shanks(*size), thighs(*size), upper_body(*size, person.ankle_height_m)


def _carried(chain: tuple[Segment, ...]) -> np.ndarray:
    """a_ij (m), shape (3, 3): how far angle j carries the centre of mass of segment i."""
    a = np.diag([segment.com_m for segment in chain])
    for j, segment in enumerate(chain):
        a[j + 1 :, j] = segment.length_m
    return a


def critical_stiffness(person: PersonTruth) -> float:
    """What topples all that the ankles carry (N·m/rad): m g h."""
    chain = segments(person)
    mass = np.array([segment.mass_kg for segment in chain])
    return float(person.gravity_m_per_s2 * (mass @ _carried(chain)).sum())


def wander(nerves: NervesTruth, n: int, rate_hz: float, rng: np.random.Generator) -> np.ndarray:
    """Torque that balance adds of itself (N·m), shape (n,): an Ornstein-Uhlenbeck process."""
    kept = math.exp(-1.0 / (nerves.wander_s * rate_hz))
    steps = rng.standard_normal(n) * math.sqrt(1.0 - kept**2)
    state, out = float(rng.standard_normal()), np.empty(n)
    for k, step in enumerate(steps.tolist()):
        state = kept * state + step
        out[k] = state
    return nerves.wander_Nm * out


def move_person(
    person: PersonTruth,
    muscles: dict[str, MuscleTruth],
    task: TaskTruth,
    nerves: NervesTruth,
    drive: DriveTruth,
    command,
    duration_s: float,
    rate_hz: float,
    rng: np.random.Generator,
) -> PersonMotion:
    """Integrate belt, body and nerves together.

    Parameters
    ----------
    person : PersonTruth
        Constants of the body (units in their names).
    muscles : dict of str to MuscleTruth
        Those of `MUSCLES`, by name.
    task, nerves, drive : TaskTruth, NervesTruth, DriveTruth
        Other constants (units in their names).
    command : callable
        Commanded belt velocity (m/s) at t (s).
    duration_s, rate_hz : float
        Length of the run (s) and steps per second (Hz).
    rng : numpy.random.Generator
        Draws how balance wanders.

    Returns
    -------
    PersonMotion
        Motion, drive and reaction on the grid of the integration (s, m, rad, N, N·m).

    Raises
    ------
    FloatingPointError
        If the person falls.
    """
    chain = segments(person)
    mass = np.array([segment.mass_kg for segment in chain])
    a = _carried(chain)
    h = np.einsum("i,ij,ik->jk", mass, a, a) + np.diag([segment.inertia_kgm2 for segment in chain])
    p = mass @ a
    g = person.gravity_m_per_s2
    moving = drive.belt_mass_kg + feet(person.mass_kg, person.stature_m).mass_kg + float(mass.sum())

    p1, p2, p3 = p.tolist()
    h11, h22, h33 = np.diag(h).tolist()
    h12, h13, h23 = float(h[0, 1]), float(h[0, 2]), float(h[1, 2])
    k_a, k_k, k_h = task.stiffness_Nm_per_rad
    b_a, b_k, b_h = task.damping_Nms_per_rad
    # quiet standing is an equilibrium: each joint bears the weight above it
    s1, s2, s3 = person.stance_rad
    load = [weight * g * math.sin(angle) for weight, angle in zip((p1, p2, p3), (s1, s2, s3), strict=True)]
    rest_h = load[2]
    rest_k = rest_h + load[1]
    rest_a = rest_k + load[0]
    sin, cos = math.sin, math.cos
    force, viscous, delay = drive.servo(), drive.viscous_Ns_per_m, drive.delay_s
    # torques of the muscles at the start and at the end of the step, and the step's start
    active = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]

    def derivative(t: float, state: tuple[float, ...]) -> tuple[float, ...]:
        _, v, q, th1, th2, th3, w1, w2, w3 = state
        u, q_rate = force(command(t - delay) - v, q)
        late = (t - active[6]) * rate_hz
        tau_a = rest_a + k_a * (th1 - s1) + b_a * w1 + active[0] + late * active[3]
        tau_k = rest_k + k_k * (th2 - th1 - s2 + s1) + b_k * (w2 - w1) + active[1] + late * active[4]
        tau_h = rest_h + k_h * (th3 - th2 - s3 + s2) + b_h * (w3 - w2) + active[2] + late * active[5]
        n1, n2, n3 = sin(th1), sin(th2), sin(th3)
        c1, c2, c3 = cos(th1), cos(th2), cos(th3)
        c12, n12 = c1 * c2 + n1 * n2, n1 * c2 - c1 * n2
        c13, n13 = c1 * c3 + n1 * n3, n1 * c3 - c1 * n3
        c23, n23 = c2 * c3 + n2 * n3, n2 * c3 - c2 * n3
        q1, q2, q3 = w1 * w1, w2 * w2, w3 * w3
        e1, e2, e3 = p1 * c1, p2 * c2, p3 * c3
        push = u - viscous * v + p1 * n1 * q1 + p2 * n2 * q2 + p3 * n3 * q3
        f1 = p1 * g * n1 - tau_a + tau_k - h12 * n12 * q2 - h13 * n13 * q3
        f2 = p2 * g * n2 - tau_k + tau_h + h12 * n12 * q1 - h23 * n23 * q3
        f3 = p3 * g * n3 - tau_h + h13 * n13 * q1 + h23 * n23 * q2
        # without the belt: its row is solved for y'' and put into the others
        r1, r2, r3 = e1 / moving, e2 / moving, e3 / moving
        a11, a12, a13 = h11 - r1 * e1, h12 * c12 - r1 * e2, h13 * c13 - r1 * e3
        a22, a23, a33 = h22 - r2 * e2, h23 * c23 - r2 * e3, h33 - r3 * e3
        f1 -= r1 * push
        f2 -= r2 * push
        f3 -= r3 * push
        # Gauss's elimination of a symmetric matrix
        g2, g3 = a12 / a11, a13 / a11
        a22 -= g2 * a12
        a23 -= g2 * a13
        a33 -= g3 * a13
        f2 -= g2 * f1
        f3 -= g3 * f1
        g3 = a23 / a22
        d3 = (f3 - g3 * f2) / (a33 - g3 * a23)
        d2 = (f2 - a23 * d3) / a22
        d1 = (f1 - a12 * d2 - a13 * d3) / a11
        return (v, (push - e1 * d1 - e2 * d2 - e3 * d3) / moving, q_rate, w1, w2, w3, d1, d2, d3)

    steps = math.ceil(duration_s * rate_hz)
    state = (0.0, 0.0, 0.0, s1, s2, s3, 0.0, 0.0, 0.0)
    step, h = stepper(len(state)), 1.0 / rate_hz
    nerves_of = _Nerves(muscles, task, nerves, p.tolist(), (s1, s2, s3), steps, rate_hz, rng)
    driven, torques = nerves_of.step(state)
    states, drives = array("d", state), array("d", driven)
    for k in range(steps):
        driven, ahead = nerves_of.step(state)
        drives.extend(driven)
        active[:3] = torques
        active[3:6] = [after - before for before, after in zip(torques, ahead, strict=True)]
        active[6] = k / rate_hz
        torques = ahead
        state = step(derivative, k / rate_hz, state, h)
        states.extend(state)
        if not (-0.7 < state[3] < 0.7 and -0.7 < state[4] < 0.7 and -0.7 < state[5] < 0.7):
            raise FloatingPointError("the virtual person falls: check stiffness, damping and balance")
    states = np.array(states).reshape(steps + 1, -1)
    drives = np.array(drives).reshape(steps + 1, -1)
    time = np.arange(steps + 1) / rate_hz
    y, v = states[:, 0], states[:, 1]
    return PersonMotion(
        time=time,
        belt_position=y,
        belt_velocity=v,
        belt_acceleration=scipy.interpolate.CubicSpline(time, v)(time, 1),
        reaction=_reaction(person, chain, a, time, y, v, states[:, 3:6], states[:, 6:9]),
        angles=states[:, 3:6],
        rates=states[:, 6:9],
        drive=drives,
    )


class _Nerves:
    """Drive and active torque, step by step, from what was sensed a latency ago."""

    def __init__(self, muscles, task, nerves, p, stance, steps, rate_hz, rng):
        self._nerves = nerves
        self._weights = [part / sum(p) for part in p]
        self._stance = stance
        self._wander = wander(nerves, steps + 2, rate_hz, rng).tolist()
        self._balance_late = nerves.balance_delay_s * rate_hz
        own = [muscles[name] for name in MUSCLES]
        # latencies in steps; the drive one step ahead is known, because every latency is longer than a step
        self._constants = [
            (
                tone,
                muscle.balance_per_Nm,
                gain,
                muscle.latency_s * rate_hz,
                tuple(muscle.force_Nm),
                tuple(muscle.stretch),
            )
            for muscle, tone, gain in zip(own, task.tone, task.reflex_s_per_rad, strict=True)
        ]
        self._stretched: list[list[float]] = [[] for _ in MUSCLES]
        self._leaned: list[float] = []
        self._twitch = [(tone, 0.0) for tone in task.tone]
        self._drive_before = list(task.tone)
        self._k = -1
        decay = math.exp(-1.0 / (nerves.twitch_s * rate_hz))
        step = 1.0 / (nerves.twitch_s * rate_hz)
        # exact solution of the critically damped twitch for a drive that is constant over a step
        self._to_x = (decay * (1.0 + step), decay * step)
        self._to_v = (-decay * step, decay * (1.0 - step))

    def step(self, state) -> tuple[list[float], list[float]]:
        """Drive (-) and active torque at ankle, knee and hip (N·m) one step after ``state``.

        The first call, with the first state, gives them at the first state itself.
        """
        self._k += 1
        k, nerves = self._k, self._nerves
        _, _, _, th1, th2, th3, w1, w2, w3 = state
        if k:
            f1, f2, f3 = self._weights
            s1, s2, s3 = self._stance
            lean = f1 * (th1 - s1) + f2 * (th2 - s2) + f3 * (th3 - s3)
            rate = f1 * w1 + f2 * w2 + f3 * w3
            self._leaned.append(nerves.balance_Nm_per_rad * lean + nerves.balance_Nms_per_rad * rate)
        wanted = _at(self._leaned, k - self._balance_late) + self._wander[k]
        side = 0 if wanted >= 0.0 else 1
        knee, hip = w2 - w1, w3 - w2
        threshold, drive_before, twitch = nerves.reflex_threshold_rad_per_s, self._drive_before, self._twitch
        (xx, xv), (vx, vv) = self._to_x, self._to_v
        drives, ankle_Nm, knee_Nm, hip_Nm = [], 0.0, 0.0, 0.0
        for m, (tone, balance, gain, late, forces, (a, b, c)) in enumerate(self._constants):
            history = self._stretched[m]
            if k:
                history.append(a * w1 + b * knee + c * hip)
            stretch = _at(history, k - late) - threshold
            e = tone + balance[side] * wanted
            if stretch > 0.0:
                e += gain * stretch
            if e < 0.0:
                e = 0.0
            x, v = twitch[m]
            if k:
                held = 0.5 * (drive_before[m] + e)
                x, v = held + xx * (x - held) + xv * v, vx * (x - held) + vv * v
                twitch[m] = (x, v)
            drive_before[m] = e
            drives.append(e)
            over = x - tone
            ankle_Nm += forces[0] * over
            knee_Nm += forces[1] * over
            hip_Nm += forces[2] * over
        return drives, [ankle_Nm, knee_Nm, hip_Nm]


def _at(history: list[float], place: float) -> float:
    """Value between two entries of a history; 0 before it."""
    if place < 0.0:
        return 0.0
    k = int(place)
    part = place - k
    return history[k] if part == 0.0 else history[k] + part * (history[k + 1] - history[k])


def _reaction(person: PersonTruth, chain, a: np.ndarray, time, y, v, th, w) -> np.ndarray:
    """Wrench on the person about the plate's origin, from the rates of its momenta."""
    mass = np.array([segment.mass_kg for segment in chain])
    inertia = np.array([segment.inertia_kgm2 for segment in chain])
    both_feet = feet(person.mass_kg, person.stature_m)
    com_y, com_z = y[:, None] + np.sin(th) @ a.T, person.ankle_height_m + np.cos(th) @ a.T
    com_vy, com_vz = v[:, None] + (np.cos(th) * w) @ a.T, -(np.sin(th) * w) @ a.T
    foot_z = 0.5 * person.ankle_height_m
    momentum_y = com_vy @ mass + both_feet.mass_kg * v
    momentum_z = com_vz @ mass
    # about x, right-handed (positive turns y towards z); th turns z towards y, hence its minus
    spin_x = (com_y * com_vz - com_z * com_vy) @ mass - w @ inertia - both_feet.mass_kg * foot_z * v
    rate = scipy.interpolate.CubicSpline(time, np.column_stack([momentum_y, momentum_z, spin_x]))(time, 1)
    g = person.gravity_m_per_s2
    fy = rate[:, 0]
    fz = rate[:, 1] + (mass.sum() + both_feet.mass_kg) * g
    weight = g * (com_y @ mass + both_feet.mass_kg * (y + person.foot_com_m))
    mx = rate[:, 2] + weight + person.position_y_m * fz
    my = -person.position_x_m * fz
    mz = person.position_x_m * fy
    return np.column_stack([np.zeros_like(fy), fy, fz, mx, my, mz])


def person_marker_paths(
    markers: PersonMarkers, person: PersonTruth, motion: PersonMotion
) -> list[MarkerPath]:
    """Paths of the markers on foot, ankle, shank and thigh, in the order of `MARKERS`.

    Parameters
    ----------
    markers, person : PersonMarkers, PersonTruth
        Constants (units in their names).
    motion : PersonMotion
        Exact motion of the rig (s, m, rad).

    Returns
    -------
    list of callable
        Each gives x, y, z (m), shape (n, 3), at instants (s), shape (n,).
    """
    belt = scipy.interpolate.CubicSpline(motion.time, motion.belt_position)
    angles = scipy.interpolate.CubicSpline(motion.time, motion.angles[:, :2])
    shank_m = shanks(person.mass_kg, person.stature_m).length_m

    def place(instant: np.ndarray, forward, up) -> np.ndarray:
        x = np.full(instant.shape, person.position_x_m + markers.lateral_m)
        y = person.position_y_m + belt(instant)
        return np.column_stack([x, y + forward, np.broadcast_to(up, instant.shape)])

    def on_foot(along: float, up: float) -> MarkerPath:
        return lambda instant: place(instant, along, up)

    def on_leg(segment: int, across: float, along: float) -> MarkerPath:
        def path(instant: np.ndarray) -> np.ndarray:
            th = angles(instant)
            forward, up = 0.0, person.ankle_height_m
            if segment == 1:
                forward, up = shank_m * np.sin(th[:, 0]), up + shank_m * np.cos(th[:, 0])
            turn = th[:, segment]
            forward = forward + across * np.cos(turn) + along * np.sin(turn)
            return place(instant, forward, up - across * np.sin(turn) + along * np.cos(turn))

        return path

    foot = [on_foot(*position) for position in markers.foot_m]
    shank = [on_leg(0, *position) for position in ([0.0, 0.0], *markers.shank_m)]
    return [*foot, *shank, *[on_leg(1, *position) for position in markers.thigh_m]]
