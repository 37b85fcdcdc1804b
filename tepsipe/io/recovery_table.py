"""Rows of estimates beside their true values (``results/tables/recovery.csv``)."""

from dataclasses import dataclass

from tepsipe.io.tables import Table, Undefinable


@dataclass(frozen=True)
class Recovery:
    """One estimate and its true value; the fields are the columns of ``tables/recovery.csv``."""

    experiment: str
    condition: str
    pathway: str
    estimator: str
    quantity: str
    unit: str
    """The estimate, as in `tepsipe.io.estimates.Estimate`."""
    truth: float
    """The laboratory's constant, or the value of the nearest linear joint (``unit``)."""
    value: Undefinable
    """The estimate (``unit``)."""
    relative_error: float | None
    """(value - truth) / truth; None where it is not finite."""
    covered: bool | None
    """True if the 95 % interval contains the truth; None without an interval."""
    truth_of: str
    """Movements for which the truth holds."""
    recommended: bool = False
    """True if the study recommends the estimate."""
    flags: str = ""
    """Names of the checks that the trial failed for it, joined by ";"."""


RECOVERIES = Table(Recovery, "estimates beside the truth")
