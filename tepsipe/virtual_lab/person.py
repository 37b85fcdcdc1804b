"""A person standing with both feet on the belt: feet, three rigid segments, five muscles, delayed loops.

Generalised coordinates: y position of the belt in the room (m), which moves on its frame and with it; th_1,
th_2, th_3 angles of shanks, thighs and upper body from the vertical, positive when they tip towards +y (rad),
both legs as one; psi tilt of the feet on their soft heels and arches about the ankles, which move with the
belt. With M_e and P mass and push of belt, drive and frame together (`tepsipe.virtual_lab.moving_belt`), m_i
mass, r_i centre of mass from the lower joint, l_i length, I_i inertia of segment i, and a_ij lever of angle j
on the centre of mass of segment i (l_j below it, r_i in it, 0 above it):

    H_jk = sum_i m_i a_ij a_ik + I_j (j = k),     p_j = sum_i m_i a_ij,     M = M_e, feet and segments

    M y'' + sum_j p_j (cos th_j th_j'' - sin th_j th_j'^2)                                  = P
    p_j cos th_j y'' + sum_k H_jk (cos(th_j - th_k) th_k'' + sin(th_j - th_k) th_k'^2)
                                                                = p_j g sin th_j + Q_j
    J psi'' = tau_ankle - tau_0 - K_f psi - B_f psi' + m_f h_f y''

    Q_1 = -tau_ankle + tau_knee,    Q_2 = -tau_knee + tau_hip,    Q_3 = -tau_hip

with m_f and J mass and moment of inertia about the ankles of the feet, whose centre of mass is h_f below
them. Drive and frame do not feel the tilt of the feet: P stands for the push less m_f h_f psi''.

A joint's torque resists its angle phi (ankle th_1 - psi, knee th_2 - th_1, hip th_3 - th_2) and has two
parts, at the ankle three:

    tau = tau_0 + K (phi - phi_0) + B phi'   intrinsic: without delay
        + K_s z                              at the ankle, short range: cross-bridges that yield
        + sum_m F_m (x_m - tone_m)           active: from the drive of the muscles, delayed (nerves.py)

The short range is Dahl's element, z' = phi' - |phi'| z / r: rotations that are small to r meet its whole
stiffness K_s, and its torque never exceeds K_s r.

The reaction on the plate is the rate of the body's linear and angular momentum, differentiated numerically:
no free-body equation is used here.

Reflexes, balance and muscles of a standing person, step by step.

Muscle m is driven by

    e_m = [tone_m + G_m [s(t - L_m) - s_0]_+ + G_2m [s(t - L_2m) - s_0]_+ + balance]_+

with the velocity s = sum_j w_mj phi_j' at which it is stretched, above a threshold, a short and a medium
latency earlier (M1 and M2). Balance responds to the centre of mass after a longer delay, and has a random
part. Force follows the drive as a twitch of second order that rises with T and falls with T_2, critically
damped if both are the same:

    T T_2 x'' + (T + T_2) x' + x = e
"""

import math
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
import scipy

from tepsipe.virtual_lab.belt import BeltMotion, Command, DriveTruth, stage_commands
from tepsipe.virtual_lab.integrate import Derivative, stepper
from tepsipe.virtual_lab.moving_belt import Below, MovingBelt, motion_of_belt
from tepsipe.virtual_lab.person_constants import (
    FOOT,
    MUSCLES,
    SHANK,
    THIGH,
    NervesTruth,
    PersonTruth,
    Segment,
    Subject,
    TaskTruth,
    feet,
    scaled,
    shanks,
    thighs,
    upper_body,
)
from tepsipe.virtual_lab.truth_file import StandingMotion


def wander(nerves: NervesTruth, n: int, rate_hz: float, rng: np.random.Generator) -> np.ndarray:
    """Random torque of balance (N·m), shape (n,): an Ornstein-Uhlenbeck process."""
    kept = math.exp(-1.0 / (nerves.wander_s * rate_hz))
    steps = rng.standard_normal(n) * math.sqrt(1.0 - kept**2)
    before = kept * rng.standard_normal(1)
    return nerves.wander_Nm * scipy.signal.lfilter([1.0], [1.0, -kept], steps, zi=before)[0]


