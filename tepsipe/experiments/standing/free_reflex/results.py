"""Fits with a free reflex torque among the other fits of a person, their budgets, and differences."""

import math
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np

from tepsipe.errors import InputError
from tepsipe.experiments.budgets import contributions_of
from tepsipe.experiments.standing.estimates import UNITS, Fits, StandingFit, generator
from tepsipe.experiments.standing.free_reflex.broadband import BroadbandEpochs
from tepsipe.experiments.standing.free_reflex.checks import difference_from_window, failed_checks, quotable
from tepsipe.experiments.standing.free_reflex.common_centre import common_centre, with_common_centre
from tepsipe.experiments.standing.free_reflex.fit import (
    QUANTITIES,
    FreeReflexFit,
    FreeReflexOptions,
    fit_free_reflex,
)
from tepsipe.experiments.standing.muscle_torque import FREE, NONE
from tepsipe.experiments.standing.options import StandingEstimator, TorquePathway
from tepsipe.experiments.standing.thesis.latency import MuscleLatency
from tepsipe.io.budget_table import Contribution
from tepsipe.io.estimates import Estimate, flagged, recommended
from tepsipe.io.result import Result
from tepsipe.statistics.uncertainty import Budget, Source

# K and B of both legs, and of each on a plate of its own
OF_JOINT = tuple(f"{quantity}{leg}" for quantity in QUANTITIES for leg in ("", "_left", "_right"))
UNKNOWN_ORIGIN, ORIGIN = "unknown_origin_m", "origin_anterior_m"


@dataclass(frozen=True)
class FreeReflexChoices:
    """Choices that all fits with a free reflex torque share."""

    pathway: str
    """Torque that is fitted."""
    options: FreeReflexOptions
    """Options of the analysis."""
    sources: dict[str, Source]
    """Uncertain constants."""
    draws: int
    seed: int
    """Number of resampled sets of responses, and seed of the study."""


def fit_free(
    trials: list[BroadbandEpochs],
    name: str,
    estimators: dict[str, StandingEstimator],
    choices: FreeReflexChoices,
    perturbations: int,
    reflex_onset_s: float | None = None,
) -> Fits:
    """Fit every estimator with a free reflex torque, and check it against the pre-reflex window.

    trials: trials that share their parameters.
    name: name of the trial or task: seed of the resampling, and name in messages.
    estimators: name -> estimator; those with another active torque are passed over.
    perturbations: number of perturbations in the trials, usable or not.
    reflex_onset_s: earliest instant of a reflex torque (s); from the options if left out.
    """
    fits: Fits = {}
    trials, sources = with_common_centre(trials, _with_origin(trials, choices.sources))
    for key, estimator in estimators.items() if trials else ():
        if estimator.active != FREE:
            continue
        if estimator.inertia:
            raise InputError(
                f"{name}: expected no inertia with a free reflex torque, found inertia: true for {key}: set "
                "it to false in standing.estimators"
            )
        rng = generator(choices.seed, name, choices.pathway, key)
        fit = fit_free_reflex(
            trials, estimator.window_s, choices.options, sources, choices.draws, rng, reflex_onset_s
        )
        check = _pre_reflex(trials, fit, estimators, choices.options, sources)
        flags = failed_checks(fit, trials, perturbations, check)
        fits[choices.pathway, key] = _as_fit(fit, trials, flags)
    return fits


def _with_origin(trials: list[BroadbandEpochs], sources: dict[str, Source]) -> dict[str, Source]:
    """Sources, with that of the plate's origin (m) as assumed where no weight showed it in every trial."""
    kept = dict(sources)
    assumed = kept.pop(UNKNOWN_ORIGIN, None)
    if assumed is not None and not all(trial.origin_known for trial in trials):
        kept[ORIGIN] = replace(assumed, name=ORIGIN)
    return kept


def _pre_reflex(
    trials: list[BroadbandEpochs],
    fit: FreeReflexFit,
    estimators: dict[str, StandingEstimator],
    options: FreeReflexOptions,
    sources: list[Source],
) -> tuple[np.ndarray, Budget] | None:
    """B and K in the first window without active torque less B and K of a fit, and the budget of this."""
    for estimator in estimators.values():
        plain = estimator.active == NONE and not estimator.inertia
        if plain and estimator.window_s <= options.windows_s[1]:
            return difference_from_window(trials, fit, estimator.window_s, options, sources)
    return None


