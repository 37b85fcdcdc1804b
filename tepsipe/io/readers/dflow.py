"""Text files of D-Flow (Motek): the mocap module's markers and forces, the record module's belt speeds.

The layout is that described in the documentation of the Gait Analysis Toolkit (Moore et al., "Motek
module", github.com/csu-hmc/GaitAnalysisToolKit, docs/motek.rst). Both files are separated by tabs. The
mocap module writes one row per frame of the motion capture system: ``TimeStamp`` (s, when D-Flow received
the frame), ``FrameNumber``, ``<marker>.PosX`` to ``.PosZ`` (m), ``FP1.ForX`` to ``.ForZ`` (N), ``.MomX`` to
``.MomZ`` (N·m), ``.CopX`` to ``.CopZ`` (m), the same of ``FP2``, and ``Channel<n>.Anlg`` (V). The record
module writes ``Time`` (s, on the same clock as ``TimeStamp``) and whatever signals were chosen, at an
irregular rate of up to 300 Hz; events stand between its rows, on lines that begin with ``#``. A hidden
marker is 0 in all three coordinates or, before version 3.16.2, keeps its last position.

D-Flow's axes: x to the right, y up, z backward for a person who walks forward.
"""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tepsipe.errors import InputError, listed
from tepsipe.io.readers.plain_table import read_plain_table

TIMES = ("TimeStamp", "Time")
FRAME = "FrameNumber"
MARKER = re.compile(r"(.+)\.Pos([XYZ])")
PLATE = re.compile(r"FP(\d+)\.(For|Mom|Cop)([XYZ])")
ANALOG = re.compile(r"Channel\d+\.Anlg")
SPEED = re.compile(r"speed|velocity", re.IGNORECASE)
# a marker with exactly the same position for this number of frames was hidden
HELD_FRAMES = 3
AXES = "XYZ"


@dataclass(frozen=True)
class DFlowTable:
    """One file of D-Flow, row by row as it was written."""

    name: str
    """Names the file in messages."""
    time: np.ndarray
    """Time stamps (s), on D-Flow's clock."""
    frames: np.ndarray | None
    """Counter of the frames of the motion capture system; None if the file has none."""
    columns: dict[str, np.ndarray]
    """All other columns, in the units of D-Flow."""
    lines: np.ndarray
    """Line of the file on which each row stands."""

    @property
    def is_mocap(self) -> bool:
        """True if the file holds markers or force plates."""
        return any(MARKER.fullmatch(name) or PLATE.fullmatch(name) for name in self.columns)

    @property
    def speeds(self) -> tuple[str, ...]:
        """Names of the columns that hold a belt's speed (m/s there)."""
        return tuple(name for name in self.columns if SPEED.search(name))


def read_dflow(path: str | Path) -> DFlowTable:
    """Read a text file of D-Flow's mocap or record module.

    path: the file, plain or compressed with gzip.
    Returns: time stamps, frame counter and columns in the units of D-Flow.
    """
    table = read_plain_table(path, "a text file of D-Flow")
    time = next((name for name in TIMES if name in table.names), None)
    if time is None or table.delimiter != "\t":
        raise InputError(
            f"{path}: expected a text file of D-Flow with the tab-separated column 'TimeStamp' or 'Time', "
            f"found {listed(table.names)}: check which file the trial sheet names"
        )
    twice = next((name for name in table.names if table.names.count(name) > 1), None)
    if twice is not None:
        raise InputError(
            f"{path}: expected one column named {twice!r}, found {table.names.count(twice)}: rename one in "
            "the header"
        )
    columns = {n: table.values[:, k] for k, n in enumerate(table.names) if n not in (time, FRAME)}
    frames = _frames(table) if FRAME in table.names else None
    return DFlowTable(str(path), table.column(time), frames, columns, table.lines)