class Nerves:
    """Drive and active torque (N·m) from what was sensed a latency ago, `ahead` steps at a time."""

    def __init__(
        self, subject: Subject, levers: list[float], steps: int, rate_hz: float, rng: np.random.Generator
    ):
        task, nerves = subject.task, subject.nerves
        muscles = [subject.muscles[name] for name in MUSCLES]
        self._nerves, self._stance = nerves, np.array(subject.person.stance_rad)
        self._weights = np.array(levers) / sum(levers)
        self._wander = wander(nerves, steps + 2, rate_hz, rng)
        self._tone, self._force = np.array(task.tone), np.array([muscle.force_Nm for muscle in muscles])
        self._balance = np.array([muscle.balance_per_Nm for muscle in muscles]).T
        self._stretch = np.array([muscle.stretch for muscle in muscles]).T
        # short-latency reflexes of all muscles, medium-latency reflexes, balance
        self._gains = np.array([*task.reflex_s_per_rad, *task.medium_reflex_s_per_rad])
        latencies = [m.latency_s for m in muscles] + [m.medium_latency_s or m.latency_s for m in muscles]
        whole, part = zip(*[_steps(s * rate_hz) for s in (*latencies, nerves.balance_delay_s)], strict=True)
        self._late, self._part = np.array(whole), np.array(part)
        self.ahead = max(1, min(whole) - 1)
        """Steps whose drive is known from the states so far, because every latency is longer."""
        n = len(muscles)
        self._of = np.r_[:n, :n, n]
        # stretch of the muscles and what balance senses, from the longest latency before the start on: there
        # all is at rest
        self._sensed = np.zeros((max(whole) + steps + 1, n + 1))
        self._start = self._known = max(whole)
        self._twitch = _twitch(nerves, 1.0 / rate_hz)
        self._tension = np.outer(scipy.signal.lfilter_zi(*self._twitch), self._tone)
        self.drive = self._driven(np.array([0]))[0]
        """Drive at the latest step (here the first)."""

    def next_steps(self, states: Annotated[np.ndarray, "(n, 14)"]) -> tuple[np.ndarray, np.ndarray]:
        """Drives, shape (m, 5), and torques of ankle, knee and hip (N·m), shape (m, 3), of the next steps.

        states: states since the last call, the first included.
        """
        known = self._known + len(states)
        rates = states[:, 6:9]
        joints = rates - np.column_stack([states[:, 10], rates[:, :2]])
        lean = self._nerves.balance_Nm_per_rad * (states[:, 3:6] - self._stance)
        self._sensed[self._known : known, :-1] = joints @ self._stretch
        self._sensed[self._known : known, -1] = (
            lean + self._nerves.balance_Nms_per_rad * rates
        ) @ self._weights
        self._known = known
        steps = np.arange(known, min(known + self.ahead, len(self._sensed))) - self._start
        drives = self._driven(steps)
        held = 0.5 * (drives + np.vstack([self.drive, drives[:-1]]))
        tension, self._tension = scipy.signal.lfilter(*self._twitch, held, axis=0, zi=self._tension)
        self.drive = drives[-1]
        return drives, (tension - self._tone) @ self._force

    def _driven(self, steps: Annotated[np.ndarray, "(m,)"]) -> Annotated[np.ndarray, "(m, 5)"]:
        """Drives at the numbers of some steps."""
        at = steps[:, None] + (self._start - self._late)
        before = self._sensed[at, self._of]
        sensed = before + self._part * (self._sensed[at + 1, self._of] - before)
        wanted = (self._wander[steps] + sensed[:, -1])[:, None]
        drive = self._tone + np.where(wanted >= 0.0, *self._balance) * wanted
        stretch = np.maximum(sensed[:, :-1] - self._nerves.reflex_threshold_rad_per_s, 0.0)
        reflexes, n = self._gains * stretch, self._tone.size
        return np.maximum(drive + reflexes[:, :n] + reflexes[:, n:], 0.0)


def _twitch(nerves: NervesTruth, step_s: float) -> tuple[list[float], list[float]]:
    """Numerator and denominator in 1/z of the twitch, exact for a drive that is constant in a step."""
    rise, fall = step_s / nerves.twitch_s, step_s / (nerves.relaxation_s or nerves.twitch_s)
    rising, falling = math.exp(-rise), math.exp(-fall)
    # what is left of a deviation x - e after a step, from x' = 0
    left = rising * (1.0 + rise) if rise == fall else (fall * rising - rise * falling) / (fall - rise)
    denominator = [1.0, -rising - falling, rising * falling]
    return [1.0 - left, sum(denominator) - 1.0 + left], denominator


