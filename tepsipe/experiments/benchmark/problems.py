"""Problems of a benchmark's folder as arrays, and the quantities that an answer states.

The folder holds ``problems.csv`` (problem and kind), ``windows.csv`` (times to which the truth refers),
``facts.json`` (what an analysis may know) and ``arrays/<problem>.csv``. The truth lies elsewhere: nothing
here reads it.
"""

import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np

from tepsipe.errors import InputError, listed
from tepsipe.io.readers.plain_file import read_text
from tepsipe.io.readers.text_table import read_text_table
from tepsipe.io.tables import Table
from tepsipe.mechanics.inverse_dynamics import Leg
from tepsipe.mechanics.segment_kinematics import SegmentMarkers

UNITS = {"I": "Nms2/rad", "B": "Nms/rad", "K": "Nm/rad"}
LEGS = ("passive", "softening")
# kind of a problem -> quantities that an answer states, in `UNITS`
QUANTITIES = {
    "passive": ("I", "B", "K"),
    "softening": ("I", "B", "K"),
    "ankle": ("I", "B", "K"),
    "standing": ("B", "K"),
}
PROBLEMS, WINDOWS, FACTS, ARRAYS = "problems.csv", "windows.csv", "facts.json", "arrays"
INSTRUMENTS = "instruments"
# columns of the arrays: key -> name; an ankle in a manipulator has no belt
COLUMNS = {"time": "time_s", "angle": "angle_rad", "torque": "torque_Nm", "belt": "belt_velocity_m_per_s"}


@dataclass(frozen=True)
class Named:
    """One row of ``problems.csv``."""

    problem: str
    kind: str
    """Name of the problem, which ends in digits of its round, and one of `QUANTITIES`."""


NAMED = Table(Named, "problems of a benchmark")


@dataclass(frozen=True)
class WindowRow:
    """One row of ``windows.csv``."""

    problem: str
    start_s: float
    end_s: float
    """Part of the recording to which the truth refers: from the onset of a pulse on."""


WINDOW_ROWS = Table(WindowRow, "windows of a benchmark")


@dataclass(frozen=True)
class AnswerRow:
    """One row of a table of answers."""

    problem: str
    quantity: str
    """Problem and quantity, one of `QUANTITIES`."""
    value: float | None
    low: float | None
    high: float | None
    """Estimate and ends of its 95 % interval, in `UNITS`; None where there is none."""
    flagged: bool
    """Whether its author would not rely on the recording."""


ANSWERS = Table(AnswerRow, "answers to a benchmark")


@dataclass(frozen=True)
class Problem:
    """One problem as arrays."""

    name: str
    kind: str
    """Name and kind, one of `QUANTITIES`."""
    signals: dict[str, np.ndarray]
    """Samples by the keys of `COLUMNS` (s, rad, N·m, m/s)."""
    positions: Annotated[np.ndarray, "(n, markers, 2)", "m"] | None
    """Positions y, z of the markers, of a leg on a belt."""
    facts: dict
    """What an analysis may know (units in the keys)."""

    @property
    def leg(self) -> Leg:
        """Nominal leg (kg, m, kg·m²)."""
        return Leg(**self.facts["leg"])

    @property
    def markers(self) -> SegmentMarkers:
        """Markers on the leg and their nominal places (m)."""
        layout = self.facts["layout_m"]
        return SegmentMarkers(tuple(layout), np.array(list(layout.values())))


def read_problems(folder: Path) -> Iterator[Problem]:
    """Read the problems of a folder, one after the other, in the order of its list."""
    named = NAMED.read(folder / PROBLEMS)
    unknown = [row.kind for row in named if row.kind not in QUANTITIES]
    if unknown:
        raise InputError(
            f"{folder / PROBLEMS}: expected the kinds {listed(QUANTITIES)}, found {listed(unknown[:1])}: "
            "take the folder as its organiser published it"
        )
    try:
        facts = json.loads(read_text(folder / FACTS, "facts of a benchmark"))
        facts = {row.kind: facts[row.kind] for row in named}
    except (ValueError, KeyError, TypeError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(
            f"{folder / FACTS}: expected JSON with the facts of every kind, found a damaged file ({error}): "
            "take the folder as its organiser published it"
        ) from error
    for row in named:
        yield _read(folder, row, facts[row.kind])


def _read(folder: Path, row: Named, facts: dict) -> Problem:
    path = folder / ARRAYS / f"{row.problem}.csv"
    columns = {key: name for key, name in COLUMNS.items() if key != "belt" or row.kind != "ankle"}
    of_markers = {f"{label}_{axis}": f"{label}_{axis}_m" for label in facts["labels"] for axis in "yz"}
    named_by = dict.fromkeys({**columns, **of_markers}, "the benchmark")
    table = read_text_table(path, columns | of_markers, ",", named_by)
    positions = None
    if of_markers:
        positions = np.stack([table[key] for key in of_markers], axis=1).reshape(-1, len(facts["labels"]), 2)
    return Problem(row.problem, row.kind, {key: table[key] for key in columns}, positions, facts)