def _frames(table) -> np.ndarray:
    """Frame counter, refused where it is not whole or runs backwards."""
    counter = table.column(FRAME)
    bad = np.flatnonzero(~np.isfinite(counter) | (counter != np.round(counter)) | (np.abs(counter) > 1e15))
    if bad.size:
        raise InputError(
            f"{table.name}: expected whole numbers in {FRAME!r}, found {counter[bad[0]]:g} on line "
            f"{table.lines[bad[0]]}: repair the file or export it again"
        )
    back = np.flatnonzero(np.diff(counter) < 0.0)
    if back.size:
        k = back[0]
        raise InputError(
            f"{table.name}: expected {FRAME!r} to increase, found it jumping back from {counter[k]:.0f} to "
            f"{counter[k + 1]:.0f} on line {table.lines[k + 1]}: the motion capture was restarted, cut the "
            "file into trials there"
        )
    return counter.astype(np.int64)


def marker_columns(table: DFlowTable) -> dict[str, np.ndarray]:
    """Positions of every marker that has all three coordinates, each of shape (n, 3) (m).

    NaN where the marker was hidden: 0 in all coordinates, or the same in all coordinates for three frames.
    """
    labels = dict.fromkeys(m[1] for name in table.columns if (m := MARKER.fullmatch(name)))
    markers = {}
    for label in labels:
        names = [f"{label}.Pos{axis}" for axis in AXES]
        if all(name in table.columns for name in names):
            position = np.column_stack([table.columns[name] for name in names])
            position[(position == 0.0).all(axis=1) | held(position, table.frames)] = np.nan
            markers[label] = position
    return markers


def held(position: np.ndarray, frames: np.ndarray | None) -> np.ndarray:
    """Frames in which a marker (m), shape (n, 3), only repeats its last position, shape (n,).

    The first of a run of at least three equal positions is a measurement, the others are not. Rows that
    repeat a frame do not count.
    """
    new = (
        np.ones(len(position), dtype=bool) if frames is None else np.diff(frames, prepend=frames[0] - 1) != 0
    )
    kept = position[new]
    same = np.concatenate([[False], (np.diff(kept, axis=0) == 0.0).all(axis=1)])
    run = np.zeros(len(kept), dtype=int)  # how many equal positions precede
    for k in np.flatnonzero(same):
        run[k] = run[k - 1] + 1
    repeated = same.copy()
    for k in np.flatnonzero(same & ~np.append(same[1:], False)):  # the last of each run
        if run[k] < HELD_FRAMES - 1:
            repeated[k - run[k] + 1 : k + 1] = False
    is_held = np.zeros(len(position), dtype=bool)
    is_held[np.flatnonzero(new)] = repeated
    return is_held


def plate_columns(table: DFlowTable) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Force (N) and moment about the origin (N·m) of every force plate, each of shape (n, 3)."""
    numbers = sorted({int(m[1]) for name in table.columns if (m := PLATE.fullmatch(name))})
    plates = {}
    for number in numbers:
        names = [f"FP{number}.{kind}{axis}" for kind in ("For", "Mom") for axis in AXES]
        missing = [name for name in names if name not in table.columns]
        if missing:
            raise InputError(
                f"{table.name}: expected the columns {names[0]!r} to {names[-1]!r}, found none named "
                f"{missing[0]!r}: export forces and moments of the force plate"
            )
        six = np.column_stack([table.columns[name] for name in names])
        plates[f"FP{number}"] = six[:, :3], six[:, 3:]
    return plates


def unit_of(name: str) -> str:
    """Unit of a column of D-Flow by its name: V, m/s, N, Nm, m, deg; empty if unknown."""
    if ANALOG.fullmatch(name):
        return "V"
    if (plate := PLATE.fullmatch(name)) is not None:
        return {"For": "N", "Mom": "Nm", "Cop": "m"}[plate[2]]
    if MARKER.fullmatch(name):
        return "m"
    if SPEED.search(name):
        return "m/s"
    endings = {".Ang": "deg", ".Mom": "Nm", ".Pow": "W"}
    return next((unit for ending, unit in endings.items() if name.endswith(ending)), "")
