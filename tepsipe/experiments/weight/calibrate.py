"""Treadmill models of a force plate, fitted to trials with the empty belt and with weights."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from tepsipe.io.result import Result
from tepsipe.io.trial import Trial, recorded_faults
from tepsipe.signals.filters import Lowpass
from tepsipe.signals.perturbations import WindowOptions
from tepsipe.treadmill.bristle_fit import Calibrated
from tepsipe.treadmill.calibration import (
    BOTH,
    OF_BOTH,
    ModelScore,
    calibrate,
    group_of,
    mean_responses,
    plate_groups,
    plate_plan,
)
from tepsipe.treadmill.frame_peak import frame_peak
from tepsipe.treadmill.held_out import below_limit, held_out_residuals
from tepsipe.treadmill.options import Weight
from tepsipe.treadmill.plate_check import (
    PlateCheck,
    Resting,
    calibration_fault,
    calibration_of,
    check_plate,
    resting,
)
from tepsipe.treadmill.prepared import PreparedTrial, prepare_trial
from tepsipe.treadmill.recording import BeltRecording
from tepsipe.treadmill.registry import JOINT, FamilyOptions, FittedModel
from tepsipe.treadmill.trial_recordings import (
    COMPONENTS,
    PlateOptions,
    plate_filters,
    plate_recordings,
    zeroed_per_pulse,
)


@dataclass(frozen=True)
class PlateTrial:
    """A trial with a weight or the empty belt, by which a plate is calibrated."""

    experiment: str
    condition: str
    role: str
    """{"calibrate", "validate"}"""
    weight: Weight | None
    """The weight; None for the empty belt."""
    trial: Trial

    @property
    def name(self) -> str:
        """Name for messages."""
        return f"{self.experiment}/{self.condition}"

    def prepared(self, analysis: dict) -> PreparedTrial:
        """The trial with its perturbations and rest, behind the first filter."""
        window = WindowOptions(**analysis["window"])
        return prepare_trial(self.trial, self.name, plate_filters(analysis)[0], window)

    def at_rest(self, belt: str, analysis: dict) -> Resting:
        """Loads and places at rest (N, N·m, m)."""
        return resting(self.prepared(analysis), belt, self.weight)

    def recordings(self, belt: str, analysis: dict, lowpass: Lowpass) -> dict[str, BeltRecording]:
        """Component of the load, Fy or Mx -> recording behind a filter (N, N·m)."""
        options = PlateOptions.from_settings(belt, analysis, lowpass)
        return plate_recordings(self.trial, self.name, self.condition, options, self.weight)


@dataclass(frozen=True)
class PlateCalibration:
    """Treadmill models of a plate, and how well they predict trials that they have not seen."""

    models: dict[str, list[FittedModel]]
    """Component of the load, Fy or Mx -> models behind the first filter, one per name."""
    responses: Result
    """Mean responses to the usual weight, measured and predicted."""
    held_out: Result
    """Residuals of the trials to validate, and the check of the plate."""
    scores: list[ModelScore]
    """Scores behind every filter."""


# recordings of a fit without the trials of further weights
USUAL_ONLY = f"{BOTH} only"
# group and role of a trial, and its recordings of both components
Grouped = tuple[str, str, dict[str, BeltRecording]]


def calibrate_plate(
    trials: Sequence[PlateTrial],
    plate: str,
    belt: str,
    usual_kg: float,
    analysis: dict,
    models: dict,
    seed: int,
) -> PlateCalibration:
    """Fit the models of a family behind every filter, and evaluate them.

    plate: names the plate in messages.
    usual_kg: mass of the usual weight.
    analysis, models: settings of the weight.
    """
    check = check_plate([trial.at_rest(belt, analysis) for trial in trials], plate)
    check = with_recordings(check, [trial.trial for trial in trials], belt)
    trials = [replace(each, trial=check.corrected(each.trial, belt)) for each in trials]
    choices = dict(models)
    family, draws = choices.pop("family"), choices.pop("calibration_draws")
    options, joint = FamilyOptions(**choices), {}
    scores: list[ModelScore] = []
    filters = plate_filters(analysis)
    for lowpass in filters:
        grouped = [_grouped(trial, belt, analysis, lowpass, usual_kg) for trial in trials]
        calibrating, validating = (
            [recordings for _, own, recordings in grouped if own == role]
            for role in ("calibrate", "validate")
        )
        joint = {
            name: fit(calibrating, draws, np.random.default_rng(seed), joint.get(name))
            for name, fit in JOINT.items()
            if name in family
        }
        found, fitted = _fit_loads(grouped, family, replace(options, joint=joint))
        scores += found
        scores += _without_other_weights(grouped, family, options, joint)
        if lowpass == filters[0]:
            kept, testing = fitted, _groups(grouped, "Fy")[1]
            responses = mean_responses(kept["Fy"], testing["weight"])
            best = min(joint, key=lambda name: joint[name].error, default=None)
            failing = _below_limit(found, testing, best)
            left = held_out_residuals(joint.get(best), calibrating, validating, failing)
            left.facts["model"] = best
            left.facts["plate"] = check.facts
            empty = [trial.prepared(analysis) for trial in trials if trial.weight is None]
            left.facts["empty_frame"] = frame_peak(empty, belt)
    return PlateCalibration(kept, responses, left, scores)


def with_recordings(check: PlateCheck, trials: Sequence[Trial], belt: str) -> PlateCheck:
    """The check of a plate with the calibration of its recordings, and with their faults."""
    known = [calibration_of(trial, belt) for trial in trials]
    faults = [fault for trial in trials for fault in recorded_faults(trial) if fault != "other-amplitude"]
    faults += [fault for each in known for fault in calibration_fault(known[0], each)]
    return replace(check, faults=tuple(dict.fromkeys(faults)), calibration=known[0])


def _grouped(trial: PlateTrial, belt: str, analysis: dict, lowpass: Lowpass, usual_kg: float) -> Grouped:
    recordings = trial.recordings(belt, analysis, lowpass)
    zeroed = {load: zeroed_per_pulse(recording) for load, recording in recordings.items()}
    return group_of(trial.experiment, zeroed["Fy"].carried_kg, usual_kg), trial.role, zeroed


def _groups(grouped: list[Grouped], load: str) -> tuple[dict[str, list[BeltRecording]], ...]:
    """Groups of the recordings of one component, to train on and to test on."""
    return plate_groups([(group, role, recordings[load]) for group, role, recordings in grouped])


def _fit_loads(
    grouped: list[Grouped], family: list[str], options: FamilyOptions
) -> tuple[list[ModelScore], dict[str, list[FittedModel]]]:
    """Scores of both components, and the models of each, one per name.

    Of several models of a name, that of the empty belt is kept, which needs no other recording.
    """
    scores, kept, frame = [], {}, None
    for load in COMPONENTS:
        training, testing = _groups(grouped, load)
        plan = plate_plan(family, list(testing))
        found, fitted = calibrate(plan, training, testing, load, replace(options, frame=frame))
        scores += found
        frame = next((m.model.frame for m in fitted if m.name == "loaded-frame"), None)
        kept[load] = [model for model, entry in zip(fitted, plan, strict=True) if entry.train != "weight"]
    return scores, kept


def _without_other_weights(
    grouped: list[Grouped], family: list[str], options: FamilyOptions, like: dict[str, Calibrated]
) -> list[ModelScore]:
    """Scores of the frames, fitted to the empty belt and the usual weight only; the others are predicted.

    like: name -> fit to all trials, whose terms are kept.
    Returns: none if no trial to calibrate has another weight.
    """
    usual = [each for each in grouped if each[1] != "calibrate" or each[0] in ("empty", "weight")]
    if len(usual) == len(grouped):
        return []
    frames = [name for name in family if name in OF_BOTH]
    calibrating = [recordings for _, role, recordings in usual if role == "calibrate"]
    joint = {name: JOINT[name](calibrating, 0, np.random.default_rng(0), fit) for name, fit in like.items()}
    scores, _ = _fit_loads(usual, frames, replace(options, joint=joint))
    return [replace(score, train=USUAL_ONLY) for score in scores]


def _below_limit(
    scores: list[ModelScore], testing: dict[str, list[BeltRecording]], model: str | None
) -> list[float]:
    """Masses (kg) of the trials whose load a model predicts worse than their noise allows."""
    return sorted(
        {
            testing[score.test][0].carried_kg
            for score in scores
            if score.model == model and below_limit(score.r2, score.r2_limit)
        }
    )
