"""Chapter on the position-controlled manipulator: numbers of its fits."""

import statistics

import numpy as np
import pandas as pd

from tepsipe.experiments.position_manipulator.analysis import TERMS
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
        "shown_trials": SHOWN_TRIALS,
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
