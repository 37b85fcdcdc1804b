"""Numbers on a recorded treadmill that stand beside the scores of its models."""

from collections.abc import Sequence

from tepsipe.reporting.figures.names import words
from tepsipe.reporting.numbers.format import by_uncertainty, number, percent
from tepsipe.treadmill.calibration import ModelScore

# models that need the measured load of the past, besides the motion of the belt
WITH_LOAD = ("ripple-tracking",)
# models that look ahead, and so delay a compensation in real time
AHEAD = ("fir", "spectral")
# gain of R² (-) for which a larger model is recommended
WORTH = 0.005


def belt_data(facts: dict, scores: Sequence[ModelScore], shown_hz: float) -> dict:
    """Coefficients, range of validity, cross-prediction and recommendation as text.

    Parameters
    ----------
    facts : dict
        Of the result of the calibration: coefficients, calibrated, beyond, crossed, recordings (their units).
    scores : sequence of ModelScore
        One per model, test and cutoff (units in them).
    shown_hz : float
        Cutoff of the report (Hz).

    Returns
    -------
    dict
        ``spring`` (m, c, k with intervals), ``discrete``, ``ranges``, ``beyond``, ``crossed``,
        ``recommended`` and ``recommended_live`` (None if no model predicts anything).
    """
    own = [s for s in scores if s.cutoff_hz == shown_hz and s.test == facts["recordings"][0]]
    coefficients = facts["coefficients"]
    spring = coefficients.get("mass-spring-damper")
    return {
        "spring": None
        if spring is None
        else {term: by_uncertainty(*values) for term, values in spring.items()},
        "discrete": [
            {
                "model": name,
                "numerator": [number(x) for x in found["numerator"]],
                "denominator": [number(x) for x in found["denominator"]],
            }
            for name, found in coefficients.items()
            if "numerator" in found
        ],
        "ranges": {name: [number(x) for x in ends] for name, ends in facts["calibrated"].items()},
        "beyond": [[name, percent(100.0 * share)] for name, share in facts["beyond"].items()],
        "crossed": _crossed(facts["crossed"]),
        "recommended": _best([s for s in own if s.model not in WITH_LOAD]),
        "recommended_live": _best([s for s in own if s.model not in (*WITH_LOAD, *AHEAD)]),
    }


def _best(scores: list[ModelScore]) -> dict | None:
    """The smallest model whose R² is within WORTH of the best converged one; None if none predicts."""
    known = [s for s in scores if s.converged and s.r2 > 0.0]
    if not known:
        return None
    highest = max(s.r2 for s in known)
    chosen = min((s for s in known if s.r2 >= highest - WORTH), key=lambda s: s.order)
    return {
        "model": chosen.model,
        "looks_ahead": chosen.model in AHEAD,
        "r2": number(chosen.r2, 3),
        "less": percent(100.0 * (1.0 - chosen.rms_after / chosen.rms_before), 0),
    }


def _crossed(crossed: dict) -> dict | None:
    if not crossed:
        return None
    recordings = list(next(iter(crossed.values())))
    return {
        "recordings": recordings,
        "rows": [
            {
                "model": words(model),
                "train": train,
                "cells": [number(tests[test], 3) if tests[test] > -10.0 else "< −10" for test in recordings],
            }
            for model, trained in crossed.items()
            for train, tests in trained.items()
        ],
    }
