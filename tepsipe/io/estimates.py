"""Tidy rows of estimates, the common format of all experiments (``results/tables/estimates.csv``)."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from tepsipe.io.csv_table import read_rows, write_rows


@dataclass(frozen=True)
class Estimate:
    """One estimated quantity.

    Attributes
    ----------
    experiment, condition : str
        The trial.
    pathway, estimator : str
        How the torque was computed, and how the parameters were estimated.
    quantity, unit : str
        For example I in Nms2/rad, or VAF_trial in %.
    value : float
        The estimate (``unit``).
    standard_error, ci_low, ci_high : float or None
        Standard error and 95 % interval (``unit``); None where there is none.
    sem_as_printed : float or None
        Thesis eq (3-2) as printed; None where there is none.
    n_perturbations : int or None
        Number of perturbations behind the value (-).
    """

    experiment: str
    condition: str
    pathway: str
    estimator: str
    quantity: str
    unit: str
    value: float
    standard_error: float | None = None
    ci_low: float | None = None
    ci_high: float | None = None
    sem_as_printed: float | None = None
    n_perturbations: int | None = None


NUMBERS = ("value", "standard_error", "ci_low", "ci_high", "sem_as_printed")


# columns that may follow those of `Estimate`
LABELS = ("participant", "belt")


def write_estimates(
    path: str | Path, estimates: Iterable[Estimate], labels: Mapping[str, Sequence[str]] | None = None
) -> None:
    """Write rows as CSV, numbers with 10 significant digits (units in the column ``unit``).

    ``labels`` are columns of `LABELS` that follow, with one cell per row.
    """
    write_rows(path, Estimate, estimates, further=labels)


def read_estimates(path: str | Path) -> list[Estimate]:
    """Read rows written by `write_estimates`, without labels (units in the column ``unit``).

    Raises
    ------
    InputError
        If the columns are not those of `Estimate`, or a row is damaged.
    """
    return read_rows(path, Estimate, _estimate, "estimates", LABELS)


def _estimate(row: dict[str, str]) -> Estimate:
    cells: dict = dict(row)
    for name in NUMBERS:
        cells[name] = float(row[name]) if row[name] else None
    cells["n_perturbations"] = int(row["n_perturbations"]) if row["n_perturbations"] else None
    return Estimate(**cells)
