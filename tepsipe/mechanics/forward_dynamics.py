"""Forward simulation of the ankle dummy (thesis sections 2-1-3 and 3-1-3).

The foot follows its recorded markers or the recorded belt and does not rotate; the leg rotates about the
ankle against the joint:

    tau = I theta'' + B theta' + K (theta - theta_ref)                                             (2-1)
    J theta'' = m g r sin(theta) - m r y_f'' cos(theta) - B theta' - K (theta - theta_ref),
    J = I_l + m r^2 + I

A joint that softens has further terms (`tepsipe.mechanics.engines.interface.Joint`).

Symbols: theta leg angle, positive when the leg tips towards +y (rad); y_f position of the foot (m); I, B, K,
theta_ref of the joint; m, r, I_l, g of the leg and m_f, l_f of the foot as in `inverse_dynamics`.

An engine simulates the dummy (`tepsipe.mechanics.engines`): PyBullet or MuJoCo with rigid bodies in place of
the second equation, or a Runge-Kutta method that integrates it. This module holds what the engines share: the
checks of the input and the result.
"""

import cmath
import math
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
import scipy

from tepsipe.errors import InputError
from tepsipe.mechanics.engines import resolved_engine, simulate
from tepsipe.mechanics.engines.interface import FALLEN_RAD, UPRIGHT, Joint, Start, Swing, Task
from tepsipe.mechanics.inverse_dynamics import Foot, Leg

STANDING_ITERATIONS = 50  # of the bending at rest
LARGEST_PHASE_RAD = 0.1  # natural frequency times step: 63 steps per period


@dataclass(frozen=True)
class ForwardSimulation:
    """Simulated motion, torque and forces at the recorded instants, up to the fall if the leg falls."""

    time: np.ndarray
    """Recorded instants (s), fewer than given if the leg falls."""
    theta: np.ndarray
    theta_d: np.ndarray
    theta_dd: np.ndarray
    """Leg angle (rad), its rate (rad/s) and acceleration (rad/s²)."""
    torque: np.ndarray
    """tau of eq (2-1), with the softening of the joint (N·m), positive when it resists positive theta."""
    foot_y: np.ndarray
    foot_y_d: np.ndarray
    foot_y_dd: np.ndarray
    """Position of foot and ankle from where they start (m), velocity (m/s) and acceleration (m/s²)."""
    y_dd: Annotated[np.ndarray, "(n,)", "m/s²"]
    z_dd: Annotated[np.ndarray, "(n,)", "m/s²"]
    """Acceleration of the leg's centre of mass."""
    f_y: np.ndarray
    f_z: np.ndarray
    """Ground reaction, force of the belt on the foot (N), as F_y and F_z in eq (3-7)."""
    m_x: np.ndarray
    """Moment of the belt on the foot about the x axis (N·m), in the belt's surface where the ankle starts."""
    f_ay: np.ndarray
    f_az: np.ndarray
    """Joint reaction, force of the leg on the foot (N), as F_Ay and F_Az in eq (3-7): -m y'', -m (g +
    z'')."""
    state: str
    """{"settles", "grows", "falls"}: Whether theta passes a quarter turn (falls); if not, whether small
    swings about upright grow, by negative damping or K < m g r, or settle."""
    growth_per_s: float
    """Rate at which small swings about upright grow once the belt rests (1/s), negative where they die out:
    -B / (2 J) of a leg that swings."""
    period_s: float
    """Period of small swings about upright (s); infinite for a leg that does not swing."""
    fell_at_s: float | None
    """Time at which theta passed a quarter turn (s), on the clock of ``time``; None unless the leg falls."""


def resting(leg: Leg, joint: Joint, standing_angle: float) -> Joint:
    """The same joint (units in `Joint`) with the theta_ref on which the leg stands at an angle (rad).

    (K - C q) (theta - theta_ref) = m g r sin(theta). Softening is found by iteration: a leg at rest bends the
    joint far less than phi_h.
    """
    gravity_moment = leg.mass_kg * leg.gravity_m_per_s2 * leg.com_m * math.sin(standing_angle)
    bending = 0.0
    for _ in range(STANDING_ITERATIONS):
        bending = (gravity_moment + joint.softened(bending, 0.0)) / joint.stiffness_Nm_per_rad
    return replace(joint, rest_angle_rad=standing_angle - bending)


def simulate_dummy(
    time: np.ndarray,
    belt_velocity: Annotated[np.ndarray, "(n,)", "m/s"],
    leg: Leg,
    foot: Foot,
    joint: Joint,
    step_s: float,
    engine: str,
    start: Start = UPRIGHT,
) -> ForwardSimulation:
    """Simulate the dummy's leg for a recorded velocity of the belt, as `simulate_dummies` with one joint.

    joint: I, B, K, theta_ref and softening (units in `Joint`).
    """
    return simulate_dummies(time, belt_velocity, leg, foot, {"": joint}, step_s, engine, start)[""]


