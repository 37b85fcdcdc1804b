"""The joint as a second-order system: inertia I, damping B, stiffness K (thesis eqs 2-1, 3-5, 3-9).

    tau(t) = I theta'' + B theta' + K (theta - theta_ref)

    H(s) = theta(s) / tau(s) = 1 / (I s^2 + B s + K),   s = j 2 pi f

The thesis prints s = lambda + j2f; the factor pi is needed for f in Hz.
"""

from functools import lru_cache
from typing import Annotated

import numpy as np
import scipy

PARAMETERS = ("I", "B", "K")
# the same of small movements
SMALL = tuple(f"{name}_small" for name in PARAMETERS)
# quantities, as tables and results name them -> unit, as files write it
UNITS = {
    "mass": "kg",
    "I": "Nms2/rad",
    "B": "Nms/rad",
    "K": "Nm/rad",
    # part of the torque that does not depend on the motion, and time by which the angle is late
    "offset": "Nm",
    "delay": "s",
    # a joint that softens, hardens or rubs
    "I_small": "Nms2/rad",
    "B_small": "Nms/rad",
    "K_small": "Nm/rad",
    "K_softened": "Nm/rad",
    "B_softened": "Nms/rad",
    "softening_angle": "rad",
    "K_cubic": "Nm/rad3",
    "friction": "Nm",
    # a joint with muscles
    "K_working": "Nm/rad",
    "K_short_range": "Nm/rad",
    "yield_angle": "rad",
    "K_relaxing": "Nm/rad",
    "relaxation_time": "s",
    "K_growth": "Nm/rad2",
    "K_reflex": "Nm/rad",
    "B_reflex": "Nms/rad",
    "reflex_peak": "Nm",
    "reflex_impulse": "Nms",
    "reflex_gain": "Nms/rad",
    "reflex_gain_slope": "Nms/rad2",
    "unloading_gain": "Nms/rad",
    "reflex_delay": "s",
    "reflex_threshold": "rad/s",
    "reflex_frequency": "Hz",
    "reflex_damping": "1",
}
# units of an array of I, B, K
PARAMETER_UNITS = ", ".join(UNITS[name] for name in PARAMETERS)


def admittance(
    parameters: Annotated[np.ndarray, "(3,)"], frequency_hz: np.ndarray
) -> Annotated[np.ndarray, "(n,)", "rad/(N·m)"]:
    """Frequency response theta/tau of the joint.

    frequency_hz: Frequencies.
    """
    inertia, damping, stiffness = parameters
    s = 2j * np.pi * frequency_hz
    return 1.0 / (inertia * s**2 + damping * s + stiffness)


def smeared_admittance(
    parameters: Annotated[np.ndarray, "(3,)"], frequency_hz: np.ndarray, resolution_hz: float
) -> Annotated[np.ndarray, "(n,)", "rad/(N·m)"]:
    """Frequency response of the joint, averaged over a band of ``resolution_hz`` around each frequency."""
    # midpoints of nine equal parts of each band
    places = resolution_hz * (np.arange(9) - 4.0) / 9.0
    around = np.maximum(frequency_hz[:, None] + places, 1e-9)
    return admittance(parameters, around.ravel()).reshape(around.shape).mean(axis=1)


def impedance_torque(
    parameters: Annotated[np.ndarray, "(3,)"], theta: np.ndarray, theta_d: np.ndarray, theta_dd: np.ndarray
) -> Annotated[np.ndarray, "(n,)", "N·m"]:
    """Torque of the joint for a known motion, thesis eq (3-9).

    theta, theta_d, theta_dd: angle from its reference (rad), its rate (rad/s) and acceleration (rad/s²).
    Returns: tau.
    """
    inertia, damping, stiffness = parameters
    return inertia * theta_dd + damping * theta_d + stiffness * theta


def simulate_angle(
    parameters: Annotated[np.ndarray, "(3,)"], torque: Annotated[np.ndarray, "(n,)", "N·m"], rate_hz: float
) -> np.ndarray:
    """Angle of a joint that starts at rest, for a torque that is linear between its samples.

    parameters: I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad); I must not be 0.
    torque: tau.
    Returns: theta (rad); not finite if the parameters are unstable and the torque lasts long enough.
    """
    return scipy.signal.lfilter(*_discrete(*map(float, parameters), rate_hz), torque)


# a fit requests the angles for several torques of the same joint, one after the other
@lru_cache(maxsize=8)
def _discrete(
    inertia: float, damping: float, stiffness: float, rate_hz: float
) -> tuple[np.ndarray, np.ndarray]:
    """Numerator and denominator of a joint as a filter of torques that are linear between samples."""
    numerator, denominator, _ = scipy.signal.cont2discrete(
        ([1.0], [inertia, damping, stiffness]), 1.0 / rate_hz, method="foh"
    )
    return np.ravel(numerator), denominator
