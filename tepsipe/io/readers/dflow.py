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

D-Flow stamps a frame when it receives it, not when it was taken: frames queue up and are stamped together.
The clock of a recording is therefore the frame counter, and stamps only give its rate.
"""

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tepsipe.errors import InputError, listed
from tepsipe.io.file_format import Channel as ListedChannel
from tepsipe.io.file_format import Contents, Format, Head
from tepsipe.io.readers.clock import BLOCKS, Clock, bridged, line_through, regular_clock, rounded_rate
from tepsipe.io.readers.plain_table import read_plain_table
from tepsipe.io.readers.recording import Channel, ForcePlate, Markers, Recording

HEADER = re.compile(
    r"(TimeStamp|Time)\t(.*\t)?("
    r"FrameNumber|[^\t]+\.Pos[XYZ]|FP\d+\.(For|Mom|Cop)[XYZ]|[^\t]*(speed|velocity)[^\t]*)(\t|\r|\n|$)",
    re.IGNORECASE,
)
# voltages and calibrated signals of manipulators also come from D-Flow, but as plain tables
MANIPULATOR = re.compile(r"MotorAngle|TriggerTime")
TIMES = ("TimeStamp", "Time")
FRAME = "FrameNumber"
MARKER = re.compile(r"(.+)\.Pos([XYZ])")
PLATE = re.compile(r"FP(\d+)\.(For|Mom|Cop)([XYZ])")
ANALOG = re.compile(r"Channel\d+\.Anlg")
SPEED = re.compile(r"speed|velocity", re.IGNORECASE)
# a marker with exactly the same position for this number of frames was hidden
HELD_FRAMES = 3
AXES = "XYZ"
# longest time without frames (s): what is shorter is a gap of the markers
LONGEST_GAP_S = 0.5


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


def read_dflow_recording(path: str | Path) -> Recording:
    """Read a file of D-Flow's mocap module; see `dflow_recording`.

    path: the file, plain or compressed with gzip.
    Returns: markers, force plates and channels in the axes of D-Flow.
    """
    return dflow_recording(read_dflow(path))


def dflow_recording(mocap: DFlowTable) -> Recording:
    """One recording of D-Flow's mocap file.

    Repeated frames are dropped. Where frames were dropped, markers are NaN, and forces and channels are
    bridged by straight lines.

    mocap: markers, force plates and channels.
    Returns: in the axes of D-Flow: x to the right, y up, z backward. Forces act on what stands on the
    plates, and moments are about the origin of these axes.
    """
    if not mocap.is_mocap:
        raise InputError(
            f"{mocap.name}: expected markers (.PosX) or force plates (FP1.ForX), found "
            f"{listed(mocap.columns)}: name the file of D-Flow's mocap module"
        )
    clock = frame_clock(mocap)
    positions = {label: clock.placed(x) for label, x in marker_columns(mocap).items()}
    markers = None
    if positions:
        markers = Markers(clock.rate_hz, tuple(positions), np.stack(list(positions.values()), axis=1))
    plates = tuple(
        ForcePlate(*(bridged(clock.placed(x), clock.rate_hz) for x in loads), clock.rate_hz)
        for loads in plate_columns(mocap).values()
    )
    channels = {
        name: Channel(bridged(clock.placed(x), clock.rate_hz), unit_of(name), clock.rate_hz)
        for name, x in mocap.columns.items()
        if not MARKER.fullmatch(name) and np.isfinite(x).any()
    }
    return Recording(mocap.name, markers, plates, channels, up="+y")


def frame_clock(mocap: DFlowTable) -> Clock:
    """Regular clock of a mocap file (Hz, s): its frame counter or, without one, its stamps."""
    if mocap.frames is None:
        return regular_clock(mocap.time, mocap.name, LONGEST_GAP_S)
    rows = np.flatnonzero(np.diff(mocap.frames, prepend=mocap.frames[0] - 1) != 0)
    index = mocap.frames[rows] - mocap.frames[0]
    stamps = mocap.time[rows]
    if rows.size < BLOCKS or not np.isfinite(stamps).all():
        raise InputError(
            f"{mocap.name}: expected at least {BLOCKS} frames with time stamps, found {rows.size} frames: "
            "record again, or repair the stamps"
        )
    period, first = line_through(index, stamps)
    if not 1e-4 < period < 1.0:
        raise InputError(
            f"{mocap.name}: expected frames at 1 to 10000 Hz, found {period:.3g} s between frames: check "
            "that the time stamps are in seconds"
        )
    steps = np.diff(index)
    longest = float(steps.max() - 1) * period
    if longest > LONGEST_GAP_S:
        k = int(np.argmax(steps))
        raise InputError(
            f"{mocap.name}: expected no more than {LONGEST_GAP_S:g} s without frames, found {longest:.3g} s "
            f"from line {mocap.lines[rows[k]]} on: cut the trial there"
        )
    return Clock(rounded_rate(1.0 / period), rows, index, first, period)


def dflow_contents(path: Path) -> Contents:
    """Contents of a file of D-Flow's mocap or record module (units by the names of its columns)."""
    table = read_dflow(path)
    steps = np.diff(table.time)
    rate = 1.0 / np.median(steps[steps > 0.0]) if (steps > 0.0).any() else None
    facts = {"duration": f"{np.ptp(table.time):.6g} s on D-Flow's clock"}
    if table.frames is not None and table.frames.size:
        jumps = np.diff(table.frames)
        facts["frames"] = (
            f"{table.frames[0]} to {table.frames[-1]}, {int((jumps == 0).sum())} repeated, "
            f"{int((jumps - 1)[jumps > 1].sum())} dropped"
        )
    markers = marker_columns(table)
    plates = plate_columns(table)
    if plates:
        facts["force plates"] = ", ".join(plates)
    if table.speeds:
        facts["belt speeds"] = ", ".join(table.speeds)
    channels = [ListedChannel.of(label, "m", rate, position) for label, position in markers.items()]
    for name, values in table.columns.items():
        marker = MARKER.fullmatch(name)
        if marker is None or marker[1] not in markers:
            channels.append(ListedChannel.of(name, unit_of(name), rate, values))
    kind = "mocap" if table.is_mocap else "record"
    loads = tuple(ListedChannel.of(name, "N", rate, force[:, 1]) for name, (force, _) in plates.items())
    return Contents(f"D-Flow text, {kind} module", facts, channels, tuple(markers), loads, vertical=1)


def _fits(head: Head) -> bool:
    return bool(HEADER.match(head.first_line)) and not MANIPULATOR.search(head.first_line)


FORMAT = Format(
    name="D-Flow",
    fits=_fits,
    contents=dflow_contents,
    endings=(".txt", ".csv", ".tsv"),
    text=True,
    purpose=lambda contents: ("whole trial" if "mocap" in contents.kind else "record", ""),
    lacks=("record",),
    page="dflow.md",
    read_recording=read_dflow_recording,
)
