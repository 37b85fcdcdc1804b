"""Quantities as rows: of estimates with intervals, and of the sources of their uncertainty."""

import math
from collections.abc import Mapping, Sequence
from typing import Annotated

import numpy as np

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


def cross_validation_rows(
    names: Sequence[Names], matrix: Annotated[np.ndarray, "(trials, trials)", "%"]
) -> list[Estimate]:
    """Mean VAF of each trial's parameters on the other trials; no rows of a single trial.

    names: of the trials, in the order of the matrix.
    matrix: VAF by the parameters of the row's trial, of the signals of the column's.
    """
    if len(names) < 2:
        return []
    others = [float(np.delete(vafs, k).mean()) for k, vafs in enumerate(matrix)]
    return [
        row
        for trial, vaf in zip(names, others, strict=True)
        for row in rows_of(trial, {"VAF_cross_validated": Quantity(vaf, "%")})
    ]


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