def _as_fit(fit: FreeReflexFit, trials: list[BroadbandEpochs], flags: tuple[str, ...]) -> StandingFit:
    peaks = [float(np.abs(c["active"]).max() / np.abs(c["intrinsic"]).max()) for c in fit.curves]
    return StandingFit(
        names=QUANTITIES,
        parameters=fit.parameters,
        delays={},
        vaf=fit.vaf,
        rotation_rad=float(np.mean([np.ptp(curve["ankle"]) for curve in fit.curves])),
        active_peak=max(peaks),
        curves=fit.curves,
        responses=sum(trial.count for trial in trials),
        budget=fit.budget,
        flags=flags,
        windows=fit.windows,
    )


def reflex_onset(
    latencies: list[MuscleLatency], action: dict[str, float], detector: str, options: FreeReflexOptions
) -> float | None:
    """Earliest instant of a reflex torque (s): the first latency of an ankle muscle, and the time to force.

    latencies: latencies of the muscles with a response.
    action: muscles that act at the ankle.
    detector: detector whose onset counts.
    Returns: none if no latency is known.
    """
    onsets = [
        x.onsets[detector].latency_s for x in latencies if action.get(x.muscle) and detector in x.onsets
    ]
    known = [onset for onset in onsets if onset is not None]
    return min(known) + options.electromechanical_delay_s if known else None


def centre_facts(trials: list[BroadbandEpochs], sources: dict[str, Source]) -> dict:
    """Facts on the joint's centre: its offset (m), whether it is from sway, motion of soft tissue (m).

    ``broadband_cutoff_hz`` is the cutoff of the low-pass (Hz), which slow cameras lower.
    """
    centre = common_centre(trials, sources)
    return {
        "broadband_cutoff_hz": min((trial.cutoff_hz for trial in trials), default=None),
        "joint_centre_m": centre.offset_m.tolist() if trials else None,
        "centre_used": centre.from_sway,
        "skin_m": float(np.sqrt(np.mean([trial.skin_m**2 for trial in trials]))) if trials else 0.0,
    }


def quoted(
    rows: list[Estimate],
    trials: list[BroadbandEpochs],
    fits: Fits,
    chosen: dict[str, str],
    pathway: TorquePathway,
) -> list[Estimate]:
    """Rows of a task with those to quote marked; none, where the torque cannot be trusted.

    The belt-induced load must be compensated, by a treadmill model whose error of K is not clearly above half
    of it. Without compensation, K and B of the chosen pathway are flagged ``uncompensated``.

    fits: (pathway, estimator) -> fit.
    chosen: recommended ``pathway`` and ``estimator``.
    """
    if pathway.torque != "single-joint" and pathway.treadmill_model is None:
        return [*(flagged([row], "uncompensated")[0] if _of(row, chosen["pathway"]) else row for row in rows)]
    fit = fits.get((chosen["pathway"], chosen["estimator"]))
    known = fit is not None and fit.budget is not None
    if known and not quotable(trials, float(fit.parameters[0, fit.names.index("K")])):
        return rows
    return recommended(rows, **chosen)


def _of(row: Estimate, pathway: str) -> bool:
    return row.pathway == pathway and row.quantity in OF_JOINT


def budget_rows(rows: list[Estimate], fits: Fits) -> list[Contribution]:
    """Rows of the table of budgets for the estimates of a trial or task."""
    contributions = []
    for (pathway, estimator), fit in fits.items():
        if fit.budget is not None:
            of_fit = [r for r in rows if (r.pathway, r.estimator) == (pathway, estimator)]
            contributions += contributions_of(of_fit, fit.budget, list(fit.names))
    return contributions