def _steps(latency: float) -> tuple[int, float]:
    """A latency in steps as whole steps, rounded up, and the part of a step by which it is shorter."""
    whole = math.ceil(latency - 1e-9)
    return whole, max(0.0, whole - latency)


@dataclass(frozen=True)
class PersonMotion(BeltMotion):
    """Exact motion of the rig; the feet move with belt and frame."""

    angles: Annotated[np.ndarray, "(n, 3)"]
    rates: Annotated[np.ndarray, "(n, 3)"]
    """Angles of shanks, thighs and upper body from the vertical (rad) and their rates (rad/s)."""
    drive: Annotated[np.ndarray, "(n, 5)"]
    """Drive of the muscles, in the order of `MUSCLES`."""
    foot: np.ndarray
    foot_rate: np.ndarray
    """Tilt of the feet from quiet standing (rad) and its rate (rad/s)."""
    short_range: np.ndarray
    active: np.ndarray
    """Deflection of the ankles' short range (rad), and the active torque of the ankles (N·m)."""


def segments(person: PersonTruth) -> tuple[Segment, Segment, Segment]:
    """Shanks, thighs and upper body (kg, m, kg·m²); the upper body has the remaining mass."""
    size = person.mass_kg, person.stature_m
    legs = person.foot_mass + person.shank_mass + person.thigh_mass
    trunk = upper_body(*size, person.ankle_height_m)
    more = 2.0 * person.mass_kg * (FOOT[1] + SHANK[1] + THIGH[1] - legs)
    return (
        scaled(shanks(*size), person.shank_mass / SHANK[1]),
        scaled(thighs(*size), person.thigh_mass / THIGH[1]),
        scaled(trunk, 1.0 + more / trunk.mass_kg),
    )


def feet_of(person: PersonTruth) -> Segment:
    """Both feet (kg, m, kg·m²)."""
    return scaled(feet(person.mass_kg, person.stature_m), person.foot_mass / FOOT[1])


def _carried(chain: tuple[Segment, ...]) -> np.ndarray:
    """Lever a_ij (m), shape (3, 3): displacement of the centre of mass of segment i per angle j."""
    a = np.diag([segment.com_m for segment in chain])
    for j, segment in enumerate(chain):
        a[j + 1 :, j] = segment.length_m
    return a


def critical_stiffness(person: PersonTruth) -> float:
    """Toppling stiffness m g h of everything that the ankles carry (N·m/rad)."""
    chain = segments(person)
    mass = np.array([segment.mass_kg for segment in chain])
    return float(person.gravity_m_per_s2 * (mass @ _carried(chain)).sum())


def move_person(
    subject: Subject,
    drive: DriveTruth,
    command: Command,
    duration_s: float,
    rate_hz: float,
    rng: np.random.Generator,
    below: Below = (),
) -> PersonMotion:
    """Integrate belt, frame, body and nerves together.

    subject: constants of body, muscles, task and nerves.
    command: commanded belt velocity (m/s) at t (s).
    duration_s, rate_hz: length of the run (s) and steps per second (Hz).
    below: plates of the belts below the feet.
    Returns: motion, drive, parts of the ankles' torque and reaction on the grid of the integration.
    """
    person = subject.person
    belt = MovingBelt(drive, person.mass_kg * person.gravity_m_per_s2, rate_hz, below)
    body = _body(person, belt.moving_kg)
    start = (0.0, 0.0, 0.0, *person.stance_rad, *(0.0,) * 8)
    derivative, x = belt.with_pitch(_derivative(person, subject.task, belt, body), start)
    commands = stage_commands(command, drive.delay_s, duration_s, rate_hz)
    steps = len(commands)
    nerves = Nerves(subject, body.levers, steps, rate_hz, rng)
    step, h = stepper(len(x)), 1.0 / rate_hz
    states, drives = np.empty((steps + 1, len(x))), np.empty((steps + 1, len(MUSCLES)))
    torques = np.zeros((steps + 1, 3))
    states[0], drives[0] = x, nerves.drive
    at_zero = _standing(person, body) - subject.task.stiffness_Nm_per_rad * np.diff(
        person.stance_rad, prepend=0.0
    )
    commanded, begin_step = commands.T.tolist(), belt.begin_step
    for k in range(0, steps, nerves.ahead):
        now, ahead = slice(k, min(k + nerves.ahead, steps)), slice(k + 1, k + 1 + nerves.ahead)
        drives[ahead], torques[ahead] = nerves.next_steps(states[max(0, k + 1 - nerves.ahead) : k + 1])
        begin, end = at_zero + torques[now], at_zero + torques[ahead]
        inputs = [
            zip(u[now], torque.tolist(), strict=True)
            for u, torque in zip(commanded, (begin, 0.5 * (begin + end), end), strict=True)
        ]
        moved = []
        for i, (before, middle, after) in enumerate(zip(*inputs, strict=True), start=k):
            begin_step(i, x[1] - x[13])
            x = step(derivative, derivative(before, x), middle, after, x, h)
            moved.append(x)
            if not (-0.7 < x[3] < 0.7 and -0.7 < x[4] < 0.7 and -0.7 < x[5] < 0.7):
                raise FloatingPointError("the virtual person falls: check stiffness, damping and balance")
        states[ahead] = moved
    time = np.arange(steps + 1) / rate_hz
    y, v = states[:, 0], states[:, 1]
    return PersonMotion(
        **motion_of_belt(time, y, v, states[:, 12], states[:, 13]),
        reaction=_reaction(person, time, states),
        angles=states[:, 3:6],
        rates=states[:, 6:9],
        drive=drives,
        foot=states[:, 9],
        foot_rate=states[:, 10],
        short_range=states[:, 11],
        active=torques[:, 0],
    )


