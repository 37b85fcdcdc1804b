"""Settings of the joint in the torque-controlled manipulator (thesis sections 2-1-1 and 3-1-1)."""

from typing import Any

from pydantic import model_validator

from tepsipe.experiments.wristalyzer.options import WristalyzerOptions
from tepsipe.ingest.manipulator_options import ManipulatorOptions
from tepsipe.quantities import AngleUnit
from workflow.settings.section import Section, UnfitError, made_from, setting


class LogColumns(Section):
    """Columns of the log."""

    time: str = setting("column of the log: time stamp (s)")
    angle: str = setting("column of the log: angle (in `angle_unit`)")
    trigger_time: str = setting("column of the log: 0 before the trigger, then its time stamp (s)")


class CommandColumns(Section):
    """Columns of the torque command."""

    time: str = setting("column of the command: time from the trigger (s)")
    torque: str = setting("column of the command: torque (N·m)")


class WristalyzerFiles(Section):
    """Files of a recording."""

    log_columns: LogColumns
    command_columns: CommandColumns
    angle_unit: AngleUnit = setting("unit of the angle")


class WristalyzerAnalysis(made_from(WristalyzerOptions)):
    """Spectral fit of the joint."""

    @model_validator(mode="after")
    def _starts_between_bounds(self) -> Any:
        for key, start in self.start:
            low, high = getattr(self.lower, key), getattr(self.upper, key)
            if not low < start < high:
                expected = f"between its bounds {low} and {high}"
                raise UnfitError(expected, "correct one of the three", f"start.{key}", f"{start}")
        low, high = self.lower.K_Nm_per_rad, self.upper.K_Nm_per_rad
        for stiffness in self.tried_stiffness_Nm_per_rad:
            if not low < stiffness < high:
                expected = f"between the bounds {low} and {high}"
                raise UnfitError(expected, key="tried_stiffness_Nm_per_rad", found=f"{stiffness}")
        return self


class Wristalyzer(Section):
    """The joint in the torque-controlled manipulator."""

    files: WristalyzerFiles
    ingest: made_from(ManipulatorOptions, "Clock of a trial.", without=("angle_unit",))
    analysis: WristalyzerAnalysis
    best_condition: str = setting(
        "condition of the example figures; the last of the sheet if the study does not contain it",
        thesis="Figures 4-1, 4-2",
    )
