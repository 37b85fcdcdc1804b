"""Tidy rows of estimates: the study's common language (``results/tables/estimates.csv``)."""

import csv
from collections.abc import Iterable
from dataclasses import astuple, dataclass, fields
from pathlib import Path

from tepsipe.errors import InputError


@dataclass(frozen=True)
class Estimate:
    """One estimated quantity.

    Attributes
    ----------
    experiment, condition : str
        The trial.
    pathway, estimator : str
        How the torque was obtained, and how the parameters were.
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


COLUMNS = tuple(field.name for field in fields(Estimate))
NUMBERS = ("value", "standard_error", "ci_low", "ci_high", "sem_as_printed")


def write_estimates(path: str | Path, estimates: Iterable[Estimate]) -> None:
    """Write rows as CSV, numbers with 10 significant digits (units in the column ``unit``)."""
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for estimate in estimates:
            writer.writerow(
                "" if cell is None else f"{cell:.10g}" if isinstance(cell, float) else cell
                for cell in astuple(estimate)
            )


def read_estimates(path: str | Path) -> list[Estimate]:
    """Read rows written by `write_estimates` (units in the column ``unit``).

    Raises
    ------
    InputError
        If the columns are not those of `Estimate`.
    """
    with open(path, newline="", encoding="utf-8") as file:
        reader = csv.DictReader(file)
        if tuple(reader.fieldnames or ()) != COLUMNS:
            raise InputError(
                f"{path}: expected the columns {', '.join(COLUMNS)}, found "
                f"{', '.join(reader.fieldnames or ['none'])}: make the file again"
            )
        return [_estimate(row) for row in reader]


def _estimate(row: dict[str, str]) -> Estimate:
    cells: dict = dict(row)
    for name in NUMBERS:
        cells[name] = float(row[name]) if row[name] else None
    cells["n_perturbations"] = int(row["n_perturbations"]) if row["n_perturbations"] else None
    return Estimate(**cells)
