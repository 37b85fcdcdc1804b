"""Rows of the uncertainty budgets, source by source (``results/tables/uncertainty.csv``)."""

from dataclasses import dataclass

from tepsipe.io.tables import Table

TYPES = ("A", "B")
SCATTER = "scatter"  # the source of Type A


@dataclass(frozen=True)
class Contribution:
    """Contribution of one source to the uncertainty of one estimate."""

    experiment: str
    condition: str
    pathway: str
    estimator: str
    quantity: str
    unit: str
    """The estimate, as in `tepsipe.io.estimates.Estimate`."""
    source: str
    """Name of the source, with its own unit; `SCATTER` for Type A."""
    type: str
    """{"A", "B"}: Whether it is seen in the scatter of the trial, or known otherwise."""
    u: float
    """Standard uncertainty that it contributes to the estimate (``unit``), never negative."""


def _check(row: Contribution) -> None:
    if row.type not in TYPES or not row.u >= 0.0:
        raise ValueError(f"{row.u:g} of type {row.type!r}")


CONTRIBUTIONS = Table(Contribution, "uncertainty budgets", check=_check)
