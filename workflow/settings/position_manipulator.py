"""Settings of a human joint in a position-controlled manipulator, from recordings."""

from typing import Any

from pydantic import model_validator

from workflow.settings.quantities import (
    AngleUnit,
    Delay,
    Delimiter,
    FilterOrder,
    Frequency,
    InnerFraction,
    NotNegative,
    Pause,
    Positive,
    Rate,
    Sign,
    Time,
    different,
    fixed,
    number,
    some,
)
from workflow.settings.section import Section, UnfitError, setting


class Joint(Section):
    """Names for the report."""

    name: str | None = setting("joint, as the report names it, for example `ankle`; null for none")
    positive: str | None = setting("movement that increases the angle, for example `dorsiflexion`")
    negative: str | None = setting("movement that decreases it, for example `plantarflexion`")


class Columns(Section):
    """Columns of the table."""

    time: str = setting("column: time (s)")
    angle: str = setting("column: joint angle (in `angle_unit`)")
    torque: str = setting("column: joint torque (N·m)")
    schedule: str | None = setting(
        "column: a scheduled quantity that the trial passes through several times, for example the phase "
        "of gait, a target torque or position (any unit); null if there is none"
    )
    trigger: str | None = setting(
        "column that rises through the middle of its range where each realisation of a repeated movement "
        "begins; null if there is none"
    )


class TableFiles(Section):
    """Tables of a recording."""

    columns: Columns
    delimiter: Delimiter = setting("delimiter of the table")
    angle_unit: AngleUnit = setting("unit of the angle")
    torque_sign: Sign = setting(
        "−1 if a torque that resists a positive angle is recorded as negative, otherwise 1"
    )


class TableIngest(Section):
    """Clock of a trial."""

    resample_rate_hz: Rate = setting("rate of the trial, not above that of the recording")
    max_gap_s: Time = setting("longest gap that is filled")


ReflexDelay = number(above=0, most=1)  # s


class ParallelCascade(Section):
    """Intrinsic stiffness and stretch reflex."""

    intrinsic_lag_s: number(above=0, most=1) = setting("longest lag, and lead, of the intrinsic response")
    stop_radii_rad: different(number(above=0, most=3.2), least=0) = setting(
        "radii of the stop elements (short-range stiffness), of which those within the recorded movement "
        "are used; `[]` for none"
    )
    relaxation_times_s: different(Time, least=0) = setting(
        "time constants of elements whose torque relaxes; `[]` for none"
    )
    reflex_poles_per_s: different(Positive, least=0) = setting(
        "poles of the Laguerre functions of the reflex response that are tried; `[]` for knots only",
        unit="rad/s",
    )
    reflex_order: int = setting("their number", least=1, most=10)
    reflex_length_s: Time = setting(
        "length of a reflex response of knots, after its delay; shortest block of the cross-validation"
    )
    reflex_knot_s: Time = setting("distance of its knots, at most half its length")
    reflex_thresholds_rad_per_s: different(NotNegative) = setting(
        "velocity thresholds of the reflex that are tried"
    )
    reflex_delays_s: fixed(ReflexDelay, 2) = setting("shortest and longest delay that is tried")
    profiled_delays_s: fixed(Delay, 2) = setting(
        "shortest and longest delay whose cross-validated error is reported, to show what the trial does not "
        "separate"
    )
    expected_delay_s: ReflexDelay = setting(
        "preferred delay among those that the trial does not separate, within `reflex_delays_s`"
    )
    delay_tolerance: NotNegative = setting(
        "relative difference of the cross-validated error from which delays are separated"
    )
    penalties: some(Positive) = setting(
        "values of λ that are tried, see `tepsipe/identification/cascade/parallel_cascade.py`"
    )
    term_tolerance: NotNegative = setting(
        "relative difference of the cross-validated error below which a model with fewer terms is taken"
    )
    folds: int = setting(
        "number of blocks of the fitted part for the cross-validation; fewer if they would be shorter than "
        "`reflex_length_s` plus the longest delay",
        least=2,
    )
    slow_horizons_s: different(Time) = setting(
        "times by which the slow torque is predicted ahead; the first one is that of "
        "`VAF_held_out_with_slow_torque`"
    )

    @model_validator(mode="after")
    def _delays(self) -> Any:
        shortest, longest = self.reflex_delays_s
        if not shortest <= self.expected_delay_s <= longest:
            expected = (
                "within position_manipulator.analysis.parallel_cascade.reflex_delays_s, from short to long "
                f"([{shortest}, {longest}])"
            )
            found = f"{self.expected_delay_s}"
            raise UnfitError(expected, "correct one of the two", "expected_delay_s", found)
        if not self.profiled_delays_s[0] <= self.profiled_delays_s[1]:
            raise UnfitError(
                "from short to long", "turn it round", "profiled_delays_s", f"{self.profiled_delays_s}"
            )
        if self.reflex_length_s < 2.0 * self.reflex_knot_s:
            expected = f"of at most half of reflex_length_s ({self.reflex_length_s:g} s)"
            raise UnfitError(expected, "correct one of the two", "reflex_knot_s", f"{self.reflex_knot_s:g} s")
        return self


class ManipulatorAnalysis(Section):
    """Regression of I, B, K, and the parallel cascade."""

    lowpass_cutoff_hz: Frequency = setting("Butterworth low-pass of angle and torque before the regression")
    lowpass_order: FilterOrder = setting("order of both passes together")
    cut_s: Pause = setting("time cut at both ends")
    training_fraction: InnerFraction = setting(
        "first part of the trial, which is fitted; the rest is held out for validation"
    )
    averaged_bins: int = setting("raw frequencies averaged into one", least=2)
    block_s: Time = setting("length of the bootstrapped blocks")
    bootstrap_draws: int = setting("bootstrap samples", least=100, most=100000)
    parallel_cascade: ParallelCascade


class TimeVarying(Section):
    """Impedance that changes within a trial."""

    enabled: bool = setting(
        "false leaves out impedance that changes within a trial: table, figure and section of the report"
    )
    window_s: Time = setting("length of the sliding windows of trials with neither trigger nor schedule")
    window_step_s: Time = setting("distance of the windows")
    block_s: Time = setting(
        "length of the blocks of residuals that are bootstrapped in windows, longer than the residuals are "
        "correlated"
    )
    realisation_s: Time | None = setting(
        "length of a realisation after a trigger; null for the shortest time between triggers"
    )
    segment_s: Time = setting("length of the short segments of all realisations that are fitted together")
    segment_step_s: Time = setting("distance of the segments")
    bins: int = setting("number of equal bins of a schedule", least=2)
    piece_s: Time = setting(
        "longest piece of the record within a bin that has a level and a trend of its own; pieces shorter "
        "than a quarter of it are left out"
    )
    bootstrap_draws: int = setting("bootstrap samples", least=100, most=100000)


class PositionManipulator(Section):
    """A human joint in a position-controlled manipulator."""

    joint: Joint
    files: TableFiles
    ingest: TableIngest
    analysis: ManipulatorAnalysis
    time_varying: TimeVarying
