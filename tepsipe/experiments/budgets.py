"""Quantities as rows: of estimates with intervals, and of the sources of their uncertainty."""

import math
from collections.abc import Mapping

from tepsipe.identification.result import Quantity
from tepsipe.io.estimates import Contribution, Estimate
from tepsipe.quantities import plain_unit
from tepsipe.statistics.uncertainty import SCATTER

# experiment, condition, pathway and estimator
Names = tuple[str, str, str, str]


def rows_of(
    names: Names, quantities: Mapping[str, Quantity], n_perturbations: int | None = None
) -> list[Estimate]:
    """Rows of the table of estimates for the quantities of one trial, pathway and estimator.

    An uncertainty that is NaN has no cell, but that of a quantity with a Type A uncertainty was lost.
    """
    rows = []
    for name, q in quantities.items():
        numbers = (q.standard_error, q.low, q.high)
        interval = (None if q.u_type_a is None and math.isnan(x) else x for x in numbers)
        flags = q.flags if q.identified else ("not-identified", *q.flags)
        row = (*names, name, plain_unit(q.unit), q.value, *interval, q.as_printed, n_perturbations)
        rows.append(Estimate(*row, q.u_type_a, q.u_type_b, flags=";".join(flags)))
    return rows


def contributions_of(names: Names, quantities: Mapping[str, Quantity]) -> list[Contribution]:
    """Rows of the table of budgets for the same quantities, as far as they have a budget.

    Type A comes first. Contributions that are not finite, as with a single perturbation, are left out.
    """
    return [
        Contribution(*names, name, plain_unit(q.unit), source, "A" if source == SCATTER else "B", u)
        for name, q in quantities.items()
        for source, u in q.parts.items()
        if math.isfinite(u)
    ]
