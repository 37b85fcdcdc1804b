"""Agreement between simulations and recordings: the rows of ``results/tables/forward.csv``."""

from collections.abc import Iterable
from dataclasses import dataclass, fields
from pathlib import Path

from tepsipe.io.csv_table import read_rows, write_rows


@dataclass(frozen=True)
class ForwardScore:
    """Agreement between a simulation and a recording.

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


def write_forward(path: str | Path, scores: Iterable[ForwardScore]) -> None:
    """Write scores as CSV, numbers with 10 significant digits (%)."""
    write_rows(path, ForwardScore, scores)


def read_forward(path: str | Path) -> list[ForwardScore]:
    """Read scores written by `write_forward` (%).

    Raises
    ------
    InputError
        If the columns are not those of `ForwardScore`, or a row is damaged.
    """
    return read_rows(path, ForwardScore, _score, "scores of simulations")


def _score(cells: dict[str, str]) -> ForwardScore:
    kinds = {field.name: field.type for field in fields(ForwardScore)}
    return ForwardScore(**{key: kinds[key](value) for key, value in cells.items()})
