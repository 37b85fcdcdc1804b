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
from array import array
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
import scipy

from tepsipe.virtual_lab.belt import BeltMotion, DriveTruth
from tepsipe.virtual_lab.force_plate import Frame
from tepsipe.virtual_lab.integrate import stepper
from tepsipe.virtual_lab.moving_belt import MovingBelt
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
    state, out = float(rng.standard_normal()), np.empty(n)
    for k, step in enumerate(steps.tolist()):
        state = kept * state + step
        out[k] = state
    return nerves.wander_Nm * out


class Nerves:
    """Drive and active torque (N·m), step by step, from what was sensed a latency ago."""

    def __init__(
        self, subject: Subject, levers: list[float], steps: int, rate_hz: float, rng: np.random.Generator
    ):
        task, nerves = subject.task, subject.nerves
        self._nerves = nerves
        self._weights = [lever / sum(levers) for lever in levers]
        self._stance = subject.person.stance_rad
        self._wander = wander(nerves, steps + 2, rate_hz, rng).tolist()
        self._balance_late = _steps(nerves.balance_delay_s * rate_hz)
        muscles = [subject.muscles[name] for name in MUSCLES]
        # latencies in steps; the drive one step ahead is known, because every latency is longer than a step
        self._constants = [
            (
                tone,
                muscle.balance_per_Nm,
                gain,
                *_steps(muscle.latency_s * rate_hz),
                medium,
                *_steps(muscle.medium_latency_s * rate_hz),
                tuple(muscle.force_Nm),
                tuple(muscle.stretch),
            )
            for muscle, tone, gain, medium in zip(
                muscles, task.tone, task.reflex_s_per_rad, task.medium_reflex_s_per_rad, strict=True
            )
        ]
        self._to_x, self._to_v = _twitch(nerves, 1.0 / rate_hz)

    def stepper(self) -> Callable[[tuple[float, ...]], tuple[list[float], list[float]]]:
        """``step(state)``: drive and active torque at ankle, knee and hip (N·m) one step after ``state``.

        The first call, with the first state, returns the values at that state itself.
        """
        (f1, f2, f3), (s1, s2, s3) = self._weights, self._stance
        nerves, wandered, (balance_late, balance_part) = self._nerves, self._wander, self._balance_late
        by_angle, by_rate = nerves.balance_Nm_per_rad, nerves.balance_Nms_per_rad
        threshold = nerves.reflex_threshold_rad_per_s
        (xx, xv), (vx, vv) = self._to_x, self._to_v
        # for every muscle: constants, its stretch, and drive and twitch at the last step
        muscles = [(constants, [], [constants[0], constants[0], 0.0]) for constants in self._constants]
        leaned: list[float] = []
        k = -1

        def step(state: tuple[float, ...]) -> tuple[list[float], list[float]]:
            nonlocal k
            k += 1
            th1, th2, th3, w1, w2, w3, _, foot = state[3:11]
            if k:
                lean = f1 * (th1 - s1) + f2 * (th2 - s2) + f3 * (th3 - s3)
                rate = f1 * w1 + f2 * w2 + f3 * w3
                leaned.append(by_angle * lean + by_rate * rate)
            wanted = wandered[k]
            if k >= balance_late:
                before = leaned[k - balance_late]
                wanted += before + balance_part * (leaned[k - balance_late + 1] - before)
            side = 0 if wanted >= 0.0 else 1
            ankle, knee, hip = w1 - foot, w2 - w1, w3 - w2
            drives, ankle_Nm, knee_Nm, hip_Nm = [], 0.0, 0.0, 0.0
            for (
                (tone, balance, gain, late, part, medium, later, rest, (on_a, on_k, on_h), (a, b, c)),
                history,
                held,
            ) in muscles:
                if k:
                    history.append(a * ankle + b * knee + c * hip)
                e = tone + balance[side] * wanted
                if k >= late:
                    before = history[k - late]
                    stretch = before + part * (history[k - late + 1] - before) - threshold
                    if stretch > 0.0:
                        e += gain * stretch
                    if medium and k >= later:
                        before = history[k - later]
                        stretch = before + rest * (history[k - later + 1] - before) - threshold
                        if stretch > 0.0:
                            e += medium * stretch
                if e < 0.0:
                    e = 0.0
                drive, x, v = held
                if k:
                    drive = 0.5 * (drive + e)
                    over = x - drive
                    x, v = drive + xx * over + xv * v, vx * over + vv * v
                held[:] = e, x, v
                drives.append(e)
                over = x - tone
                ankle_Nm += on_a * over
                knee_Nm += on_k * over
                hip_Nm += on_h * over
            return drives, [ankle_Nm, knee_Nm, hip_Nm]

        return step