def simulate_dummies(
    time: np.ndarray,
    belt_velocity: Annotated[np.ndarray, "(n,)", "m/s"],
    leg: Leg,
    foot: Foot,
    joints: dict[str, Joint],
    step_s: float,
    engine: str,
    start: Start = UPRIGHT,
) -> dict[str, ForwardSimulation]:
    """Simulate the dummy's leg with each of several joints for a recorded velocity of the belt.

    The belt velocity is interpolated by a cubic spline. A leg beyond a quarter turn has fallen: its
    simulation stops, and its result ends with the last recorded instant before the fall.

    time: recorded instants (s), on a regular clock.
    joints: I, B, K, theta_ref and softening of each (units in `Joint`).
    step_s: step of the simulation (s), a whole part of the sampling interval.
    engine: {"pybullet", "mujoco", "equations", "auto"}: Engine of the simulation; "auto" takes the first of
    the others that is installed.
    start: theta and theta' at the first instant.
    """
    engine = resolved_engine(engine)
    time, belt_velocity = np.asarray(time, dtype=float), np.asarray(belt_velocity, dtype=float)
    interval = _sampling_interval(time, belt_velocity)
    stride = 1
    for joint in joints.values():
        _check_dummy(leg, foot, joint, start)
        stride = _check_step(step_s, interval, leg, joint)
    velocity = scipy.interpolate.CubicSpline(interval * np.arange(time.size), belt_velocity)
    path = velocity.antiderivative()
    task = Task(
        leg=leg,
        foot=foot,
        joints=tuple(joints.values()),
        velocity=velocity,
        path=path,
        samples=time.size,
        interval_s=interval,
        stride=stride,
        start=start,
    )
    swings = zip(joints.items(), simulate(engine, task), strict=True)
    return {name: _simulation(task, time, belt_velocity, joint, swing) for (name, joint), swing in swings}


def _simulation(
    task: Task, time: np.ndarray, belt_velocity: np.ndarray, joint: Joint, swing: Swing
) -> ForwardSimulation:
    """Swing of a leg with what follows from it and from the motion of the belt (s, m/s)."""
    leg = task.leg
    theta, theta_d, theta_dd = swing.theta, swing.theta_d, swing.theta_dd
    samples = theta.size
    elapsed = task.elapsed(samples)
    foot_y_dd = task.velocity(elapsed, 1)
    s, c, r = np.sin(theta), np.cos(theta), leg.com_m
    swinging = _small_swing(leg, joint)
    return ForwardSimulation(
        time=time[:samples],
        theta=theta,
        theta_d=theta_d,
        theta_dd=theta_dd,
        torque=joint.inertia_Nms2_per_rad * theta_dd + joint.resistance(theta, theta_d),
        foot_y=task.path(elapsed),
        foot_y_d=belt_velocity[:samples].copy(),
        foot_y_dd=foot_y_dd,
        y_dd=foot_y_dd + r * (c * theta_dd - s * theta_d**2),
        z_dd=-r * (s * theta_dd + c * theta_d**2),
        f_y=swing.f_y,
        f_z=swing.f_z,
        m_x=swing.m_x,
        f_ay=swing.f_ay,
        f_az=swing.f_az,
        state="falls" if swing.fell_after_s is not None else "grows" if swinging.real > 0.0 else "settles",
        growth_per_s=swinging.real,
        period_s=2.0 * math.pi / swinging.imag if swinging.imag > 0.0 else math.inf,
        fell_at_s=None if swing.fell_after_s is None else float(time[0]) + swing.fell_after_s,
    )


# ---- small swings -------------------------------------------------------------------------------


def _about_the_ankle(leg: Leg, joint: Joint) -> tuple[float, float]:
    """Moment of inertia J (kg·m²) and net stiffness K - m g r (N·m/rad) about the ankle."""
    about_ankle = leg.inertia_kgm2 + leg.mass_kg * leg.com_m**2 + joint.inertia_Nms2_per_rad
    upright = joint.stiffness_Nm_per_rad - leg.mass_kg * leg.gravity_m_per_s2 * leg.com_m
    return about_ankle, upright


def _small_swing(leg: Leg, joint: Joint) -> complex:
    """Root of J s^2 + B s + K - m g r = 0 with the larger real part (1/s, rad/s)."""
    about_ankle, upright = _about_the_ankle(leg, joint)
    b = joint.damping_Nms_per_rad
    return (cmath.sqrt(b * b - 4.0 * about_ankle * upright) - b) / (2.0 * about_ankle)


