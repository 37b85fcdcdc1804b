"""Rows of the uncertainty budgets, source by source (``results/tables/uncertainty.csv``)."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from tepsipe.io.csv_table import read_rows, write_rows

TYPES = ("A", "B")
SCATTER = "scatter"  # the source of Type A


@dataclass(frozen=True)
class Contribution:
    """What one source contributes to the uncertainty of one estimate.

    Attributes
    ----------
    experiment, condition, pathway, estimator, quantity, unit : str
        The estimate, as in `tepsipe.io.estimates.Estimate`.
    source : str
        Name of the source, with its own unit; `SCATTER` for Type A.
    type : {"A", "B"}
        Whether it is seen in the scatter of the trial, or known otherwise.
    u : float
        Standard uncertainty that it contributes to the estimate (``unit``), never negative.
    """

    experiment: str
    condition: str
    pathway: str
    estimator: str
    quantity: str
    unit: str
    source: str
    type: str
    u: float


def write_budgets(path: str | Path, rows: Iterable[Contribution]) -> None:
    """Write rows as CSV, numbers with 10 significant digits (units in the column ``unit``)."""
    write_rows(path, Contribution, rows)


def read_budgets(path: str | Path) -> list[Contribution]:
    """Read rows written by `write_budgets` (units in the column ``unit``).

    Raises
    ------
    InputError
        If the columns are not those of `Contribution`, or a row is damaged.
    """
    return read_rows(path, Contribution, _contribution, "uncertainty budgets")


def _contribution(row: dict[str, str]) -> Contribution:
    u = float(row["u"])
    if row["type"] not in TYPES or not u >= 0.0:
        raise ValueError(f"{row['u']!r} of type {row['type']!r}")
    return Contribution(**(row | {"u": u}))
