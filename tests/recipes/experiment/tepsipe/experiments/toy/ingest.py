"""Table of a spring to a trial, and the settings of the experiment."""

from dataclasses import dataclass

from tepsipe.ingest.limits import Limits, Rig
from tepsipe.ingest.manipulators import recorded_columns
from tepsipe.ingest.plausibility import plausible_trial
from tepsipe.io.readers.text_table import read_text_table
from tepsipe.io.trial import Signal, Trial
from tepsipe.quantities import Pause, Rate, Time

COLUMNS = {"time": "time_s", "angle": "angle_rad", "torque": "torque_Nm"}


@dataclass(frozen=True)
class IngestOptions:
    """Options of the table."""

    resample_rate_hz: Rate
    """Rate of the trial."""
    max_gap_s: Time
    """Longest gap that is filled."""


@dataclass(frozen=True)
class FitOptions:
    """Options of the fit."""

    cut_s: Pause
    """Time cut at both ends."""


@dataclass(frozen=True)
class Settings:
    """A spring that is bent."""

    ingest: IngestOptions
    analysis: FitOptions


def ingest(
    files: dict[str, str], section: dict, duration_s: float, named_by: dict, limits: Limits, rig: Rig
) -> tuple[Trial, dict]:
    """A plausible trial of the table, and the options used."""
    options, path = IngestOptions(**section["ingest"]), files["log"]
    table = read_text_table(path, COLUMNS, ",")
    recorded = recorded_columns(table, ["angle", "torque"], options.max_gap_s, duration_s, path)
    grid, even = recorded.resampled(recorded.columns, options.resample_rate_hz)
    steps = recorded.steps(options.resample_rate_hz)
    signals = {
        "angle": Signal(even[:, 0], "rad", ("time",), "angle of the spring", steps),
        "torque": Signal(even[:, 1], "Nm", ("time",), "torque of the spring", steps),
    }
    trial = Trial(options.resample_rate_hz, {"time": grid}, signals, recorded.attributes)
    return plausible_trial(trial, limits, rig, files), vars(options)