# ---- what cannot be simulated ------------------------------------------------------------------


def _sampling_interval(time: np.ndarray, belt_velocity: np.ndarray) -> float:
    if time.ndim != 1 or time.shape != belt_velocity.shape or time.size < 4:
        raise InputError(
            "motion of the belt: expected one velocity for each of at least 4 instants, found shapes "
            f"{belt_velocity.shape} and {time.shape}: give both as recorded"
        )
    for name, values in (("time", time), ("belt velocity", belt_velocity)):
        bad = np.flatnonzero(~np.isfinite(values))
        if bad.size:
            raise InputError(
                f"{name}: expected finite samples, found {bad.size} that are not, the first at sample "
                f"{bad[0] + 1}: fill or cut them first"
            )
    steps = np.diff(time)
    interval = float((time[-1] - time[0]) / steps.size)
    if (steps <= 0.0).any():
        k = int(np.argmax(steps <= 0.0))
        raise InputError(
            f"time: expected increasing instants, found {time[k]:.6g} s followed by {time[k + 1]:.6g} s at "
            f"sample {k + 2}: repair the time stamps first"
        )
    if np.abs(steps - interval).max() > 1e-4 * interval:
        raise InputError(
            f"time: expected a regular clock, found steps from {steps.min():.6g} s to {steps.max():.6g} s: "
            "resample the recording first"
        )
    return interval


def refuse_unstable(leg: Leg, joint: Joint) -> None:
    """Refuse a joint that cannot hold the leg upright, K <= m g r (N·m/rad)."""
    _, upright = _about_the_ankle(leg, joint)
    if upright <= 0.0:
        stiffness = joint.stiffness_Nm_per_rad
        raise InputError(
            f"stiffness of the joint: expected more than m g r = {stiffness - upright:.4g} Nm/rad, so that "
            f"the leg can stand, found {stiffness:.4g} Nm/rad: simulate with other parameters"
        )


def _check_dummy(leg: Leg, foot: Foot, joint: Joint, start: Start) -> None:
    for body in (leg, foot, joint):
        for name, value in vars(body).items():
            linear = name == "half_softening_rad" and value == math.inf
            if not math.isfinite(value) and not linear:
                raise InputError(f"{name}: expected a finite number, found {value}: correct it")
    for name, value in (("leg", leg.mass_kg), ("foot", foot.mass_kg)):
        if value <= 0.0:
            raise InputError(f"mass of the {name}: expected more than 0 kg, found {value:g} kg: correct it")
    about_ankle, _ = _about_the_ankle(leg, joint)
    if about_ankle <= 0.0:
        least = joint.inertia_Nms2_per_rad - about_ankle
        raise InputError(
            f"inertia of the joint: expected more than {least:.4g} Nms2/rad, so that leg and joint together "
            f"have inertia, found {joint.inertia_Nms2_per_rad:.4g} Nms2/rad: simulate with other parameters"
        )
    if joint.half_softening_rad <= 0.0:
        found = f"{joint.half_softening_rad:g} rad"
        raise InputError(f"half_softening_rad: expected more than 0 rad, found {found}: correct it")
    if not (abs(start.angle_rad) < FALLEN_RAD and math.isfinite(start.rate_rad_per_s)):
        raise InputError(
            "start: expected a leg within a quarter turn of upright and a finite rate, found "
            f"{start.angle_rad:g} rad and {start.rate_rad_per_s:g} rad/s: start it upright"
        )


def _check_step(step_s: float, interval: float, leg: Leg, joint: Joint) -> int:
    """Steps per sample."""
    stride = round(interval / step_s) if step_s > 0.0 and math.isfinite(step_s) else 0
    if stride < 1 or abs(stride * step_s - interval) > 1e-4 * interval:
        raise InputError(
            f"step of the simulation: expected a whole part of the sampling interval of {interval:.6g} s, "
            f"found {step_s:.6g} s: divide the interval by a whole number"
        )
    about_ankle, upright = _about_the_ankle(leg, joint)
    damping = abs(joint.damping_Nms_per_rad) + abs(joint.softened_damping_Nms_per_rad)
    fastest = max(math.sqrt(abs(upright) / about_ankle), damping / about_ankle)
    if step_s * fastest > LARGEST_PHASE_RAD:
        raise InputError(
            f"step of the simulation: expected at most {LARGEST_PHASE_RAD / fastest:.3g} s, a tenth of the "
            "joint's shorter time constant (1 / natural frequency, or J / B), "
            f"found {step_s:.6g} s: shorten the step"
        )
    return stride
