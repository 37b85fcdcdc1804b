"""Uncertainty budgets: sizes of their parts, the largest source, and the effect of repetition."""

import math

import numpy as np
import pandas as pd

from tepsipe.reporting.budgets import SHOWN, RelativeBudget, budgeted, relative_budgets, source_words
from tepsipe.reporting.run import Run
from tepsipe.statistics.uncertainty import SCATTER

MORE = 4  # times as much data, in the table of budgets


def numbers(run: Run) -> dict:
    """Name of a budget, an experiment or foot -> its pathway, estimator and quantities (%)."""
    found = {}
    for name, own in _budgeted(run).items():
        budgets = _relative(run, own)
        if budgets:
            found[name] = {
                "pathway": own[0].pathway,
                "estimator": own[0].estimator,
                "sources": list(dict.fromkeys(s for b in budgets.values() for s in b.percent)),
                "more": MORE,
                "quantities": [
                    _parts(b, [e for e in own if e.quantity == q]) | largest_source(b)
                    for q, b in budgets.items()
                ],
            }
    return found


def _budgeted(run: Run) -> dict:
    return budgeted(run.tables["estimates"].itertuples(), run.study["foot_pathway"])


def _relative(run: Run, estimates: list) -> dict[str, RelativeBudget]:
    return relative_budgets(run.tables["uncertainty"].itertuples(), estimates, SHOWN)


def _parts(budget: RelativeBudget, estimates: list) -> dict:
    """Type A, Type B and half-widths of the 95 % intervals of the trials (%), and numbers of estimates.

    ``kept`` are in the budget, ``all`` includes those whose interval includes 0.
    """
    half = [
        50.0 * (e.ci_high - e.ci_low) / abs(e.value)
        for e in estimates
        if e.condition in budget.conditions and pd.notna(e.ci_low) and pd.notna(e.ci_high)
    ]
    parts = {"type_a": budget.type_a, "type_b": budget.type_b, "half_width": half}
    counts = {"quantity": budget.quantity, "kept": len(budget.conditions), "all": len(estimates)}
    return counts | {f"{name}_percent": values for name, values in parts.items()}


def largest_source(budget: RelativeBudget) -> dict:
    """The largest source in the median, its size (%), and 1.96 standard uncertainties with repetition (%).

    ``repeating``: it is Type A, which more data reduce. ``after`` holds with `MORE` times as much data if it
    is, with any amount if not.
    """
    repeating = budget.largest == SCATTER
    return {
        "largest": source_words(budget.largest),
        "size_percent": float(np.nanmedian(budget.percent[budget.largest])),
        "repeating": repeating,
        "now_percent": budget.expanded(1.0),
        "after_percent": budget.expanded(MORE if repeating else math.inf),
    }
