"""Settings of a person on a platform that moves forwards and backwards, from recordings."""

from tepsipe.experiments.platform.options import PlatformOptions
from tepsipe.ingest.manipulator_options import PlatformTableOptions
from workflow.settings.position_manipulator import Table, TableIngest
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


class PlatformFiles(made_from(PlatformTableOptions, without=("resample_rate_hz", "max_gap_s")), Table):
    """Tables of a recording."""

    columns: PlatformColumns


class Platform(Section):
    """A person on a moving platform."""

    files: PlatformFiles
    ingest: TableIngest
    analysis: made_from(PlatformOptions)
