"""A whole trial as a text table: time, belt velocity, forces and moments, markers, electromyograms.

Columns are known by their names. Markers have three columns, ``<label>_x``, ``<label>.y``, ``<label>:Z`` or
``<label>.PosX``; a force plate has six, ``Fx`` to ``Fz`` and ``Mx`` to ``Mz`` with the same beginning or
ending, for example ``Fx_left`` or ``FP1_Mz``; every other column is a channel. A unit stands at the end of a
name, in brackets or after an underscore, ``Fx_left (kN)`` or ``HEEL_x_mm``; without one, it is SI.
"""

import re
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from tepsipe.errors import InputError, listed
from tepsipe.io.readers.clock import Clock, bridged, regular_clock
from tepsipe.io.readers.plain_table import PlainTable, read_plain_table
from tepsipe.io.readers.recording import METRES_PER_UNIT, Channel, ForcePlate, Markers, Recording

TIME = re.compile(r"(time|t|timestamp|zeit)$", re.IGNORECASE)
UNIT = re.compile(r"\s*[(\[]\s*([^()\[\]]+?)\s*[)\]]\s*$")
ENDING = re.compile(r"_(s|ms|us|mm|cm|m|N|kN|Nm|Nmm|V|mV|uV|rad|deg|m_per_s|mm_per_s)$")
MARKER = re.compile(r"(.+?)[\s_.:]?(?:Pos)?([XYZ])$|(.+?)[_.:]([xyz])$")
LOAD = re.compile(r"(?:(.+?)[\s_.:])?([FM])([xyz])(?:[\s_.:]?(.+))?$", re.IGNORECASE)
SECONDS = {"": 1.0, "s": 1.0, "sec": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6}
FORCES = {"": 1.0, "N": 1.0, "kN": 1e3}
MOMENTS = {"": 1.0, "Nm": 1.0, "N·m": 1.0, "N.m": 1.0, "N*m": 1.0, "Nmm": 1e-3, "N·mm": 1e-3, "N.mm": 1e-3}
SIDES = ("left", "l", "1", "right", "r", "2")
# other signals with three components, which are not markers
OTHER = re.compile(r"grf|force|moment|torque|cop|acc|gyro|angle|rot|veloc|speed", re.IGNORECASE)
AXES = "xyz"
COMPONENTS = tuple(f"{kind}{axis}" for kind in "FM" for axis in AXES)


def split_unit(name: str) -> tuple[str, str]:
    """Name of a column without its unit, and the unit; empty if it names none."""
    bracketed = UNIT.search(name)
    if bracketed:
        return name[: bracketed.start()].strip(), bracketed[1]
    ending = ENDING.search(name)
    if ending:
        return name[: ending.start()], ending[1].replace("_per_", "/")
    return name, ""


def read_table_recording(path: str | Path) -> Recording:
    """Read a text table that holds a whole trial.

    path: text with a header line, separated by commas, semicolons or tabs, plain or compressed with gzip.
    Returns: markers, force plates and channels, in the axes of the file. Samples that are missing are NaN
    in the markers; elsewhere gaps of up to 0.05 s are bridged by straight lines. Plates named left come
    before right ones.
    """
    table = read_plain_table(path, "a table of a trial")
    clock, time = table_clock(table)
    columns = {}
    for k, name in enumerate(table.names):
        if name != time and name:
            if name in columns:
                raise InputError(
                    f"{path}: expected one column named {name!r}, found more: rename one in the header"
                )
            columns[name] = clock.placed(table.values[:, k])
    loads, plates = _plates(columns, clock.rate_hz, table.name)
    points, markers = _markers(
        {n: x for n, x in columns.items() if n not in loads}, clock.rate_hz, table.name
    )
    channels = {}
    for name, values in columns.items():
        if name not in points and np.isfinite(values).any():
            plain, unit = split_unit(name)
            label = plain if plain not in channels else name
            channels[label] = Channel(bridged(values, clock.rate_hz), unit, clock.rate_hz)
    return Recording(table.name, markers, plates, channels)


