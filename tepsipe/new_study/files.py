"""Kind of each file of a folder, by its content."""

import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tepsipe.errors import InputError, printable
from tepsipe.io.file_format import Channel, Contents, Format
from tepsipe.io.formats import format_of
from tepsipe.io.names import special_in
from tepsipe.io.readers.signal_table import marker_columns

MOST_FILES = 2000
FEWEST_SAMPLES = 20
# role of a column -> how its name looks; the first role that fits is taken
COLUMNS = {
    "trigger": r"trig",
    "time": r"time|zeit|stamp|^t$|^t[ _(\[]",
    "velocity": r"veloc|speed|geschw",
    "angle": r"angle|theta|winkel|pos|\brad\b|\bdeg\b",
    "torque": r"torque|moment|drehmoment|\btau\b|\bnm\b",
    "force": r"force|load|kraft|^f[xyz]",
}
# columns of what was imposed or wanted, not measured at the joint: taken for a role only if no other fits
IMPOSED = r"platform|surface|sway|command|cmd|set ?point|target|desired|soll"
# the same for a person on a moving platform, whose columns name a joint each
JOINTS = {"ankle": r"ankle|sprung", "hip": r"hip|trunk|h(ü|ue|u)ft"}
PLATFORM = r"platform|sway|surface|perturb"
LOAD = re.compile(r"(^|[ _.:-]|FP\d?|GRF)[FM][xyz]\d?(?![a-z])", re.IGNORECASE)  # of a force plate
VOLTS = ("V", "mV", "uV", "µV")  # units of electromyograms
# kind of event in walking -> how the name of its column looks
EVENTS = {
    "heel_strike": r"heel|strike|initial.?contact|^[lr]?(hs|ic)$",
    "toe_off": r"toe|off|^[lr]?to$",
    "pulse": r"pulse|perturb|onset|stim",
}
MOST_EVENTS = 12  # columns of a table of events
# kinds that are the first file of a trial; markers, emg, command, calibration, record, events belong to one
FIRST = ("whole trial", "treadmill log", "manipulator log", "position table", "belt table", "platform table")


@dataclass(frozen=True)
class Found:
    """One file of the folder."""

    path: Path
    name: str
    """Its path from the folder, with slashes."""
    kind: str
    """One of `FIRST`, the kind of a file that belongs to one, or ``other``."""
    contents: Contents | None
    """Its channels (units of the file); None if it cannot be read."""
    duration_s: float | None
    """Length of its longest channel (s), if it gives a rate."""
    columns: dict[str, str]
    """Role of a table's column -> its name."""
    why: str = ""
    """For ``other``: why it is not used."""
    format: Format | None = None
    """Its format; None if it cannot be read."""

    def channel(self, name: str) -> Channel:
        """The channel of that name."""
        return next(c for c in self.contents.channels if c.name == name)


def look_at(folder: Path, left_out: Path | None = None, tell: Callable[[str], object] = str) -> list[Found]:
    """Look into every file of a folder and of those below it.

    left_out: A folder below it that is not looked at.
    tell: takes how far it is.
    Returns: in the order of their names (s, units of the files).
    """
    if not folder.is_dir():
        raise InputError(f"{folder}: expected a folder of recordings, found none: correct its path")
    paths = [
        path
        for path in sorted(folder.rglob("*"))
        if path.is_file()
        and not any(part.startswith(".") for part in path.relative_to(folder).parts)
        and (left_out is None or left_out not in path.parents)
    ]
    if not 0 < len(paths) <= MOST_FILES:
        raise InputError(
            f"{folder}: expected 1 to {MOST_FILES} files of recordings, found {len(paths)}: name the folder "
            "that holds the recordings of one study"
        )
    found = []
    for number, path in enumerate(paths, start=1):
        tell(f", file {number} of {len(paths)}")
        found.append(_found(path, path.relative_to(folder).as_posix()))
    return found


def _found(path: Path, name: str) -> Found:
    if not name.isprintable():
        why = "its name holds a line break or another character that is none: rename it"
        return Found(path, printable(name), "other", None, None, {}, why)
    special = special_in(name) or [c for c in name[:1] if c in "-~$"]
    if special:
        why = f"the run refuses {' '.join(map(repr, special))} in its name: rename it"
        return Found(path, name, "other", None, None, {}, why)
    try:
        known = format_of(path)
        contents = known.contents(path)
    except InputError as error:
        return Found(path, name, "other", None, None, {}, str(error).removeprefix(f"{path}: "))
    columns = columns_by_role([c.name for c in contents.channels]) if known.purpose == "table" else {}
    on_platform = platform_columns([c.name for c in contents.channels]) if columns else {}
    if on_platform:
        return Found(path, name, "platform table", contents, _duration(contents), on_platform, format=known)
    kind, why = _kind(known, contents, columns)
    return Found(path, name, kind, contents, _duration(contents), columns, why, known)