def _twitch(nerves: NervesTruth, step_s: float) -> tuple[tuple[float, float], tuple[float, float]]:
    """Exact solution for a constant drive e: x - e and T x' after a step, each from both before it."""
    rise_s, fall_s = nerves.twitch_s, nerves.relaxation_s or nerves.twitch_s
    if rise_s == fall_s:
        step = step_s / rise_s
        decay = math.exp(-step)
        return (decay * (1.0 + step), decay * step), (-decay * step, decay * (1.0 - step))
    a, b = 1.0 / rise_s, 1.0 / fall_s
    rising, falling = math.exp(-a * step_s), math.exp(-b * step_s)
    between = rising - falling
    return (
        ((b * rising - a * falling) / (b - a), a * between / (b - a)),
        (-b * between / (b - a), (b * falling - a * rising) / (b - a)),
    )


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
    command: Callable[[float], float],
    duration_s: float,
    rate_hz: float,
    rng: np.random.Generator,
    frames: Sequence[Frame] = (),
) -> PersonMotion:
    """Integrate belt, frame, body and nerves together.

    subject: constants of body, muscles, task and nerves.
    command: commanded belt velocity (m/s) at t (s).
    duration_s, rate_hz: length of the run (s) and steps per second (Hz).
    frames: of the belts below the feet; rigid ground without one.
    Returns: motion, drive, parts of the ankles' torque and reaction on the grid of the integration.
    """
    person, task = subject.person, subject.task
    belt = MovingBelt(drive, command, person.mass_kg * person.gravity_m_per_s2, rate_hz, frames)
    body = _body(person, belt.moving_kg)
    # torques of the muscles at the start of the step, their changes in it, and its start
    active = [0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]
    derivative = _derivative(person, task, belt, body, rate_hz, active)
    steps = math.ceil(duration_s * rate_hz)
    state = (0.0, 0.0, 0.0, *person.stance_rad, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, *belt.start)
    step, h = stepper(len(state)), 1.0 / rate_hz
    nerves_step = Nerves(subject, body.levers, steps, rate_hz, rng).stepper()
    driven, torques = nerves_step(state)
    states, drives, at_ankles = array("d", state), array("d", driven), array("d", torques[:1])
    for k in range(steps):
        driven, ahead = nerves_step(state)
        drives.extend(driven)
        active[:3] = torques
        active[3:6] = [after - before for before, after in zip(torques, ahead, strict=True)]
        active[6] = k / rate_hz
        torques = ahead
        at_ankles.append(ahead[0])
        belt.begin(k, state[1])
        state = step(derivative, k / rate_hz, state, h)
        states.extend(state)
        if not (-0.7 < state[3] < 0.7 and -0.7 < state[4] < 0.7 and -0.7 < state[5] < 0.7):
            raise FloatingPointError("the virtual person falls: check stiffness, damping and balance")
    states = np.array(states).reshape(steps + 1, -1)
    time = np.arange(steps + 1) / rate_hz
    motion, y, v = belt.motion(time, states[:, 0], states[:, 1], states[:, 12:])
    return PersonMotion(
        **motion,
        reaction=_reaction(person, time, y, v, states),
        angles=states[:, 3:6],
        rates=states[:, 6:9],
        drive=np.array(drives).reshape(steps + 1, -1),
        foot=states[:, 9],
        foot_rate=states[:, 10],
        short_range=states[:, 11],
        active=np.array(at_ankles),
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


# These functions return functions of numbers, not of arrays: the integration calls them 4000 times for each
# second of a trial.


def _derivative(
    person: PersonTruth,
    task: TaskTruth,
    belt: MovingBelt,
    body: _Body,
    rate_hz: float,
    active: list[float],
) -> Callable[[float, tuple[float, ...]], tuple[float, ...]]:
    """Rate of change of the state: y and v on the frame, the servo's, th, th', psi, psi', z, the frame's."""
    torques = _joint_torques(person, task, body, rate_hz, active)
    accelerations = _accelerations(body)
    pushed, rates = belt.pushed, belt.rates
    yielding = 1.0 / person.short_range_rad if person.short_range_rad else 0.0
    both_feet = feet_of(person)
    k_f, b_f = person.foot_stiffness_Nm_per_rad, person.foot_damping_Nms_per_rad
    depth = 0.5 * person.ankle_height_m
    to_foot = both_feet.inertia_kgm2 + both_feet.mass_kg * (person.foot_com_m**2 + depth**2)
    to_foot = 1.0 / to_foot if k_f else 0.0
    from_belt = both_feet.mass_kg * depth

    def derivative(t: float, state: tuple[float, ...]) -> tuple[float, ...]:
        _, v, q, _, _, _, w1, w2, w3, tilt, w_f, z, *frame = state
        belt_alone = pushed(t, v, q, frame)
        over, tau_a, tau_k, tau_h = torques(t, state)
        surface, d1, d2, d3 = accelerations(belt_alone[0], state, tau_a, tau_k, tau_h)
        d_f = to_foot * (over - k_f * tilt - b_f * w_f + from_belt * surface)
        w_a = w1 - w_f
        z_rate = w_a - abs(w_a) * z * yielding
        v_rate, q_rate, *frame_rates = rates(belt_alone, surface)
        return (v, v_rate, q_rate, w1, w2, w3, d1, d2, d3, w_f, d_f, z_rate, *frame_rates)

    return derivative


def _joint_torques(
    person: PersonTruth, task: TaskTruth, body: _Body, rate_hz: float, active: list[float]
) -> Callable[[float, tuple[float, ...]], tuple[float, ...]]:
    """Torque of the ankle beyond quiet standing, and torques of ankle, knee and hip (N·m)."""
    k_a, k_k, k_h = task.stiffness_Nm_per_rad
    b_a, b_k, b_h = task.damping_Nms_per_rad
    k_r = task.short_range_Nm_per_rad
    # quiet standing is an equilibrium: each joint bears the weight above it
    s1, s2, s3 = person.stance_rad
    load = [weight * math.sin(s) for weight, s in zip(body.weights, person.stance_rad, strict=True)]
    rest_h = load[2]
    rest_k = rest_h + load[1]
    rest_a = rest_k + load[0]

    def torques(t: float, state: tuple[float, ...]) -> tuple[float, ...]:
        th1, th2, th3, w1, w2, w3, tilt, w_f, z = state[3:12]
        now_a, now_k, now_h, more_a, more_k, more_h, began = active
        late = (t - began) * rate_hz
        over = k_a * (th1 - tilt - s1) + b_a * (w1 - w_f) + k_r * z + now_a + late * more_a
        tau_k = rest_k + k_k * (th2 - th1 - s2 + s1) + b_k * (w2 - w1) + now_k + late * more_k
        tau_h = rest_h + k_h * (th3 - th2 - s3 + s2) + b_h * (w3 - w2) + now_h + late * more_h
        return over, rest_a + over, tau_k, tau_h

    return torques


def _accelerations(body: _Body) -> Callable[..., tuple[float, float, float, float]]:
    """Accelerations of the belt (m/s²) and of the segments (rad/s²) by the equations of motion."""
    p1, p2, p3 = body.levers
    weight1, weight2, weight3 = body.weights
    h11, h22, h33 = np.diag(body.inertia).tolist()
    h12, h13, h23 = float(body.inertia[0, 1]), float(body.inertia[0, 2]), float(body.inertia[1, 2])
    moving = body.moving_kg
    sin, cos = math.sin, math.cos

    def accelerations(
        forced: float, state: tuple[float, ...], tau_a: float, tau_k: float, tau_h: float
    ) -> tuple[float, float, float, float]:
        th1, th2, th3, w1, w2, w3 = state[3:9]
        q1, q2, q3 = w1 * w1, w2 * w2, w3 * w3
        n1, n2, n3 = sin(th1), sin(th2), sin(th3)
        c1, c2, c3 = cos(th1), cos(th2), cos(th3)
        c12, n12 = c1 * c2 + n1 * n2, n1 * c2 - c1 * n2
        c13, n13 = c1 * c3 + n1 * n3, n1 * c3 - c1 * n3
        c23, n23 = c2 * c3 + n2 * n3, n2 * c3 - c2 * n3
        m12, m13, m23 = h12 * n12, h13 * n13, h23 * n23
        e1, e2, e3 = p1 * c1, p2 * c2, p3 * c3
        push = forced + p1 * n1 * q1 + p2 * n2 * q2 + p3 * n3 * q3
        f1 = weight1 * n1 - tau_a + tau_k - m12 * q2 - m13 * q3
        f2 = weight2 * n2 - tau_k + tau_h + m12 * q1 - m23 * q3
        f3 = weight3 * n3 - tau_h + m13 * q1 + m23 * q2
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
        belt = (push - e1 * d1 - e2 * d2 - e3 * d3) / moving
        return belt, d1, d2, d3

    return accelerations


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


def loads_of_legs(person: PersonTruth, motion: PersonMotion) -> dict[str, BeltMotion]:
    """Motion with the reaction of each leg's own plate (N, N·m): left, right.

    The feet are equal. The forces of the legs on them are shared as the weight is, their torques as
    `PersonTruth.marked_share` says of the right leg. Both ankles are at the same place along the belt.
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
        loads[belt] = replace(motion, reaction=reaction)
    return loads


def _reaction(
    person: PersonTruth, time: np.ndarray, y: np.ndarray, v: np.ndarray, states: np.ndarray
) -> np.ndarray:
    """Wrench on the person about the plate's origin, from the rates of its momenta.

    ``y`` and ``v`` are the motion of the ankles along the belt (m, m/s).
    """
    chain = segments(person)
    a = _carried(chain)
    mass = np.array([segment.mass_kg for segment in chain])
    inertia = np.array([segment.inertia_kgm2 for segment in chain])
    th, w = states[:, 3:6], states[:, 6:9]
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