def budget_arrays(fits: Fits) -> tuple[dict[str, np.ndarray], dict]:
    """Budgets as arrays below ``budget/<estimator>/`` (units of B and K), and their degrees of freedom."""
    arrays, facts = {}, {}
    for (pathway, estimator), fit in fits.items():
        if fit.budget is None:
            continue
        b = fit.budget
        arrays[f"budget/{estimator}/values"] = fit.parameters[0]
        arrays[f"budget/{estimator}/type_a"] = b.type_a
        for source, rows in b.contributions.items():
            arrays[f"budget/{estimator}/sources/{source}"] = rows
        if fit.windows is not None:
            arrays[f"budget/{estimator}/windows"] = fit.windows
        finite = {name: x for name, x in b.freedom.items() if math.isfinite(x)}
        facts[estimator] = {
            "pathway": pathway,
            "freedom_a": b.freedom_a,
            "freedom": finite,
            "responses": fit.responses,
            "flags": list(fit.flags),
        }
    return arrays, facts


def with_budgets(result: Result, fits: Fits) -> Result:
    """The result of a trial or task with the budgets of its fits (units of B and K)."""
    arrays, facts = budget_arrays(fits)
    units = dict.fromkeys(arrays, "Nms/rad, Nm/rad")
    return Result(result.arrays | arrays, result.units | units, {**result.facts, "budgets": facts})


def _budget_from_result(result: Result, estimator: str) -> Budget:
    facts, start = result.facts["budgets"][estimator], f"budget/{estimator}/sources/"
    contributions = {
        key.removeprefix(start): rows for key, rows in result.arrays.items() if key.startswith(start)
    }
    type_a = result.arrays[f"budget/{estimator}/type_a"]
    return Budget(type_a, facts["freedom_a"], contributions, facts["freedom"])


def task_difference(
    name: str, more: Result, less: Result, critical_stiffness: Annotated[float, "N·m/rad"]
) -> tuple[list[Estimate], list[Contribution]]:
    """Difference of B and K between two tasks of the same person.

    Sources common to both tasks (the joint's centre, the feet's mass, the plate) are subtracted source by
    source, so the interval is narrower than the intervals of the two tasks suggest.

    name: condition of the rows, for example stiff-relax.
    more, less: results of the two tasks, with their budgets.

    Returns:
        rows: B, K and K over m g h, by every estimator with budgets in both tasks.
        contributions: their budgets.
    """
    rows, contributions = [], []
    of_more, of_less = (result.facts.get("budgets", {}) for result in (more, less))
    for estimator in of_more:
        if estimator not in of_less:
            continue
        values = more.arrays[f"budget/{estimator}/values"] - less.arrays[f"budget/{estimator}/values"]
        budget = _shared(_budget_from_result(more, estimator), _budget_from_result(less, estimator))
        low, high = budget.interval(values)
        flags = dict.fromkeys([*of_more[estimator]["flags"], *of_less[estimator]["flags"]])
        estimates = [
            Estimate(
                *("standing", name, of_more[estimator]["pathway"], estimator, quantity, UNITS[quantity]),
                *(float(x[k]) for x in (values, budget.combined, low, high)),
                n_perturbations=of_more[estimator]["responses"] + of_less[estimator]["responses"],
                u_type_a=float(budget.type_a[k]),
                u_type_b=float(budget.type_b[k]),
            )
            for k, quantity in enumerate(QUANTITIES)
        ]
        contributions += contributions_of(estimates, budget, list(QUANTITIES))
        estimates.append(_over_critical(estimates[QUANTITIES.index("K")], critical_stiffness))
        rows += flagged(estimates, *flags)
    return rows, contributions


def _shared(more: Budget, less: Budget) -> Budget:
    """Budget of a difference; a source whose numbers of draws differ counts as two."""
    mine, theirs = dict(more.contributions), dict(less.contributions)
    for name in [n for n in mine if n in theirs and mine[n].shape != theirs[n].shape]:
        mine[name] = np.vstack([mine[name], theirs.pop(name)])
    return Budget(more.type_a, more.freedom_a, mine, more.freedom).minus(
        Budget(less.type_a, less.freedom_a, theirs, less.freedom)
    )


def _over_critical(row: Estimate, critical_stiffness: float) -> Estimate:
    """K in units of m g h."""
    scaled = {
        key: None if (x := getattr(row, key)) is None else x / critical_stiffness
        for key in ("value", "standard_error", "ci_low", "ci_high", "u_type_a", "u_type_b")
    }
    return Estimate(
        *(row.experiment, row.condition, row.pathway, row.estimator, "K_over_mgh", "1"),
        **scaled,
        n_perturbations=row.n_perturbations,
    )
