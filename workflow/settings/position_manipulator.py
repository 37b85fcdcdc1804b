"""Settings of a human joint in a position-controlled manipulator, from recordings."""

from typing import Any

from pydantic import model_validator

from tepsipe.experiments.position_manipulator.options import PositionManipulatorOptions, TimeVaryingOptions
from tepsipe.identification.cascade.options import ParallelCascadeOptions
from tepsipe.ingest.manipulator_options import TableOptions
from tepsipe.quantities import Delimiter
from workflow.settings.section import Section, UnfitError, made_from, setting


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


class Table(Section):
    """A table of samples."""

    columns: Columns
    delimiter: Delimiter = setting("delimiter of the table")


class TableFiles(made_from(TableOptions, without=("resample_rate_hz", "max_gap_s")), Table):
    """Tables of a recording."""


# clock of a trial
TableIngest = made_from(TableOptions, without=("angle_unit", "torque_sign"))


class ParallelCascade(made_from(ParallelCascadeOptions)):
    """Intrinsic stiffness and stretch reflex."""

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


class ManipulatorAnalysis(made_from(PositionManipulatorOptions)):
    """Regression of I, B, K, and the parallel cascade."""

    parallel_cascade: ParallelCascade


class _Enabled(Section):
    """Whether a part of the analysis is done."""

    enabled: bool = setting(
        "false leaves out impedance that changes within a trial: table, figure and section of the report"
    )


class TimeVarying(made_from(TimeVaryingOptions), _Enabled):
    """Impedance that changes within a trial."""


class PositionManipulator(Section):
    """A human joint in a position-controlled manipulator."""

    joint: Joint
    files: TableFiles
    ingest: TableIngest
    analysis: ManipulatorAnalysis
    time_varying: TimeVarying
