"""Settings of a person on a platform that moves forwards and backwards, from recordings."""

from typing import Literal

from tepsipe.experiments.platform import PlatformOptions
from workflow.settings.position_manipulator import TableIngest
from workflow.settings.quantities import (
    AngleUnit,
    Delimiter,
    Sign,
)
from workflow.settings.section import Section, made_from, setting


class PlatformColumns(Section):
    """Columns of the table."""

    time: str = setting("column: time (s)")
    platform: str = setting("column: motion of the platform (in `platform_unit`)")
    ankle_angle: str = setting("column: angle of the ankle (in `angle_unit`)")
    hip_angle: str = setting("column: angle of the hip (in `angle_unit`)")
    ankle_torque: str = setting("column: torque of the ankle (N·m)")
    hip_torque: str = setting("column: torque of the hip (N·m)")
    second_perturbation: str | None = setting(
        "column: a second perturbation, independent of the platform (any unit); null if there is none"
    )


class PlatformFiles(Section):
    """Tables of a recording."""

    columns: PlatformColumns
    delimiter: Delimiter = setting("delimiter of the table")
    angle_unit: AngleUnit = setting("unit of the angles")
    torque_sign: Sign = setting(
        "−1 if a torque that resists a positive angle is recorded as negative, otherwise 1"
    )
    platform_unit: Literal["m", "m/s", "m/s2"] = setting(
        "position, velocity or acceleration of the platform; estimates do not depend on which"
    )


class Platform(Section):
    """A person on a moving platform."""

    files: PlatformFiles
    ingest: TableIngest
    analysis: made_from(PlatformOptions)
