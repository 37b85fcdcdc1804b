"""Fit of one trial of a standing person: its processed signals, its responses, and the ankle impedance.

The estimate to quote is that of the task to which a trial belongs (`fit_task`).
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Self

from tepsipe.experiments.fitted import Fitted
from tepsipe.experiments.standing.epochs import StandingEpochs, cut_standing_epochs
from tepsipe.experiments.standing.estimates import fit_rows
from tepsipe.experiments.standing.free_reflex.broadband import BroadbandEpochs
from tepsipe.experiments.standing.free_reflex.legs import cut_with_legs, leg_rows, legs_results
from tepsipe.experiments.standing.free_reflex.results import FreeReflexChoices, fit_free, with_budgets
from tepsipe.experiments.standing.joint_torque import StandingTrial, process_standing
from tepsipe.experiments.standing.muscle_torque import ActiveOptions
from tepsipe.experiments.standing.options import (
    AS_PRINTED,
    BOTH,
    EpochOptions,
    StandingEstimator,
    StandingOptions,
    TorquePathway,
)
from tepsipe.experiments.standing.thesis.impedance import (
    fit_all,
    over_sway,
    standing_result,
    trial_epochs_result,
)
from tepsipe.io.result import Result, joined
from tepsipe.io.trial import Trial, with_faults
from tepsipe.signals.filters import Lowpass
from tepsipe.treadmill.held_out import read_held_out
from tepsipe.treadmill.plate_check import PlateCheck, calibration_fault, calibration_of
from tepsipe.treadmill.registry import FittedModel, pick


@dataclass(frozen=True)
class Plates:
    """The force plates on which a person stands, as far as they were calibrated."""

    models: Mapping[str, dict[str, dict[str, FittedModel]]] = field(default_factory=dict)
    """Belt -> component of the load, Fy or Mx -> name -> treadmill model."""
    calibrations: Mapping[str, Result] = field(default_factory=dict)
    """Belt -> check of its plate, and residuals of trials that the models have not seen."""

    @classmethod
    def of_belts(
        cls, belts: Sequence[str], models: Sequence[dict[str, FittedModel]], calibrations: Sequence[Result]
    ) -> Self:
        """Plates of some belts, from the models of Fy and of Mx of each, and from their calibrations."""
        left = iter(models)
        of_belts = {belt: dict(zip(("Fy", "Mx"), left, strict=False)) for belt in belts}
        return cls(of_belts, dict(zip(belts, calibrations, strict=False)))

    @property
    def checks(self) -> dict[str, PlateCheck]:
        """Belt -> check of its plate."""
        return {belt: PlateCheck.from_result(found) for belt, found in self.calibrations.items()}

    def named(self, model: str | None) -> dict[str, dict[str, FittedModel]]:
        """Belt -> component -> one model by its name."""
        return {
            belt: {} if model is None else {load: pick(found, model) for load, found in of_plate.items()}
            for belt, of_plate in self.models.items()
        }


def begin(
    trial: Trial, section: dict, name: str, plates: Plates | None = None
) -> tuple[StandingTrial, StandingEpochs]:
    """Processed trial and its responses; without ``plates`` they have no torque.

    section: settings of the experiment, with the ``person`` and the ``belt`` of the trial.
    """
    options, cutting = _options(section)
    choices = {} if plates is None else section["pathways"]
    pathways = {key: TorquePathway(**choice) for key, choice in choices.items()}
    plates = plates or Plates()
    checks = plates.checks
    if options.belt == BOTH:
        for belt, check in checks.items():
            trial = with_faults(trial, *calibration_fault(check.calibration, calibration_of(trial, belt)))
            trial = check.corrected(trial, belt)
    plate = PlateCheck.of_several(list(checks.values())) if checks else PlateCheck()
    standing = process_standing(trial, name, options, pathways, _of_belt(plates.models, options), plate)
    return standing, cut_standing_epochs(standing, cutting)


def fit(
    trial: Trial,
    section: dict,
    condition: str,
    seed: int,
    uncertainty: dict,
    models: Sequence[dict[str, FittedModel]] = (),
    calibrations: Sequence[Result] = (),
) -> Fitted:
    """Impedance by every pathway and estimator; ``responses`` is a further result.

    uncertainty: sources, as `sources_of` takes them.
    models: name -> treadmill model, of Fy and of Mx of each belt on which the person stands; may be empty.
    calibrations: of each belt, check of the plate and residuals of trials that its models have not seen.
    """
    name, (options, _) = f"standing/{condition}", _options(section)
    plates = Plates.of_belts(options.belts, models, calibrations)
    standing, responses = begin(trial, section, name, plates)
    directions, draws = responses.by_direction(), section["analysis"]["bootstrap_draws"]
    estimators = {key: StandingEstimator(**choice) for key, choice in section["estimators"].items()}
    active = ActiveOptions.from_settings(section["active"], section["muscles"])
    pathways = list(section["pathways"])
    fits, notes = fit_all(directions, name, pathways, estimators, active, draws, seed)
    choices = FreeReflexChoices.from_settings(
        section["recommended"]["pathway"], section["free_reflex"], uncertainty
    )
    cut, perturbations = _broadband(standing, directions, section, plates), int(standing.onsets_s.size)
    common = name, estimators, choices, perturbations
    fits |= fit_free(_of(BOTH, cut), *common)
    facts = _facts(standing, responses, choices.pathway, notes, options)
    result = standing_result(directions, fits, choices.pathway, [], facts)
    rows, contributions = fit_rows(condition, fits, options.person.body.critical_stiffness)
    legs = {leg: of_leg for leg in options.belts if (of_leg := _of(leg, cut))}
    rows_of_legs, more = leg_rows(condition, legs, lambda trials: fit_free(trials, *common))
    readings = [name for name, choice in section["pathways"].items() if choice["torque"] in AS_PRINTED]
    printed = list(dict.fromkeys([section["as_printed"], *readings]))
    torques = {"as_printed": printed, "recommended": choices.pathway}
    epochs = trial_epochs_result(standing, responses, torques)
    return Fitted(
        with_budgets(result, fits),
        [*rows, *rows_of_legs],
        [*contributions, *more],
        {"responses": joined(epochs, *legs_results(cut))},
    )


def _options(section: dict) -> tuple[StandingOptions, EpochOptions]:
    analysis = section["analysis"]
    options = StandingOptions.from_settings(section["person"], section["belt"], analysis, section["stance"])
    return options, EpochOptions.from_settings(analysis, section["emg"], section["ingest"]["max_gap_s"])


def _of_belt(of_plates: Mapping[str, dict], options: StandingOptions) -> Mapping:
    """Models by belt for a person with a foot on each, otherwise those of the one belt."""
    return of_plates if options.belt == BOTH else of_plates.get(options.belt, {})


def _broadband(
    standing: StandingTrial, directions: list[StandingEpochs], section: dict, plates: Plates
) -> list[dict[str, BroadbandEpochs]]:
    """Epochs of the recommended torque for every direction of the belt, of both legs and of each.

    None, if that torque is not the one at the ankle.
    """
    pathway = TorquePathway(**section["pathways"][section["recommended"]["pathway"]])
    if pathway.torque != "ankle":
        return []
    options, cutting = _options(section)
    model = pathway.treadmill_model
    cutoff_hz, order = section["free_reflex"]["lowpass_cutoff_hz"], section["analysis"]["lowpass_order"]
    named = plates.named(model)
    held_out = {
        belt: found
        for belt, calibration in plates.calibrations.items()
        if (found := read_held_out(calibration)) is not None and found.of(named.get(belt, {}))
    }
    return [
        cut_with_legs(
            standing,
            part,
            options,
            cutting,
            Lowpass(cutoff_hz, order, True),
            _of_belt(named, options),
            held_out,
            section["estimators"][section["recommended"]["estimator"]]["window_s"],
        )
        for part in directions
    ]


def _of(leg: str, cut: list[dict[str, BroadbandEpochs]]) -> list[BroadbandEpochs]:
    return [part[leg] for part in cut if leg in part]


def _facts(
    standing: StandingTrial,
    responses: StandingEpochs,
    pathway: str,
    notes: list[str],
    options: StandingOptions,
) -> dict:
    return {
        "left_out": [*responses.left_out, *(notes if responses.count else [])],
        "perturbations": int(standing.onsets_s.size),
        "responses": responses.count,
        "muscles": responses.muscles,
        **over_sway(responses, pathway),
        "marker_delay_s": standing.delay_s,
        "critical_stiffness_Nm_per_rad": options.person.body.critical_stiffness,
    }