def columns_by_role(names: list[str]) -> dict[str, str]:
    """Role of a column, for example time -> its name in the header; the first that fits best."""
    return {role: fitting[0] for role, fitting in candidates_by_role(names).items()}


def candidates_by_role(names: list[str]) -> dict[str, list[str]]:
    """Role of a column -> the names in the header that fit it, those of imposed signals last."""
    by_role: dict[str, list[str]] = {}
    for name in sorted(names, key=lambda n: bool(re.search(IMPOSED, n.replace("_", " "), re.IGNORECASE))):
        spaced = name.replace("_", " ")
        role = next((r for r, pattern in COLUMNS.items() if re.search(pattern, spaced, re.IGNORECASE)), None)
        if role is not None:
            by_role.setdefault(role, []).append(name)
    return by_role


def platform_columns(names: list[str]) -> dict[str, str]:
    """Role of each column of a person on a moving platform -> its name in the header.

    Empty unless time, platform, and angle and torque of ankle and hip are all there.
    """
    by_role = {role: name for role, name in columns_by_role(names).items() if role == "time"}
    for name in names:
        joint = next((j for j, pattern in JOINTS.items() if re.search(pattern, name, re.IGNORECASE)), None)
        # torque first: the name of a torque may also speak of an angle
        what = next((r for r in ("torque", "angle") if re.search(COLUMNS[r], name, re.IGNORECASE)), None)
        if joint and what:
            by_role.setdefault(f"{joint}_{what}", name)
        elif not joint and re.search(PLATFORM, name, re.IGNORECASE):
            by_role.setdefault("platform", name)
    return by_role if len(by_role) == 2 + 2 * len(JOINTS) else {}


def _duration(contents: Contents) -> float | None:
    """Length of the longest channel with a rate (s)."""
    lengths = [c.shape[0] / c.rate_hz for c in contents.channels if c.rate_hz and c.shape]
    return max(lengths, default=None)


def _kind(known: Format, contents: Contents, columns: dict[str, str]) -> tuple[str, str]:
    """Kind of a file, and for ``other`` why it is not used."""
    longest = max((c.shape[0] for c in contents.channels if c.shape), default=0)
    if not contents.channels and contents.facts.get("columns of text") and not _is_calibration(contents):
        return "other", f"no column holds numbers only: {contents.facts['columns of text']}"
    if longest < FEWEST_SAMPLES and not _is_calibration(contents):
        return "other", f"a recording has at least {FEWEST_SAMPLES} samples, this has {longest}"
    kind, why = known.purpose_of(contents)
    return _kind_of_table(contents, columns) if kind == "table" else (kind, why)


def events_of(names: list[str]) -> dict[str, str]:
    """Kind of event -> name of its column in a table of events, or its label; empty if there is no gait.

    Of names of both feet those of the left one are taken.
    """
    by_kind = {}
    for kind, pattern in EVENTS.items():
        fitting = [name for name in names if re.search(pattern, name.strip(), re.IGNORECASE)]
        fitting.sort(key=lambda name: not re.match("l(eft)?", name, re.IGNORECASE))
        if fitting:
            by_kind[kind] = fitting[0]
    return by_kind if {"heel_strike", "toe_off"} <= by_kind.keys() else {}


def _is_calibration(contents: Contents) -> bool:
    """Test for the calibration matrix of a treadmill, by the header of a table."""
    return contents.facts.get("columns of text", "").replace(" ", "") == "component,unit"


def _kind_of_table(contents: Contents, columns: dict[str, str]) -> tuple[str, str]:
    if _is_calibration(contents):
        return "calibration", ""
    if (
        len(contents.channels) <= MOST_EVENTS
        and "time" not in columns
        and events_of([c.name for c in contents.channels])
    ):
        return "events", ""
    loads = {c.name for c in contents.channels if LOAD.search(c.name)}
    if len(loads) >= 6 and "time" in columns:
        return "whole trial", ""
    others = [c for c in contents.channels if c.name != columns.get("time")]
    of_markers = len(marker_columns(c.name for c in others)) * len("xyz")
    if "time" in columns and of_markers > 0.5 * len(others):
        return "markers", ""
    if "time" in columns and others and all(c.unit in VOLTS for c in others):
        return "emg", ""
    has = set(columns)
    if {"time", "angle", "trigger"} <= has:
        return "manipulator log", ""
    if {"time", "angle", "torque"} <= has:
        return "position table", ""
    if {"time", "velocity"} <= has and has & {"torque", "force"}:
        return "belt table", ""
    if {"time", "torque"} <= has and not has & {"angle", "velocity"}:
        return "command", ""
    return "other", "its columns are those of no instrument that is known here"


def samples(channel: Channel) -> np.ndarray:
    """Samples of a channel with one value per instant, shape (n,)."""
    return np.asarray(channel.values, dtype=float).reshape(channel.shape[0], -1)[:, 0]
