"""Fit of treadmill models to the recordings of a belt, and their scores on others."""

from collections.abc import Mapping
from dataclasses import dataclass

from tepsipe.arguments import options_of
from tepsipe.io.result import Result
from tepsipe.io.trial import Trial
from tepsipe.signals.filters import Lowpass
from tepsipe.treadmill.calibration import ModelScore, calibrate, table_plan, table_result
from tepsipe.treadmill.recording import BeltRecording
from tepsipe.treadmill.registry import FamilyOptions, FittedModel
from tepsipe.treadmill.table_summary import table_facts
from tepsipe.treadmill.trial_recordings import table_recording


@dataclass(frozen=True)
class BeltCalibration:
    """Treadmill models of a belt, and how well they predict recordings that they have not seen."""

    models: list[FittedModel]
    """Models behind the filter that figures show."""
    result: Result
    """Arrays and facts of them, for figures and the report."""
    scores: list[ModelScore]
    """Scores behind every filter."""


def begin(trial: Trial, section: dict, name: str) -> BeltRecording:
    """Load and velocity of a recording, without its ends (N or N·m, m/s)."""
    return table_recording(trial, name, section["analysis"]["trimmed_s"])


def fit(trials: Mapping[str, Trial], section: dict, roles: Mapping[str, str]) -> BeltCalibration:
    """Fit the models of a family behind every filter to the trials with the role calibrate.

    trials, roles: condition -> trial, and its role.
    """
    analysis, choices = section["analysis"], dict(section["models"])
    family, shown_hz = choices.pop("family"), analysis["shown_cutoff_hz"]
    options = options_of(FamilyOptions, choices)
    recordings = {name: begin(trial, section, name) for name, trial in trials.items()}
    names = [condition for condition, role in roles.items() if role == "calibrate"]
    train, scores = "+".join(names), []
    for cutoff in sorted({*analysis["cutoffs_hz"], shown_hz}):
        lowpass = Lowpass(cutoff, analysis["lowpass_order"], analysis["zero_lag"])
        filtered = {condition: recording.filtered(lowpass) for condition, recording in recordings.items()}
        training = [filtered[name] for name in names]
        testing = {name: [filtered[name]] for name in roles if name not in names}
        plan = table_plan(family, train, list(testing))
        found, fitted = calibrate(plan, {train: training}, testing, "load", options)
        scores += found
        if cutoff == shown_hz:
            ingested = {name: trial.attributes for name, trial in trials.items()}
            result = table_result(fitted, [filtered[name] for name in testing], ingested)
            result.facts.update(table_facts(fitted, training, filtered, family, options))
            shown = fitted
    return BeltCalibration(shown, result, scores)
