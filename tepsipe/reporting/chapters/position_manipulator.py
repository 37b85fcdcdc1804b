"""Chapter on the position-controlled manipulator: numbers of its fits, and conditions of its sentences."""

import statistics

import numpy as np
import pandas as pd

from tepsipe.experiments.position_manipulator.analysis import ESTIMATOR, REFLEX_ESTIMATOR, TERMS
from tepsipe.experiments.position_manipulator.diagnostics import SHOWN_TRIALS
from tepsipe.experiments.position_manipulator.operating_points import LITERATURE_SLOPE, LITERATURE_TORQUE_NM
from tepsipe.io.result import Result
from tepsipe.reporting.run import Run

# probability of a difference by chance (-)
LEVEL = 0.05


def numbers(run: Run) -> dict:
    """Numbers that no table has (units in the keys), and trials in which K changes."""
    return {
        "trials": {condition: _trial(fit) for condition, fit in run.fits["position_manipulator"].items()},
        "literature_slope": LITERATURE_SLOPE,
        "literature_torque_Nm": LITERATURE_TORQUE_NM,
        "changing": [
            condition
            for condition, rows in run.rows("time_varying", quantity="K").groupby("condition", sort=False)
            if _changes(rows)
        ],
    }


def _trial(fit: Result) -> dict:
    """Coherent frequencies, thirds of the record, and scores (%) of every fitted model by its terms."""
    parts = ("stiffness", "stiffness_half_width", "level", "level_half_width")
    scores = ("coefficients", "vaf_cross_validated", "vaf_held_out")
    columns = zip(*(fit.arrays[f"reflex/models_{name}"] for name in scores), strict=True)
    models = {
        " ".join(name for name, present in zip(TERMS, terms, strict=True) if present): dict(
            zip(scores, column, strict=True)
        )
        for terms, column in zip(fit.arrays["reflex/models_terms"], columns, strict=True)
    }
    return {
        **_coherent(fit),
        "models": models,
        "parts": {name: fit.arrays[f"diagnostics/part_{name}"] for name in parts},
    }


def _coherent(fit: Result) -> dict:
    """First and last frequency with significant coherence, and share of such frequencies between them."""
    found = fit.arrays["diagnostics/coherence"] > fit.arrays["diagnostics/coherence_level"]
    if not found.any():
        return {"coherent_Hz": None}
    first, last = np.flatnonzero(found)[[0, -1]]
    ends = fit.arrays["diagnostics/frequency"][[first, last]]
    return {"coherent_Hz": ends, "coherent_percent": 100.0 * found[first : last + 1].mean()}


def _changes(rows: pd.DataFrame) -> bool:
    """A value is further from the weighted mean than chance, at 5 % over all places (Bonferroni)."""
    value, error = (rows[name].to_numpy() for name in ("value", "standard_error"))
    mean = np.average(value, weights=error**-2.0)
    limit = statistics.NormalDist().inv_cdf(1.0 - 0.5 * LEVEL / value.size)
    return bool((np.abs(value - mean) > limit * error).any())


# ---- conditions of sentences


def participants_named(run: Run) -> bool:
    """The trial sheet names the participant of a trial with an operating point."""
    points = run.tables.get("operating_points")
    return points is not None and bool(points.participant.notna().any())


def more_than_shown(run: Run) -> bool:
    """There are more trials than figures with a row for each show."""
    return len(run.fits["position_manipulator"]) > SHOWN_TRIALS


def alone_predicts(run: Run) -> bool:
    """Inertia, damping and stiffness alone predict a part of the held-out torque of every trial."""
    return bool((_held_out(run, ESTIMATOR) > 0.0).all())


def reflex_raises(run: Run) -> bool:
    """The parallel-cascade model raises the held-out VAF of every trial."""
    alone, both = (_held_out(run, name) for name in (ESTIMATOR, REFLEX_ESTIMATOR))
    return len(both) > 0 and bool((both > alone).all())


def slow_raises(run: Run) -> bool:
    """The measured torque of just before raises the held-out VAF of every trial."""
    slow = _held_out(run, REFLEX_ESTIMATOR, "VAF_held_out_with_slow_torque")
    return bool((slow > _held_out(run, REFLEX_ESTIMATOR)).all())


def _held_out(run: Run, estimator: str, quantity: str = "VAF_held_out") -> pd.Series:
    found = run.values("position_manipulator", quantity, estimator=estimator)
    return found.reindex(list(run.fits["position_manipulator"]))


def short_range(run: Run) -> bool:
    """A trial has short-range stiffness."""
    return any(fit.facts["reflex"]["short_range"] for fit in run.fits["position_manipulator"].values())


def white(run: Run) -> bool:
    """The residual of every trial is white."""
    return all(residual["white_p"] >= LEVEL for residual in _residuals(run))


def mostly_slow(run: Run) -> bool:
    """More than half of the residual's power lies below 1 Hz in every trial."""
    return all(residual["below_1_hz_percent"] > 50.0 for residual in _residuals(run))


def _residuals(run: Run) -> list[dict]:
    return [fit.facts["diagnostics"]["residual"] for fit in run.fits["position_manipulator"].values()]


def stiffer_when_small(run: Run) -> bool:
    """In every trial with short-range stiffness, the smallest movements meet more than K beyond it."""
    small, beyond = (
        run.values("position_manipulator", quantity, estimator=REFLEX_ESTIMATOR)
        for quantity in ("K_short_range", "K")
    )
    small = small.dropna()
    return len(small) > 0 and bool((small > beyond.reindex(small.index)).all())


PREDICATES = (
    participants_named,
    more_than_shown,
    alone_predicts,
    reflex_raises,
    slow_raises,
    short_range,
    white,
    mostly_slow,
    stiffer_when_small,
)
