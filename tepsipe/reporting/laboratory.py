"""The simulated laboratory: mechanisms that are on, constants drawn around what is known, constants inferred.

Like the comparison with the truth, this is a part of the library that is given the laboratory's constants; it
computes nothing with them.
"""

from dataclasses import dataclass

import numpy as np

from tepsipe.io.tables import Table

MECHANISM, DRAWN, INFERRED, TRUE = "mechanism", "drawn", "inferred", "true"


@dataclass(frozen=True)
class Mechanism:
    """A mechanism that a laboratory may have."""

    section: str
    """Experiment that has it; ``treadmill`` is every experiment on the treadmill."""
    key: str
    """Constant by which it is measured, 0 where it is off; its name ends in its unit."""
    name: str
    """What it is."""


MECHANISMS = (
    Mechanism("treadmill", "treadmill.plate.bristle_share", "bristles of the belt"),
    Mechanism("treadmill", "treadmill.plate.friction_lever_m", "height at which belt friction acts"),
    Mechanism("treadmill", "treadmill.plate.belt_lag_wander", "varying lag of the belt"),
    Mechanism(
        "treadmill",
        "treadmill.plate.second_share",
        "second mode of the frame, in the fore-aft force and in the pitch moment",
    ),
    Mechanism("treadmill", "treadmill.plate.mount_share", "mounts of the deck"),
    Mechanism("treadmill", "treadmill.plate.floor_m_per_s2", "vibration of the floor"),
    Mechanism("dummy", "dummy.rubber.softening", "softening of the rubber"),
    Mechanism("dummy", "dummy.rubber.softening_power", "softening of the rubber with a power of its bending"),
    Mechanism("dummy", "dummy.rubber.bristle_Nm_per_rad", "friction within the rubber"),
    Mechanism("dummy", "dummy.rubber.relaxation_share", "relaxation of the rubber"),
    Mechanism("dummy", "dummy.foot_tilt.compliance_rad_per_Nm", "tilt of the dummy's foot"),
    Mechanism("dummy", "dummy.wobble.growing_per_m", "bending of the rod"),
    Mechanism("dummy", "dummy.wobble.common", "common wobble of the leg's markers"),
    Mechanism("dummy", "dummy.slip.foot_m", "slip of the foot's markers in every pulse"),
    Mechanism("dummy", "dummy.slip.ankle_m", "slip of the ankle's marker in every pulse"),
    Mechanism("standing", "standing.skin.shank_share", "soft tissue of the shanks"),
    Mechanism("standing", "standing.skin.thigh_share", "soft tissue of the thighs"),
    Mechanism("standing", "standing.skin.slip_m_per_rad", "skin over the ankle"),
    Mechanism("standing", "standing.person.foot_stiffness_Nm_per_rad", "soft feet"),
    Mechanism("standing", "standing.tasks.relax.short_range_Nm_per_rad", "short-range stiffness, relaxed"),
    Mechanism("standing", "standing.tasks.stiff.short_range_Nm_per_rad", "short-range stiffness, stiff"),
    Mechanism("standing", "standing.tasks.relax.medium_reflex_s_per_rad", "second reflex (M2), relaxed"),
    Mechanism("standing", "standing.tasks.stiff.medium_reflex_s_per_rad", "second reflex (M2), stiff"),
    Mechanism("standing", "standing.nerves.relaxation_s", "slow relaxation of the muscles"),
    Mechanism("wristalyzer", "wristalyzer.manipulator.friction_Nm", "friction of the manipulator"),
    Mechanism("wristalyzer", "wristalyzer.manipulator.contact_Nm_per_rad3", "hardening of the manipulator"),
    Mechanism("wristalyzer", "wristalyzer.manipulator.ripple_Nm", "torque ripple of the manipulator"),
)

# constants that the thesis does not print and that were chosen so that the laboratory returns its tables
INFERRED_CONSTANTS = (
    "dummy.rubber.stiffness_Nm_per_rad",
    "dummy.rubber.softening_angle_rad",
    "dummy.rubber.damping_Nms_per_rad",
    "dummy.rubber.softened_damping_Nms_per_rad",
    "dummy.subject.joint_inertia_kgm2",
    "dummy.rubber.softening",
    "dummy.markers.leg_m",
    "treadmill.capture.noise_m",
    "dummy.foot_tilt.compliance_rad_per_Nm",
    "dummy.wobble.growing_per_m",
    "wristalyzer.manipulator.inertia_kgm2",
    "wristalyzer.manipulator.torque_per_factor_Nm",
    "wristalyzer.manipulator.contact_Nm_per_rad3",
    "wristalyzer.manipulator.friction_Nm",
    "wristalyzer.manipulator.friction_rate_rad_per_s",
    "wristalyzer.manipulator.ripple_Nm",
    "wristalyzer.manipulator.ripple_bandwidth_hz",
)

# constants of the plate that a treadmill model estimates
TRUE_CONSTANTS = (
    "treadmill.plate.resonance_hz",
    "treadmill.plate.resonance_mass_kg",
    "treadmill.plate.second_share",
)


@dataclass(frozen=True)
class LaboratoryRow:
    """One mechanism, or one constant that was drawn, inferred from the thesis's tables, or estimated."""

    kind: str
    """{"mechanism", "drawn", "inferred", "true"}: Which of them."""
    key: str
    name: str
    """Its path among the constants, whose last word ends in the unit; what a mechanism is."""
    nominal: float | None
    """What the analysis may know (unit of the key); None unless it was drawn."""
    value: tuple[float, ...]
    """What the laboratory has (unit of the key); all 0 where a mechanism is off."""
    distribution: str = ""
    standard_deviation: float | None = None
    """From which a number was drawn (unit of the key); empty and None unless it was drawn."""


LABORATORY_ROWS = Table(LaboratoryRow, "mechanisms and drawn constants")


def laboratory_rows(truth: dict, experiments: list[str]) -> list[LaboratoryRow]:
    """Mechanisms, drawn numbers and inferred constants of a laboratory.

    truth: constants of the laboratory after drawing, or those of mechanisms, and ``drawn_numbers``: the
    numbers that were drawn, with their path, nominal number, value and distribution (units of their keys).
    experiments: experiments with simulated trials.
    Returns: mechanisms, then drawn numbers of these experiments and of the treadmill, if they are on it,
    then inferred constants, then those that a treadmill model estimates.
    """
    sections = {*experiments} | ({"treadmill"} & {*truth})
    if "weight" in experiments:
        sections.add("heavy_weight")
    rows = []
    for mechanism in MECHANISMS:
        value = _numbers(truth, mechanism.key)
        if value:
            rows.append(LaboratoryRow(MECHANISM, mechanism.key, mechanism.name, None, value))
    for drawn in truth.get("drawn_numbers", ()):
        if drawn["path"].partition(".")[0] not in sections:
            continue
        own = drawn["distribution"], drawn["standard_deviation"]
        rows.append(LaboratoryRow(DRAWN, drawn["path"], "", drawn["nominal"], (drawn["value"],), *own))
    for kind, paths in ((INFERRED, INFERRED_CONSTANTS), (TRUE, TRUE_CONSTANTS)):
        for path in paths:
            value = _numbers(truth, path)
            if value:
                rows.append(LaboratoryRow(kind, path, "", None, value))
    return rows


def _numbers(truth: dict, path: str) -> tuple[float, ...]:
    """Numbers at a path of keys (unit of the key), those of a list in their order; none where it is not."""
    place = truth
    for key in path.split("."):
        place = place.get(key) if isinstance(place, dict) else None
    if place is None:
        return ()
    return tuple(float(number) for number in np.ravel(place))
