"""Input and output of every engine: dummies on a belt in motion, and their simulated motion and forces."""

import math
from dataclasses import dataclass
from typing import Annotated, TypeVar

import numpy as np
import scipy

from tepsipe.mechanics.inverse_dynamics import Foot, Leg

FALLEN_RAD = 0.5 * np.pi
Angle = TypeVar("Angle", float, np.ndarray)


@dataclass(frozen=True)
class Joint:
    """Joint between foot and leg: thesis eq (2-1), and the softening of a rubber joint.

        tau = I theta'' + B theta' + K b - q (C b - B_s theta'),   q = b^2 / (b^2 + phi_h^2)

    b = theta - theta_ref is the bending. Without C and B_s the joint is linear, as in the thesis. The law is
    that of `rubber_joint` with C = S K, and of the joint likelihood.
    """

    inertia_Nms2_per_rad: float
    """I (N·m·s²/rad), without the leg's own; may be negative as long as J is not."""
    damping_Nms_per_rad: float
    """B (N·m·s/rad); may be negative."""
    stiffness_Nm_per_rad: float
    """K (N·m/rad); may be negative."""
    rest_angle_rad: float = 0.0
    """theta_ref (rad), at which the joint is not bent."""
    softening_Nm_per_rad: float = 0.0
    """C, stiffness that complete softening takes away."""
    softened_damping_Nms_per_rad: float = 0.0
    """B_s, damping that complete softening adds."""
    half_softening_rad: float = math.inf
    """phi_h, bending at which half of the softening has taken place (rad); infinite for a linear joint."""

    @property
    def softens(self) -> bool:
        """True if the joint is not linear."""
        return self.softening_Nm_per_rad != 0.0 or self.softened_damping_Nms_per_rad != 0.0

    def softened(self, bending: Angle, rate: Angle) -> Angle:
        """Torque that softening takes away (N·m), q (C b - B_s b'), at bending (rad) and rate (rad/s)."""
        share = bending**2 / (bending**2 + self.half_softening_rad**2)
        return share * (self.softening_Nm_per_rad * bending - self.softened_damping_Nms_per_rad * rate)

    def resistance(self, theta: Angle, theta_d: Angle) -> Angle:
        """Torque tau - I theta'' (N·m) at angle (rad) and rate (rad/s)."""
        bending = theta - self.rest_angle_rad
        linear = self.damping_Nms_per_rad * theta_d + self.stiffness_Nm_per_rad * bending
        return linear - self.softened(bending, theta_d) if self.softens else linear


@dataclass(frozen=True)
class Start:
    """Initial state of a simulation."""

    angle_rad: float
    rate_rad_per_s: float
    """theta (rad) and theta' (rad/s) at the first instant."""


UPRIGHT = Start(0.0, 0.0)


@dataclass(frozen=True)
class Task:
    """Dummies that differ in their joints, the motion of their feet, and the clock, already checked."""

    leg: Leg
    foot: Foot
    """Segments (kg, m, kg·m²)."""
    joints: tuple[Joint, ...]
    """I, B, K, theta_ref and softening of each (units in `Joint`)."""
    velocity: "scipy.interpolate.CubicSpline"
    """Velocity of the belt (m/s) over the time since the first sample (s)."""
    path: "scipy.interpolate.PPoly"
    """Its integral (m), zero at the first sample."""
    samples: int
    """Number of recorded instants."""
    interval_s: float
    """Time between them."""
    stride: int
    """Steps of the simulation per recorded instant."""
    start: Start
    """theta (rad) and theta' (rad/s) of every leg at the first instant."""

    @property
    def step_s(self) -> float:
        """Step of the simulation h (s)."""
        return self.interval_s / self.stride

    @property
    def steps(self) -> int:
        """Number of instants a step apart, the first and the last sample's among them (samples)."""
        return (self.samples - 1) * self.stride + 1

    def elapsed(self, samples: int) -> np.ndarray:
        """Leading recorded instants, counted from the first (s), shape (samples,)."""
        return self.interval_s * np.arange(samples)


@dataclass(frozen=True)
class Swing:
    """Motion of the leg and forces on the foot, at the recorded instants before a fall."""

    theta: np.ndarray
    theta_d: np.ndarray
    theta_dd: np.ndarray
    """Leg angle (rad), its rate (rad/s) and acceleration (rad/s²)."""
    f_y: Annotated[np.ndarray, "(n,)", "N"]
    f_z: Annotated[np.ndarray, "(n,)", "N"]
    """Force of the belt on the foot."""
    m_x: np.ndarray
    """Moment of the belt on the foot about the x axis (N·m), in the belt's surface where the ankle starts."""
    f_ay: Annotated[np.ndarray, "(n,)", "N"]
    f_az: Annotated[np.ndarray, "(n,)", "N"]
    """Force of the leg on the foot."""
    fell_after_s: float | None
    """Time from the first instant to the first step at which |theta| exceeds a quarter turn."""


def in_world_frame(theta: np.ndarray, across: np.ndarray, along: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Components y and z (N) of a force given across and along a leg that is turned by theta (rad)."""
    s, c = np.sin(theta), np.cos(theta)
    return c * across + s * along, c * along - s * across
