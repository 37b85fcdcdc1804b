"""How well simulations follow recordings: the rows of ``results/tables/forward.csv``."""

import csv
from collections.abc import Iterable
from dataclasses import astuple, dataclass, fields
from pathlib import Path

from tepsipe.errors import InputError


@dataclass(frozen=True)
class ForwardScore:
    """How well a simulation follows a recording.

    Attributes
    ----------
    condition, parameter_set : str
        The trial and the set of parameters.
    quantity : {"theta", "tau", "tau_consistent"}
        The angle, or a torque by inverse dynamics.
    vaf_perturbation, vaf_trial : float
        Mean VAF of the perturbations and VAF of the trial, thesis eq (3-1) (%).
    state : str
        Whether the simulated leg settles, grows or falls.
    """

    condition: str
    parameter_set: str
    quantity: str
    vaf_perturbation: float
    vaf_trial: float
    state: str


COLUMNS = tuple(field.name for field in fields(ForwardScore))


def write_forward(path: str | Path, scores: Iterable[ForwardScore]) -> None:
    """Write scores as CSV, numbers with 10 significant digits (%)."""
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for row in scores:
            writer.writerow(f"{cell:.10g}" if isinstance(cell, float) else cell for cell in astuple(row))


def read_forward(path: str | Path) -> list[ForwardScore]:
    """Read scores written by `write_forward` (%).

    Raises
    ------
    InputError
        If the columns are not those of `ForwardScore`, or a row is damaged.
    """
    with open(path, newline="", encoding="utf-8") as file:
        reader = csv.DictReader(file)
        if tuple(reader.fieldnames or ()) != COLUMNS:
            raise InputError(
                f"{path}: expected the columns {', '.join(COLUMNS)}, found "
                f"{', '.join(reader.fieldnames or ['none'])}: make the file again"
            )
        kinds = {field.name: field.type for field in fields(ForwardScore)}
        try:
            rows = list(reader)
            if any(None in row or None in row.values() for row in rows):
                raise ValueError("too many or too few cells")
            return [ForwardScore(**{key: kinds[key](row[key]) for key in COLUMNS}) for row in rows]
        except (TypeError, ValueError) as error:
            raise InputError(
                f"{path}: expected scores of simulations, found a damaged row ({error}): make the file again"
            ) from error
