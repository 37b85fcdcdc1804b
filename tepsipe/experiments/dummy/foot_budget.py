"""Uncertainty of I, B, K of the ankle dummy from the foot and the force plate, source by source.

The torque (`foot_torque`) is linear in forces, masses and lengths, and the parameters are linear in the
torque, so the contribution of a source is the fit to the change of the torque. Only the clock and the delay
of the markers after the forces change the regressors as well. Offsets of the leg's markers change the angle
by a constant, which is removed with the angle at rest.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np

from tepsipe.identification.budgets.leg import compliance_contributions
from tepsipe.identification.regression.windows import WindowedFits
from tepsipe.mechanics.inverse_dynamics import Foot
from tepsipe.mechanics.segment_kinematics import SegmentMotion
from tepsipe.signals.differentiation import derivative
from tepsipe.statistics.uncertainty import Budget, Source

FOOT_SOURCES = (
    "foot_mass_kg",
    "foot_com_m",
    "joint_offset_m",
    "anterior_offset_m",
    "force_scale",
    "vertical_leak",
    "origin_height_m",
    "log_delay_s",
    "marker_scale",
    "clock_ratio",
    "foot_compliance_rad_per_Nm",
)


@dataclass(frozen=True)
class FootKnowledge:
    """Foot and plate as a pathway assumes them, with their uncertainty."""

    foot: Foot
    """The foot (kg, m)."""
    loads: dict[str, np.ndarray]
    """Fy, Fz (N) and Mx (N·m) from which the torque is computed."""
    y_a: np.ndarray
    y_a_dd: np.ndarray
    """Position of the ankle on the plate (m) and its acceleration (m/s²)."""
    sources: Mapping[str, Source]
    """Uncertain constants; none if Type B is not evaluated."""


def changed_torques(known: FootKnowledge) -> dict[str, list[np.ndarray]]:
    """Source -> changes of the torque for its standard uncertainty, independent ones apart, (n,) (N·m)."""
    u = {name: source.standard_uncertainty for name, source in known.sources.items() if name in FOOT_SOURCES}
    f_y, f_z, m_x = (known.loads[key] for key in ("Fy", "Fz", "Mx"))
    m_f, l_f = known.foot.mass_kg, known.foot.height_m
    per_unit = {
        "foot_mass_kg": [-0.5 * l_f * known.y_a_dd],
        "foot_com_m": [m_f * known.y_a_dd],
        # offsets along the belt, and in height
        "joint_offset_m": [-f_z, f_y - m_f * known.y_a_dd],
        # offset of the marker on the ankle
        "anterior_offset_m": [-f_z],
        # scales of the fore-aft and of the vertical transducers, which also measure the moment
        "force_scale": [l_f * f_y, m_x - known.y_a * f_z],
        "vertical_leak": [l_f * f_z],
        "origin_height_m": [f_y],
        "marker_scale": [-known.y_a * f_z - 0.5 * m_f * l_f * known.y_a_dd],
    }
    return {name: [u[name] * x for x in per_unit[name]] for name in u if name in per_unit}


def delayed(motion: SegmentMotion, delay_s: float) -> SegmentMotion:
    """The leg's angle (rad) and its derivatives, read ``delay_s`` (s) later, to first order."""
    return replace(
        motion,
        theta=motion.theta + delay_s * motion.theta_d,
        theta_d=motion.theta_d + delay_s * motion.theta_dd,
        theta_dd=motion.theta_dd + delay_s * derivative(motion.time, motion.theta_dd),
    )


def foot_budget(
    fit: WindowedFits,
    reestimate: Callable[[SegmentMotion, np.ndarray], np.ndarray],
    motion: SegmentMotion,
    torque: Annotated[np.ndarray, "(n,)", "N·m"],
    known: FootKnowledge,
) -> Budget:
    """Uncertainty of the means of I, B, K (N·m·s²/rad, N·m·s/rad, N·m/rad).

    reestimate: estimates them, shape (3,), from another motion (s, rad) and torque (N·m), linear in the
    torque.
    motion: motion of the leg on the clock of the forces.
    known: assumed foot and plate, with their uncertainty.
    Returns: type A and one entry per source that acts.
    """
    contributions = {
        name: np.array([reestimate(motion, change) for change in changes])
        for name, changes in changed_torques(known).items()
    }
    shifts = {}
    if "log_delay_s" in known.sources:
        delay = known.sources["log_delay_s"].standard_uncertainty
        y_a_d, jerk = derivative(motion.time, known.y_a), derivative(motion.time, known.y_a_dd)
        rate = y_a_d * known.loads["Fz"] + 0.5 * known.foot.mass_kg * known.foot.height_m * jerk
        shifts["log_delay_s"] = (delayed(motion, delay), torque - delay * rate)
    if "clock_ratio" in known.sources:
        slower = 1.0 / (1.0 + known.sources["clock_ratio"].standard_uncertainty)
        slower_motion = replace(motion, theta_d=motion.theta_d * slower, theta_dd=motion.theta_dd * slower**2)
        inertia = 0.5 * known.foot.mass_kg * known.foot.height_m * known.y_a_dd
        shifts["clock_ratio"] = (slower_motion, torque - (slower**2 - 1.0) * inertia)
    for name, changed in shifts.items():
        contributions[name] = (reestimate(*changed) - fit.mean)[None]
    contributions |= compliance_contributions(fit.mean, known.sources)
    freedom = {name: known.sources[name].freedom for name in contributions}
    return Budget(*fit.type_a, contributions, freedom)
