"""Options of the recordings of manipulators and of a moving platform."""

from dataclasses import dataclass
from typing import Annotated, Literal

from tepsipe.quantities import AngleUnit, Rate, Sign, Thesis, Time

JOINTS = ("ankle", "hip")


@dataclass(frozen=True)
class ManipulatorOptions:
    """Options for a manipulator's recording."""

    resample_rate_hz: Annotated[Rate, Thesis("3-1-1")]
    """Rate of the trial."""
    max_gap_s: Time
    """Longest step between samples."""
    angle_unit: AngleUnit
    """Unit of the logged angle."""

    @property
    def units(self) -> dict[str, str]:
        """Units in which the columns of log and command are read."""
        return {"time": "s", "trigger_time": "s", "angle": self.angle_unit, "torque": "Nm"}


@dataclass(frozen=True)
class TableOptions:
    """Options for a table of a position-controlled manipulator."""

    resample_rate_hz: Rate
    """Rate of the trial, not above that of the recording."""
    max_gap_s: Time
    """Longest gap that is filled."""
    angle_unit: AngleUnit
    """Unit of the angle."""
    torque_sign: Sign
    """−1 if a torque that resists a positive angle is recorded as negative, otherwise 1."""

    @property
    def units(self) -> dict[str, str]:
        """Units in which the columns are read."""
        return {"time": "s", "angle": self.angle_unit, "torque": "Nm"}


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