def table_clock(table: PlainTable) -> tuple[Clock, str]:
    """Clock of a table (Hz, s), and the name of the column of its time."""
    name = next((name for name in table.names if TIME.match(split_unit(name)[0])), None)
    if name is None:
        raise InputError(
            f"{table.name}: expected a column of the time, named 'time' or 't', found {listed(table.names)}: "
            "name it in the header, with its unit, for example 'time (s)'"
        )
    unit = split_unit(name)[1]
    if unit not in SECONDS:
        raise InputError(
            f"{table.name}: expected the time in s, ms or us, found the unit {unit!r} in {name!r}: convert "
            "the column"
        )
    return regular_clock(SECONDS[unit] * table.column(name), table.name), name


def _plates(columns: dict[str, np.ndarray], rate_hz: float, name: str) -> tuple[set[str], tuple]:
    """Columns of forces and moments, and the plates that they make."""
    used, plates = set(), []
    for group in load_columns(columns, name):
        scaled = [
            load_factor(c, column, name) * bridged(columns[column], rate_hz) for c, column in group.items()
        ]
        plates.append(ForcePlate(np.column_stack(scaled[:3]), np.column_stack(scaled[3:]), rate_hz))
        used |= set(group.values())
    return used, tuple(plates)


def load_columns(names: Iterable[str], name: str) -> list[dict[str, str]]:
    """Columns of each plate by component, Fx to Mz, of a table with these columns; the left plate first."""
    groups: dict[str, dict[str, str]] = {}
    for column in names:
        match = LOAD.match(split_unit(column)[0])
        if match:
            plate = " ".join(filter(None, (match[1], match[4])))
            groups.setdefault(plate, {})[match[2].upper() + match[3].lower()] = column
    plates = []
    for plate in sorted(groups, key=_side):
        missing = [c for c in COMPONENTS if c not in groups[plate]]
        if len(missing) > 3:
            continue  # not a plate: single columns that only look like it
        if missing:
            raise InputError(
                f"{name}: expected forces Fx, Fy, Fz and moments Mx, My, Mz of every plate, found no "
                f"{missing[0]} beside {listed(groups[plate].values())}: export all six"
            )
        plates.append({c: groups[plate][c] for c in COMPONENTS})
    return plates


def load_factor(component: str, column: str, name: str) -> float:
    """Factor from the unit of a column of a force or moment to N or N·m."""
    return _factor(column, FORCES if component[0] == "F" else MOMENTS, name)


def _side(plate: str) -> tuple[int, str]:
    """Order of the plates: left, right, then by name."""
    words = [word for word in re.split(r"[\s_.:]|(?<=\D)(?=\d)", plate.lower()) if word]
    return min((SIDES.index(word) for word in words if word in SIDES), default=len(SIDES)), plate


def marker_columns(names: Iterable[str]) -> dict[str, dict[str, str]]:
    """Label of a marker -> its columns by axis, of a table with these columns."""
    groups: dict[str, dict[str, str]] = {}
    for column in names:
        plain, unit = split_unit(column)
        match = MARKER.match(plain)
        if match and unit in ("", *METRES_PER_UNIT) and not OTHER.search(plain):
            label, axis = (match[1], match[2]) if match[2] else (match[3], match[4])
            groups.setdefault(label, {})[axis.lower()] = column
    return {label: axes for label, axes in groups.items() if len(axes) == len(AXES)}


def _markers(columns: dict[str, np.ndarray], rate_hz: float, name: str) -> tuple[set[str], Markers | None]:
    """Columns of positions, and the markers that they make (m)."""
    groups = marker_columns(columns)
    if not groups:
        return set(), None
    positions = np.stack(
        [
            np.column_stack(
                [_factor(axes[a], {"": 1.0, **METRES_PER_UNIT}, name) * columns[axes[a]] for a in AXES]
            )
            for axes in groups.values()
        ],
        axis=1,
    )
    used = {column for axes in groups.values() for column in axes.values()}
    return used, Markers(rate_hz, tuple(groups), positions)


def _factor(column: str, factors: dict[str, float], name: str) -> float:
    """Factor from the unit in a column's name to SI."""
    unit = split_unit(column)[1]
    if unit not in factors:
        raise InputError(
            f"{name}: expected {column!r} in {', '.join(filter(None, factors))}, found the unit {unit!r}: "
            "convert the column or correct its header"
        )
    return factors[unit]
