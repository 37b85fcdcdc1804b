"""Settings of the joint in the torque-controlled manipulator (thesis sections 2-1-1 and 3-1-1)."""

from typing import Annotated, Any

from pydantic import Field, model_validator

from workflow.settings.quantities import (
    AngleUnit,
    FilterOrder,
    Frequency,
    Pause,
    Rate,
    Time,
    band,
    different,
    some,
)
from workflow.settings.section import Section, UnfitError, number, setting


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


class RegularClock(Section):
    """Clock of a trial."""

    resample_rate_hz: Rate = setting("rate of the trial", thesis="3-1-1")
    max_gap_s: Time = setting("longest step between samples")


Bound = number(least=-1000, most=1000)
AveragedBins = Annotated[int, Field(ge=1)]


class Impedance(Section):
    """Starting values of a search, or its bounds, which may be negative."""

    I_Nms2_per_rad: Bound = setting("inertia of the joint", thesis="Table 3-2")
    B_Nms_per_rad: Bound = setting("its damping", thesis="Table 3-2")
    K_Nm_per_rad: Bound = setting("its stiffness", thesis="Table 3-2")


class WristalyzerAnalysis(Section):
    """Spectral fit of the joint."""

    lowpass_cutoff_hz: Frequency = setting("Butterworth low-pass of torque and angle", thesis="3-1-1")
    lowpass_order: FilterOrder = setting("order of both passes together", thesis="3-1-1")
    cut_s: Pause = setting("time cut at both ends", thesis="3-1-1")
    averaged_bins: int = setting("raw frequencies averaged into one", least=2, thesis="3-1-1, no number")
    swept_bins: different(AveragedBins) = setting("other numbers of averaged frequencies that are tried")
    fit_band_hz: band() = setting("fitted frequencies", thesis="3-1-1")
    perturbation_period_s: Time | None = setting(
        "period of the multisine, a whole number of samples; null if the perturbation is not periodic"
    )
    excited_band_hz: band() = setting("frequencies of the perturbation", thesis="2-1-1")
    start: Impedance
    lower: Impedance
    upper: Impedance
    random_starts: int = setting("further starting values, drawn at random", least=0)
    tried_stiffness_Nm_per_rad: some(Bound) = setting("further starting values of K, within the bounds")
    profile_stiffness_Nm_per_rad: band() = setting("range of K in its profile likelihood")
    profile_points: int = setting("number of values of K in that range", least=5)

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
    ingest: RegularClock
    analysis: WristalyzerAnalysis
    best_condition: str = setting(
        "condition of the example figures; the last of the sheet if the study does not contain it",
        thesis="Figures 4-1, 4-2",
    )
