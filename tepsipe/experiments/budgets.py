"""Quantities and their uncertainty budgets as rows: of estimates with intervals, and of sources."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from tepsipe.identification.result import Quantity
from tepsipe.io.estimates import SCATTER, Contribution, Estimate
from tepsipe.mechanics.impedance_model import UNITS
from tepsipe.statistics.uncertainty import Budget


def rows_of(names: tuple[str, str, str, str], quantities: Mapping[str, Quantity]) -> list[Estimate]:
    """Rows of quantities with intervals, by their names in `UNITS`.

    names: experiment, condition, pathway and estimator.
    """
    return [
        Estimate(*names, name, UNITS[name], q.value, q.standard_error, q.low, q.high)
        for name, q in quantities.items()
    ]


def with_budget(rows: Sequence[Estimate], budget: Budget, quantities: Sequence[str]) -> list[Estimate]:
    """Rows with the combined standard error and 95 % interval of a budget.

    rows: estimates of one trial, pathway and estimator.
    budget: uncertainty of ``quantities``. Without contributions Type B was not evaluated, and its cell is
    empty.
    quantities: names of its p estimates, in their order. Rows of other quantities are returned unchanged.
    Returns: in the order of ``rows``.
    """
    low, high = budget.interval(np.zeros(len(quantities)))
    evaluated = bool(budget.contributions)
    joined = []
    for row in rows:
        if row.quantity in quantities:
            k = list(quantities).index(row.quantity)
            row = replace(
                row,
                standard_error=float(budget.combined[k]),
                ci_low=row.value + float(low[k]),
                ci_high=row.value + float(high[k]),
                u_type_a=float(budget.type_a[k]),
                u_type_b=float(budget.type_b[k]) if evaluated else None,
            )
        joined.append(row)
    return joined


def contributions_of(
    rows: Sequence[Estimate], budget: Budget, quantities: Sequence[str]
) -> list[Contribution]:
    """Rows of the table of budgets for the estimates of one trial, pathway and estimator.

    Takes the arguments of `with_budget`. Type A comes first; contributions that are not finite,
    as with a single perturbation, are left out.
    """
    contributions = []
    for row in rows:
        if row.quantity not in quantities:
            continue
        k = list(quantities).index(row.quantity)
        parts = [(SCATTER, "A", float(budget.type_a[k]))]
        parts += [(name, "B", float(budget.of_source(name)[k])) for name in budget.contributions]
        names = (row.experiment, row.condition, row.pathway, row.estimator, row.quantity, row.unit)
        contributions += [Contribution(*names, *part) for part in parts if math.isfinite(part[2])]
    return contributions
