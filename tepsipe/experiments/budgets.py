"""Quantities and their uncertainty budgets as rows: of estimates with intervals, and of sources."""

import math
from collections.abc import Iterable, Mapping, Sequence
from itertools import repeat

from tepsipe.identification.result import Quantity
from tepsipe.io.estimates import SCATTER, Contribution, Estimate
from tepsipe.quantities import plain_unit
from tepsipe.statistics.uncertainty import Budget


def rows_of(
    names: tuple[str, str, str, str],
    quantities: Mapping[str, Quantity],
    n_perturbations: int | None = None,
    printed: Iterable[float | None] = repeat(None),
) -> list[Estimate]:
    """Rows of the table of estimates for the quantities of one trial, pathway and estimator.

    names: experiment, condition, pathway and estimator.
    printed: standard errors by thesis eq (3-2) as printed, in the order of the quantities.
    """
    rows = []
    for (name, q), sem in zip(quantities.items(), printed, strict=False):
        uncertain = q.u_type_a is not None or not math.isnan(q.standard_error)
        interval = (q.standard_error, q.low, q.high) if uncertain else (None, None, None)
        head = (*names, name, plain_unit(q.unit), q.value)
        types, flags = (q.u_type_a, q.u_type_b), "" if q.identified else "not-identified"
        rows.append(Estimate(*head, *interval, sem, n_perturbations, *types, flags=flags))
    return rows


def contributions_of(
    rows: Sequence[Estimate], budget: Budget, quantities: Sequence[str]
) -> list[Contribution]:
    """Rows of the table of budgets for the estimates of one trial, pathway and estimator.

    quantities: names of the budget's estimates, in their order. Rows of other quantities are passed over.
    Returns: Type A comes first; contributions that are not finite, as with a single perturbation, are left
    out.
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
