"""Fit of all trials of one task of a standing person together: ankle impedance and muscle latencies."""

from collections.abc import Sequence

from tepsipe.experiments.fitted import Fitted
from tepsipe.experiments.standing.emg_checks import emg_faults
from tepsipe.experiments.standing.epochs import StandingEpochs, epochs_of
from tepsipe.experiments.standing.estimates import fit_rows, generator
from tepsipe.experiments.standing.free_reflex.legs import leg_rows, legs_of
from tepsipe.experiments.standing.free_reflex.results import (
    FreeReflexChoices,
    centre_facts,
    fit_free,
    quoted,
    reflex_onset,
    with_budgets,
)
from tepsipe.experiments.standing.muscle_torque import ActiveOptions
from tepsipe.experiments.standing.options import Person, StandingEstimator, TorquePathway
from tepsipe.experiments.standing.thesis.impedance import fit_all, standing_result, stiffness_by_window
from tepsipe.experiments.standing.thesis.latency import MuscleLatency, latency_estimates, muscle_latency
from tepsipe.io.estimates import flagged
from tepsipe.io.result import Result
from tepsipe.signals.onsets import OnsetOptions


def fit(
    responses: Sequence[Result],
    section: dict,
    task: str,
    seed: int,
    uncertainty: dict,
    others: Sequence[Result] = (),
) -> Fitted:
    """Impedance by every pathway and estimator, with the estimate to quote, and latencies.

    responses: stored responses of every trial, as `fit` of a trial returns them.
    section: settings of the experiment, with the ``person`` of the task.
    uncertainty: sources, as `sources_of` takes them.
    others: stored responses of the trials of the person's other tasks, which show the same foot.
    """
    name, draws = f"standing/{task}", section["analysis"]["bootstrap_draws"]
    critical_stiffness = Person.from_settings(section["person"]).body.critical_stiffness
    active = ActiveOptions.from_settings(section["active"], section["muscles"])
    whole = [epochs_of(result) for result in responses]
    trials = [part for epochs in whole for part in epochs.by_direction()]
    estimators = {key: StandingEstimator(**choice) for key, choice in section["estimators"].items()}
    pathways = list(section["pathways"])
    fits, notes = fit_all(trials, name, pathways, estimators, active, draws, seed)
    latencies, silent = _latencies(trials, section, name, seed)
    choices = FreeReflexChoices.from_settings(
        section["recommended"]["pathway"], section["free_reflex"], uncertainty
    )
    onset = reflex_onset(latencies, active.action, section["latency"]["detector"], choices.options)
    broadband, legs = legs_of(list(responses))
    person = broadband + legs_of(list(others))[0]
    perturbations = sum(result.arrays["processed/onsets_s"].size for result in responses)
    detector, lengthened = section["latency"]["detector"], _lengthened_by(section)
    of_emg = emg_faults(trials, lengthened, latencies, detector)
    common = name, estimators, choices, perturbations, onset, person, of_emg
    fits |= fit_free(broadband, *common)
    apart = dict.fromkeys(sentence for fit in fits.values() for sentence in fit.apart)
    facts = {
        "left_out": [*notes, *silent, *apart],
        "muscles": list(section["muscles"]),
        "trials": sum(epochs.count > 0 for epochs in whole),
        "responses": sum(epochs.count for epochs in trials),
        **centre_facts(broadband, choices.sources, person),
        "critical_stiffness_Nm_per_rad": critical_stiffness,
    }
    windows_s, rng = section["analysis"]["tried_windows_s"], generator(seed, name, "windows")
    windows = stiffness_by_window(trials, choices.pathway, windows_s, active, draws, rng)
    result = standing_result(trials, fits, choices.pathway, latencies, facts, windows)
    rows, contributions = fit_rows(task, fits, critical_stiffness)
    for latency in latencies:
        rows += flagged(latency_estimates(task, latency, choices.sources.get("latency_s")), *of_emg)
    rows_of_legs, more = leg_rows(task, legs, lambda trials: fit_free(trials, *common))
    pathway = TorquePathway(**section["pathways"][choices.pathway])
    return Fitted(
        with_budgets(result, fits),
        quoted([*rows, *rows_of_legs], broadband, fits, section["recommended"], pathway),
        [*contributions, *more],
    )


def _lengthened_by(section: dict) -> dict[str, dict[str, float]]:
    """Muscle -> joint -> lengthening per angle."""
    return {muscle: choice["lengthened_by"] for muscle, choice in section["muscles"].items()}


def _latencies(
    trials: list[StandingEpochs], section: dict, name: str, seed: int
) -> tuple[list[MuscleLatency], list[str]]:
    """Latencies of the muscles with a response, and a sentence for every other one."""
    options, found, silent = OnsetOptions(**section["latency"]), [], []
    recorded = any(responses.muscles for responses in trials if responses.count)
    for muscle, lengthening in _lengthened_by(section).items() if recorded else ():
        rng = generator(seed, name, "latency", muscle)
        latency = muscle_latency(trials, muscle, lengthening, options, rng)
        if isinstance(latency, str):
            silent.append(f"{name}: latency of {muscle} left out: {latency}")
        else:
            found.append(latency)
    return found, silent