@dataclass(frozen=True)
class _Body:
    """Coefficients of the equations of motion: H_jk (kg·m²), p_j (kg·m), p_j g (N·m) and M (kg)."""

    inertia: np.ndarray
    levers: list[float]
    weights: list[float]
    moving_kg: float


def _body(person: PersonTruth, belt_kg: float) -> _Body:
    chain = segments(person)
    mass = np.array([segment.mass_kg for segment in chain])
    a = _carried(chain)
    levers = (mass @ a).tolist()
    return _Body(
        inertia=np.einsum("i,ij,ik->jk", mass, a, a) + np.diag([segment.inertia_kgm2 for segment in chain]),
        levers=levers,
        weights=[p * person.gravity_m_per_s2 for p in levers],
        moving_kg=belt_kg + feet_of(person).mass_kg + float(mass.sum()),
    )


def _derivative(person: PersonTruth, task: TaskTruth, belt: MovingBelt, body: _Body) -> Derivative:
    """Rate of change of the state: y, y', the servo's, th, th', psi, psi', z, x and x'.

    Its input is the command (m/s), and the torques of ankle, knee and hip (N·m) at angles of 0.
    """
    k_a, k_k, k_h = task.stiffness_Nm_per_rad
    b_a, b_k, b_h = task.damping_Nms_per_rad
    k_r = task.short_range_Nm_per_rad
    yielding = 1.0 / person.short_range_rad if person.short_range_rad else 0.0
    # over the root of all that moves
    root = math.sqrt(body.moving_kg)
    p1, p2, p3 = (lever / root for lever in body.levers)
    weight1, weight2, weight3 = body.weights
    h11, h22, h33 = np.diag(body.inertia).tolist()
    h12, h13, h23 = float(body.inertia[0, 1]), float(body.inertia[0, 2]), float(body.inertia[1, 2])
    pushed, swaying = belt.pushed, belt.swaying
    both_feet = feet_of(person)
    k_f, b_f = person.foot_stiffness_Nm_per_rad, person.foot_damping_Nms_per_rad
    depth = 0.5 * person.ankle_height_m
    to_foot = both_feet.inertia_kgm2 + both_feet.mass_kg * (person.foot_com_m**2 + depth**2)
    to_foot = 1.0 / to_foot if k_f else 0.0
    from_belt = both_feet.mass_kg * depth
    at_rest = float(_standing(person, body)[0])
    sin, cos = math.sin, math.cos

    # one function of numbers, not of arrays: the integration calls it 4000 times for each second of a trial
    def derivative(inputs: tuple[float, list[float]], state: tuple[float, ...]) -> tuple[float, ...]:
        commanded, (rest_a, rest_k, rest_h) = inputs
        _, v, q, th1, th2, th3, w1, w2, w3, tilt, w_f, z, sway, sway_rate = state
        push, q_rate, sway_free = pushed(commanded, v, q, sway, sway_rate)
        # torques of the joints
        w_a = w1 - w_f
        tau_a = k_a * (th1 - tilt) + b_a * w_a + k_r * z + rest_a
        tau_k = k_k * (th2 - th1) + b_k * (w2 - w1) + rest_k
        tau_h = k_h * (th3 - th2) + b_h * (w3 - w2) + rest_h
        # accelerations
        q1, q2, q3 = w1 * w1, w2 * w2, w3 * w3
        n1, n2, n3 = sin(th1), sin(th2), sin(th3)
        c1, c2, c3 = cos(th1), cos(th2), cos(th3)
        m12, m13, m23 = h12 * (n1 * c2 - c1 * n2), h13 * (n1 * c3 - c1 * n3), h23 * (n2 * c3 - c2 * n3)
        e1, e2, e3 = p1 * c1, p2 * c2, p3 * c3
        push = push / root + p1 * n1 * q1 + p2 * n2 * q2 + p3 * n3 * q3
        # without the belt: its row is solved for y'' and put into the others
        f1 = weight1 * n1 - tau_a + tau_k - m12 * q2 - m13 * q3 - e1 * push
        a11, a12, a13 = (
            h11 - e1 * e1,
            h12 * (c1 * c2 + n1 * n2) - e1 * e2,
            h13 * (c1 * c3 + n1 * n3) - e1 * e3,
        )
        # Gauss's elimination of a symmetric matrix
        g2, g3 = a12 / a11, a13 / a11
        f2 = weight2 * n2 - tau_k + tau_h + m12 * q1 - m23 * q3 - e2 * push - g2 * f1
        a22, a23 = h22 - e2 * e2 - g2 * a12, h23 * (c2 * c3 + n2 * n3) - e2 * e3 - g2 * a13
        g23 = a23 / a22
        f3 = weight3 * n3 - tau_h + m13 * q1 + m23 * q2 - e3 * push - g3 * f1 - g23 * f2
        d3 = f3 / (h33 - e3 * e3 - g3 * a13 - g23 * a23)
        d2 = (f2 - a23 * d3) / a22
        d1 = (f1 - a12 * d2 - a13 * d3) / a11
        v_rate = (push - e1 * d1 - e2 * d2 - e3 * d3) / root
        d_f = to_foot * (tau_a - at_rest - k_f * tilt - b_f * w_f + from_belt * v_rate)
        z_rate, sway_rate_rate = w_a - abs(w_a) * z * yielding, swaying * v_rate + sway_free
        return v, v_rate, q_rate, w1, w2, w3, d1, d2, d3, w_f, d_f, z_rate, sway_rate, sway_rate_rate

    return derivative


