"""From a table of a person on a moving platform to one trial on one regular clock."""

from dataclasses import dataclass
from typing import Literal

import numpy as np

from tepsipe.errors import InputError
from tepsipe.ingest.even_table import recorded_columns, refuse_slow
from tepsipe.ingest.manipulators import RADIANS_PER_UNIT, refuse_exchanged
from tepsipe.io.trial import Signal, Trial
from tepsipe.quantities import AngleUnit, Rate, Sign, Time

JOINTS = ("ankle", "hip")
PERTURBATIONS = ("platform", "second_perturbation")


@dataclass(frozen=True)
class PlatformTableOptions:
    """Options for a table of a person on a moving platform."""

    resample_rate_hz: Rate
    """Rate of the trial, not above that of the recording."""
    max_gap_s: Time
    """Longest gap that is filled."""
    angle_unit: AngleUnit
    """Unit of the angles."""
    torque_sign: Sign
    """−1 if a torque that resists a positive angle is recorded as negative, otherwise 1."""
    platform_unit: Literal["m", "m/s", "m/s2"]
    """Position, velocity or acceleration of the platform; estimates do not depend on which."""

    @property
    def units(self) -> dict[str, str]:
        """Units in which the columns are read."""
        of_joint = {"angle": self.angle_unit, "torque": "Nm"}
        return {"time": "s"} | {
            f"{joint}_{what}": unit for joint in JOINTS for what, unit in of_joint.items()
        }


def ingest_platform(
    table: dict[str, np.ndarray], options: PlatformTableOptions, duration_s: float, name: str
) -> Trial:
    """Trial of a person on a moving platform.

    table: ``time`` (s), ``platform`` (in ``options.platform_unit``), ``ankle_angle``, ``hip_angle`` (in
    ``options.angle_unit``), ``ankle_torque``, ``hip_torque`` (N·m), and, if there is one,
    ``second_perturbation``.
    options: rate, longest gap, units and sign.
    duration_s: length of the trial by the protocol.
    name: names the source in messages.
    Returns: ``platform``, ``joint_angle`` and ``joint_torque`` (N·m, resists the angle) of ankle and hip,
    and ``second_perturbation``, if there is one.
    """
    perturbations = [key for key in PERTURBATIONS if key in table]
    keys = [*perturbations, *(f"{joint}_{what}" for what in ("angle", "torque") for joint in JOINTS)]
    recorded = recorded_columns(table, keys, options.max_gap_s, duration_s, name)
    columns = recorded.columns
    angles = slice(len(perturbations), len(perturbations) + 2)
    columns[:, angles] *= RADIANS_PER_UNIT[options.angle_unit]
    for k, joint in enumerate(JOINTS):
        refuse_exchanged(columns[:, angles.start + k], columns[:, angles.stop + k], name, joint)
    swing = float(np.ptp(columns[:, angles], axis=0).max())
    if swing > np.pi:
        raise InputError(
            f"{name}: expected joint angles within half a revolution, found a swing of {swing:.3g} rad when "
            f"read as {options.angle_unit}: correct angle_unit in the configuration or in the trial sheet"
        )
    rate = options.resample_rate_hz
    refuse_slow(recorded.recorded_hz, rate, "platform.ingest.resample_rate_hz", name)
    grid, even = recorded.resampled(columns, rate)
    steps = recorded.steps(rate)
    both = ("time", "joint")
    signals = {
        "platform": Signal(even[:, 0], options.platform_unit, ("time",), "motion of the platform", steps),
        "joint_angle": Signal(even[:, angles], "rad", both, "joint angles", steps),
        "joint_torque": Signal(
            options.torque_sign * even[:, angles.stop :],
            "Nm",
            both,
            "joint torques that resist the angles",
            steps,
        ),
    }
    if len(perturbations) > 1:
        signals["second_perturbation"] = Signal(even[:, 1], "1", ("time",), "second perturbation", steps)
    return Trial(
        rate_hz=rate,
        axes={"time": grid, "joint": np.array(JOINTS)},
        signals=signals,
        attributes=recorded.attributes,
    )
