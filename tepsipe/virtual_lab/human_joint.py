"""A human joint under imposed random steps: mechanics that a model of I, B, K and a reflex does not contain.

Short-range stiffness is a Dahl element, whose torque approaches its limit exponentially, or a Maxwell
element, whose torque relaxes. The reflex is the torque of a second-order muscle behind a delay and a velocity
threshold. The slow torque of the person is an Ornstein-Uhlenbeck process.
"""

from dataclasses import dataclass
from typing import Annotated, NamedTuple

import numpy as np
import scipy

RATE_HZ = 1000.0


@dataclass(frozen=True)
class HumanJoint:
    """Hidden constants of the joint and of the actuator that moves it."""

    inertia_kgm2: float = 0.014
    damping_Nms_per_rad: float = 0.7
    stiffness_Nm_per_rad: float = 60.0
    """Inertia, damping and stiffness beyond the short range."""
    short_range: str | None = None
    """{"dahl", "maxwell"}: Element of the short range; None for none."""
    short_range_Nm_per_rad: float = 25.0
    """Stiffness of this element."""
    yield_rad: float = 0.005
    """Movement within which a Dahl element yields."""
    relaxation_s: float = 0.07
    """Time in which a Maxwell element relaxes."""
    reflex_gain_Nms_per_rad: float = 10.0
    """Torque of the reflex per velocity above the threshold."""
    reflex_delay_s: float = 0.043
    """Delay of the reflex."""
    reflex_threshold_rad_per_s: float = 0.15
    """Velocity at which the reflex begins."""
    muscle_hz: float = 2.2
    """Natural frequency of the muscle."""
    muscle_damping: float = 0.9
    """Damping ratio of the muscle."""
    slow_torque_Nm: float = 0.25
    """Standard deviation of the slow torque."""
    slow_torque_s: float = 1.0
    """Its correlation time."""
    step_rad: float = 0.03
    """Largest deviation of a step from the mean angle."""


class HumanRecord(NamedTuple):
    """Exact signals of a joint, before any instrument."""

    time: Annotated[np.ndarray, "(n,)", "s"]
    angle: Annotated[np.ndarray, "(n,)", "rad"]
    torque: Annotated[np.ndarray, "(n,)", "N·m"]
    """Torque that resists the movement, from its mean."""
    linear: Annotated[np.ndarray, "(3,)"]
    """I (N·m·s²/rad), B (N·m·s/rad) and K (N·m/rad) of the linear joint nearest to the intrinsic one."""


def imposed_angle(rng: np.random.Generator, step_rad: float, seconds: float) -> np.ndarray:
    """Random steps every 0.1 to 0.4 s as an actuator of 18 Hz follows them (rad), shape (n,)."""
    count = int(seconds * RATE_HZ)
    holds = rng.uniform(0.1, 0.4, int(seconds / 0.1))
    at = np.searchsorted(np.cumsum(holds), np.arange(count) / RATE_HZ)
    levels = step_rad * rng.uniform(-1.0, 1.0, holds.size + 1)
    w = 2.0 * np.pi * 18.0
    follower = scipy.signal.cont2discrete(([w**2], [1.0, 1.6 * w, w**2]), 1.0 / RATE_HZ)
    return scipy.signal.lfilter(np.ravel(follower[0]), follower[1], levels[at])


def short_range_torque(joint: HumanJoint, angle: np.ndarray) -> np.ndarray:
    """Torque of the element of the short range (N·m), shape (n,)."""
    if joint.short_range is None:
        return np.zeros(angle.size)
    stiffness = joint.short_range_Nm_per_rad
    steps = np.diff(angle, prepend=angle[:1])
    if joint.short_range == "maxwell":
        keep = np.exp(-1.0 / (RATE_HZ * joint.relaxation_s))
        return scipy.signal.lfilter([stiffness], [1.0, -keep], steps)
    deflection, deflections, limit = 0.0, [], joint.yield_rad
    for step in steps.tolist():
        # dz = dtheta (1 - z / limit sign(dtheta)), its exact solution over a step
        end = limit if step > 0.0 else -limit
        deflection = end + (deflection - end) * np.exp(-abs(step) / limit)
        deflections.append(deflection)
    return stiffness * np.array(deflections)


def move_human_joint(joint: HumanJoint, seconds: float, rng: np.random.Generator) -> HumanRecord:
    """Move the joint for some seconds, and return its exact signals."""
    angle = imposed_angle(rng, joint.step_rad, seconds)
    time = np.arange(angle.size) / RATE_HZ
    # central differences would make the acceleration 0.4 % too small, and so the inertia
    path = scipy.interpolate.make_interp_spline(time, angle, 5)
    velocity, acceleration = path.derivative(1)(time), path.derivative(2)(time)
    short = short_range_torque(joint, angle)
    motion = np.column_stack([acceleration, velocity, angle, np.ones_like(angle)])
    intrinsic = np.array([joint.inertia_kgm2, joint.damping_Nms_per_rad, joint.stiffness_Nm_per_rad])
    linear = intrinsic + np.linalg.lstsq(motion, short, rcond=None)[0][:3]
    late = np.roll(velocity, round(joint.reflex_delay_s * RATE_HZ))
    late[: round(joint.reflex_delay_s * RATE_HZ)] = 0.0
    w = 2.0 * np.pi * joint.muscle_hz
    muscle = scipy.signal.cont2discrete(([w**2], [1.0, 2.0 * joint.muscle_damping * w, w**2]), 1.0 / RATE_HZ)
    stretched = np.maximum(late - joint.reflex_threshold_rad_per_s, 0.0)
    reflex = joint.reflex_gain_Nms_per_rad * scipy.signal.lfilter(np.ravel(muscle[0]), muscle[1], stretched)
    keep = np.exp(-1.0 / (joint.slow_torque_s * RATE_HZ))
    drive = joint.slow_torque_Nm * np.sqrt(1.0 - keep**2) * rng.standard_normal(angle.size)
    slow = scipy.signal.lfilter([1.0], [1.0, -keep], drive)
    return HumanRecord(time, angle, motion[:, :3] @ intrinsic + short + reflex + slow, linear)