def _standing(person: PersonTruth, body: _Body) -> np.ndarray:
    """Torques of ankle, knee and hip in quiet standing (N·m): each joint bears what is above it."""
    return np.cumsum((body.weights * np.sin(person.stance_rad))[::-1])[::-1]


def _feet_com(
    person: PersonTruth, y: np.ndarray, v: np.ndarray, tilt: np.ndarray, w_f: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """y, z (m), y' and z' (m/s) of the feet's centre of mass, forward of the ankles and below them."""
    forward, below = person.foot_com_m, -0.5 * person.ankle_height_m
    foot_y = y + forward * np.cos(tilt) + below * np.sin(tilt)
    foot_z = person.ankle_height_m + below * np.cos(tilt) - forward * np.sin(tilt)
    foot_vy = v + w_f * (below * np.cos(tilt) - forward * np.sin(tilt))
    foot_vz = -w_f * (forward * np.cos(tilt) + below * np.sin(tilt))
    return foot_y, foot_z, foot_vy, foot_vz


def loads_of_legs(person: PersonTruth, motion: PersonMotion, lateral_m: float) -> dict[str, BeltMotion]:
    """Motion with the reaction of each leg's own plate (N, N·m): left, right.

    The feet are equal. The forces of the legs on them are shared as the weight is, their torques as
    `PersonTruth.marked_share` says of the right leg. Both ankles are at the same place along the belt, and
    ``lateral_m`` to both sides of the middle between the feet.
    """
    feet, y = feet_of(person), motion.position
    foot_y, foot_z, foot_vy, foot_vz = _feet_com(person, y, motion.velocity, motion.foot, motion.foot_rate)
    spin = feet.mass_kg * (foot_y * foot_vz - foot_z * foot_vy) - feet.inertia_kgm2 * motion.foot_rate
    momenta = np.column_stack([feet.mass_kg * foot_vy, feet.mass_kg * foot_vz, spin])
    rate = scipy.interpolate.CubicSpline(motion.time, momenta)(motion.time, 1)
    weight = feet.mass_kg * person.gravity_m_per_s2
    of_feet = np.zeros_like(motion.reaction)
    of_feet[:, 1:4] = rate + np.column_stack([np.zeros_like(y), np.full(y.size, weight), weight * foot_y])
    of_feet[:, 3] += person.position_y_m * of_feet[:, 2]
    legs = motion.reaction - of_feet
    ankle_y, ankle_z = y + person.position_y_m, person.ankle_height_m
    torque = legs[:, 3] - ankle_y * legs[:, 2] + ankle_z * legs[:, 1]
    shares = {
        "left": (person.left_share, 1.0 - person.marked_share),
        "right": (1.0 - person.left_share, person.marked_share),
    }
    loads = {}
    for belt, (of_force, of_torque) in shares.items():
        reaction = of_force * legs + 0.5 * of_feet
        reaction[:, 3] += (of_torque - of_force) * torque
        x = lateral_m if belt == "right" else -lateral_m
        reaction[:, 4:] += np.column_stack([-x * reaction[:, 2], x * reaction[:, 1]])
        loads[belt] = replace(motion, reaction=reaction)
    return loads


def _reaction(person: PersonTruth, time: np.ndarray, states: np.ndarray) -> np.ndarray:
    """Wrench on the person about the plate's origin, from the rates of its momenta."""
    chain = segments(person)
    a = _carried(chain)
    mass = np.array([segment.mass_kg for segment in chain])
    inertia = np.array([segment.inertia_kgm2 for segment in chain])
    y, v, th, w = states[:, 0], states[:, 1], states[:, 3:6], states[:, 6:9]
    tilt, w_f = states[:, 9], states[:, 10]
    both_feet = feet_of(person)
    foot_kg = both_feet.mass_kg
    foot_y, foot_z, foot_vy, foot_vz = _feet_com(person, y, v, tilt, w_f)
    com_y, com_z = y[:, None] + np.sin(th) @ a.T, person.ankle_height_m + np.cos(th) @ a.T
    com_vy, com_vz = v[:, None] + (np.cos(th) * w) @ a.T, -(np.sin(th) * w) @ a.T
    momentum_y = com_vy @ mass + foot_kg * foot_vy
    momentum_z = com_vz @ mass + foot_kg * foot_vz
    # about x, right-handed (positive turns y towards z); th turns z towards y, hence its minus
    spin_x = (com_y * com_vz - com_z * com_vy) @ mass - w @ inertia - both_feet.inertia_kgm2 * w_f
    spin_x += foot_kg * (foot_y * foot_vz - foot_z * foot_vy)
    rate = scipy.interpolate.CubicSpline(time, np.column_stack([momentum_y, momentum_z, spin_x]))(time, 1)
    g = person.gravity_m_per_s2
    fy = rate[:, 0]
    fz = rate[:, 1] + (mass.sum() + foot_kg) * g
    weight = g * (com_y @ mass + foot_kg * foot_y)
    mx = rate[:, 2] + weight + person.position_y_m * fz
    my = -person.position_x_m * fz
    mz = person.position_x_m * fy
    return np.column_stack([np.zeros_like(fy), fy, fz, mx, my, mz])


def true_ankles(
    person: PersonTruth, task: TaskTruth, motion: PersonMotion, trigger_s: float
) -> StandingMotion:
    """True motion of the ankles, for the comparison of estimates with the truth only.

    motion: exact motion of the rig.
    trigger_s: instant from which the trial counts its time.
    Returns: mean angle of both ankles from quiet standing, their torques, and the torques of the marked
    ankle.
    """
    rate = motion.rates[:, 0] - motion.foot_rate
    swung = motion.angles[:, 0] - person.stance_rad[0]
    angle = swung - motion.foot
    torque = task.stiffness_Nm_per_rad[0] * angle + task.damping_Nms_per_rad[0] * rate
    torque += task.short_range_Nm_per_rad * motion.short_range
    return StandingMotion(
        time=motion.time - trigger_s,
        angle=angle,
        rate=rate,
        acceleration=np.gradient(rate, motion.time),
        torque=torque,
        active=motion.active,
        marked_angle=marked_shank(person, swung) - marked_tilt(person, motion.foot),
        marked_torque=person.marked_share * torque,
    )


def marked_shank(person: PersonTruth, swung: np.ndarray) -> np.ndarray:
    """Rotation of the marked shank (rad) from the mean of both (rad), which is unchanged."""
    return person.marked_rotation * swung


def marked_tilt(person: PersonTruth, tilt: np.ndarray) -> np.ndarray:
    """Tilt of the marked foot (rad) from the mean of both: equal stiffness, each with its leg's torque."""
    return 2.0 * person.marked_share * tilt
