"""Loads and belt velocity of a recorded file, and copies of it from whose loads something is subtracted.

Files with whole force plates (C3D, D-Flow's mocap module, tables with Fx to Mz) have six loads per plate,
named ``plate 1 Fx`` to ``plate 1 Mz``, in the axes of the file; moments are about their origin. Any other
table has the loads that are named, one column each.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

import numpy as np
import scipy

from tepsipe.errors import InputError, listed, quoted
from tepsipe.experiments.belt.analysis import belt_recording
from tepsipe.ingest.belt_table import BeltTableOptions, ingest_belt_table
from tepsipe.ingest.dflow import aligned_record
from tepsipe.ingest.whole_trial import M_PER_S, MAX_GAP_S, velocity_of_position
from tepsipe.io.corrected_copy import write_c3d_copy, write_text_copy
from tepsipe.io.formats import format_of
from tepsipe.io.readers import c3d, dflow
from tepsipe.io.readers.any_table import table_columns
from tepsipe.io.readers.clock import Clock
from tepsipe.io.readers.force_plates import LEAST_LOAD_N, channels_without
from tepsipe.io.readers.plain_table import read_plain_table
from tepsipe.io.readers.recording import ForcePlate, Recording, select_markers
from tepsipe.io.readers.signal_table import (
    COMPONENTS,
    load_columns,
    load_factor,
    read_table_recording,
    split_unit,
    table_clock,
)
from tepsipe.io.readers.text_table import read_text_table
from tepsipe.signals.resampling import BAND_PER_RATE, fill_gaps, resample
from tepsipe.treadmill.recording import BeltRecording

# rate of the models of force plates over the cutoff, and the least one (Hz)
RATE_PER_CUTOFF, LEAST_RATE_HZ = 16.0, 100.0
TRIMMED_S = 1.0
# slowest recording over the rate of the models
SLOWEST = 0.1
UNITS = ("N",) * 3 + ("Nm",) * 3


@dataclass(frozen=True)
class BeltVelocity:
    """Source of the belt velocity of a recording."""

    name: str | None = None
    """Column or analog channel, or ``FILE`` or ``FILE:COLUMN`` of a text table with the time (s) on the
    clock of the recording; a file of D-Flow's record module is aligned with its mocap file."""
    markers: tuple[str, ...] = ()
    """Belt-fixed markers; their velocity is positive in the positive direction of the axis on which they
    move."""
    scale: float | None = None
    """Belt velocity per unit of the column (m/s); None to take it from the column's unit."""
    offset: float = 0.0
    """Value of the column while the belt stands still, in its unit."""

    def file(self) -> tuple[Path, str | None] | None:
        """Path and column of a file that is named."""
        if self.name is None:
            return None
        path, _, column = self.name.rpartition(":")
        for found, column_name in ((self.name, None), (path, column)):
            if found and Path(found).is_file():
                return Path(found), column_name
        return None


@dataclass(frozen=True)
class BeltChannels:
    """What is read of a recording: its loads, and the velocity of its belt."""

    velocity: BeltVelocity
    loads: Sequence[str] = ()
    """Columns of a table; of files with force plates, names of those that are wanted, by default all."""
    time: str | None = None
    """Column of the time of a table; by default the first of three."""
    load_unit: str = "Nm"
    """Unit of the loads of a table, N or Nm; of several, the one that ends the column's name."""


@dataclass(frozen=True)
class BeltLoad:
    """One load of a recording, and the velocity of the belt at the same instants."""

    values: Annotated[np.ndarray, "(n,)"]
    unit: str
    """N or Nm."""
    velocity: Annotated[np.ndarray, "(n,)", "m/s"]
    rate_hz: float


# corrections by load, shape (n,), and lines of a note -> what was written: step of each channel
Writer = Callable[[Path, Mapping[str, np.ndarray], Mapping[str, Sequence[str]]], dict[str, float]]


@dataclass(frozen=True)
class BeltFile:
    """Loads of a recorded file."""

    path: Path
    loads: dict[str, BeltLoad]
    plates: tuple[ForcePlate, ...]
    """Force plates of the file; empty for a table of single loads."""
    up: str
    """Upward direction in the axes of the plates."""
    write: Writer
    """Write a copy from whose loads corrections are subtracted."""

    @property
    def changing(self) -> list[str]:
        """Names of the loads that are not constant."""
        return [name for name, load in self.loads.items() if np.ptp(load.values) > 0.0]

    def rate_hz(self, name: str, cutoff_hz: float) -> float:
        """Rate that suits models of a load below a cutoff (Hz); that of a table of single loads is kept."""
        rate_hz = self.loads[name].rate_hz
        if not self.plates:
            return rate_hz
        return rate_hz / max(1, int(rate_hz / max(LEAST_RATE_HZ, RATE_PER_CUTOFF * cutoff_hz)))

    def beyond(self, name: str, rate_hz: float) -> float:
        """RMS of the part of a load that its recording at a lower rate (Hz) does not hold (N, N·m)."""
        load = self.loads[name]
        if rate_hz > (1.0 - 1e-6) * load.rate_hz:
            return 0.0
        time = np.arange(load.values.size) / load.rate_hz
        return float(
            np.std(load.values - resample(time, load.values, time, BAND_PER_RATE * rate_hz, load.rate_hz))
        )

    def recording(self, name: str, rate_hz: float) -> BeltRecording:
        """Recording of a load (N or N·m, m/s) at a rate, for calibration and removal; not filtered."""
        load = self.loads[name]
        time = np.arange(load.values.size) / load.rate_hz
        values, velocity = load.values, load.velocity
        if self.plates:  # the zero of transducers is not induced by the belt
            values = values - values.mean()
        if load.rate_hz < SLOWEST * rate_hz:
            raise InputError(
                f"{self.path}, {name}: expected at least {SLOWEST * rate_hz:g} Hz, a tenth of the rate of "
                f"the models, found {load.rate_hz:.3g} Hz: check the time of its samples"
            )
        if abs(rate_hz - load.rate_hz) > 1e-6 * rate_hz:
            grid = np.arange(int(time[-1] * rate_hz + 1e-6) + 1) / rate_hz
            band = BAND_PER_RATE * rate_hz if rate_hz < load.rate_hz else None
            values, velocity = (resample(time, x, grid, band, load.rate_hz) for x in (values, velocity))
        grid, file = np.arange(values.size) / rate_hz, self.path.name
        try:
            return belt_recording(grid, values, velocity, unit=load.unit, name=file, trimmed_s=TRIMMED_S)
        except InputError as error:
            raise InputError(f"{self.path}, {name}: {str(error).removeprefix(f'{file}: ')}") from error


def read_belt_file(path: Path, chosen: BeltChannels, shortest_s: float = 2.0 * TRIMMED_S) -> BeltFile:
    """Read the loads of a recording and the velocity of its belt.

    path: C3D, D-Flow text or text table.
    shortest_s: shortest table that is used.
    Returns: loads in N and N·m.
    """
    kind = format_of(path)
    if kind is c3d.FORMAT:
        return _chosen(_of_c3d(path, chosen.velocity), chosen.loads)
    if kind is dflow.FORMAT:
        return _chosen(_of_dflow(path, chosen.velocity), chosen.loads)
    names, delimiter = table_columns(path)
    if len(names) != 3 and chosen.time is None and load_columns(names, str(path)):
        return _chosen(_of_plate_table(path, chosen.velocity), chosen.loads)
    return _of_table(path, names, delimiter, chosen, shortest_s)


def _chosen(file: BeltFile, loads: Sequence[str]) -> BeltFile:
    """The file with some of its loads only, named in full or by their component."""
    kept = {
        name: load for name, load in file.loads.items() if not loads or {name, name.split()[-1]} & {*loads}
    }
    for wanted in loads:
        if not any(wanted in (name, name.split()[-1]) for name in file.loads):
            raise InputError(
                f"{file.path}: expected a load named {wanted!r}, found {listed(file.loads)}: name one of "
                f"these"
            )
    return replace(file, loads=kept)


def _loads(
    recording: Recording, velocity: Callable[[float, int], np.ndarray], path: Path
) -> dict[str, BeltLoad]:
    """Six loads of every usable plate."""
    found = {}
    for number, plate in enumerate(recording.plates, start=1):
        if plate.fault is not None:
            continue
        at = velocity(plate.rate_hz, plate.force.shape[0])
        for component, unit, values in zip(
            COMPONENTS, UNITS, np.hstack([plate.force, plate.moment]).T, strict=True
        ):
            whole = np.isfinite(values)
            if not whole.any():
                raise InputError(
                    f"{path}, force plate {number}: expected a number in every sample, found none: export "
                    "the file again"
                )
            every = np.arange(values.size)
            values = values if whole.all() else np.interp(every, every[whole], values[whole])
            found[f"plate {number} {component}"] = BeltLoad(values, unit, at, plate.rate_hz)
    if not found:
        raise InputError(
            f"{path}: expected a force plate with forces and moments, found "
            f"{quoted(recording.plates[0].fault, 200) if recording.plates else 'none'}: export its loads"
        )
    return found


def _velocity_of(recording: Recording, source: BeltVelocity) -> Callable[[float, int], np.ndarray]:
    """Function of a rate (Hz) and a number of samples that returns the belt velocity (m/s)."""
    name, file = recording.name, source.file()
    if source.name is not None and source.name in recording.channels:
        channel = recording.channels[source.name]
        values, unit = channel.values, channel.unit.strip()
        instants = np.arange(values.size) / channel.rate_hz
    elif file is not None:
        instants, values, unit = _velocity_table(*file)
    elif source.name is not None:
        raise InputError(
            f"{name}: expected a channel or a file {source.name!r} with the belt velocity, found channels "
            f"{listed(recording.channels)}: name one of them, or a text table"
        )
    elif source.markers:
        instants, values = _velocity_of_markers(recording, source.markers)
        unit = "m/s"
    else:
        raise InputError(
            f"{name}: expected a source of the belt velocity, found none named, among "
            f"{listed(recording.channels)}: name a channel or a file (velocity), or belt-fixed markers "
            "(belt_markers)"
        )
    values = _scaled(values, unit, source, f"{name}: {source.name or 'markers'}")
    spline = scipy.interpolate.CubicSpline(instants, values)

    def at(rate_hz: float, count: int) -> np.ndarray:
        wanted = np.arange(count) / rate_hz
        step = float(np.median(np.diff(instants)))
        if wanted[-1] > instants[-1] + 2.0 * step or instants[0] > 2.0 * step:
            raise InputError(
                f"{name}: expected the belt velocity from 0 to {wanted[-1]:.3f} s, found it from "
                f"{instants[0]:.3f} to {instants[-1]:.3f} s: name the file of this recording, on its clock"
            )
        return spline(np.clip(wanted, instants[0], instants[-1]))

    return at


def _scaled(values: np.ndarray, unit: str, source: BeltVelocity, place: str) -> np.ndarray:
    """Velocity (m/s) from the values of a column or channel."""
    scale = source.scale if source.scale is not None else M_PER_S.get(unit or "m/s")
    if scale is None:
        raise InputError(
            f"{place}: expected a belt velocity in {', '.join(M_PER_S)}, found the unit {quoted(unit)}: give "
            "the velocity per unit (velocity_scale), and the value at rest (velocity_offset)"
        )
    bad = int(np.count_nonzero(~np.isfinite(values)))
    if bad:
        raise InputError(
            f"{place}: expected a belt velocity in every sample, found none in {bad}: export it again"
        )
    return scale * (values - source.offset)


def _velocity_table(path: Path, column: str | None) -> tuple[np.ndarray, np.ndarray, str]:
    """Instants (s), velocity and its unit in a text table; its clock is the recording's."""
    recording = read_table_recording(path)
    table = read_plain_table(path, "a table of the belt velocity")
    clock, _ = table_clock(table)
    names = [name for name in recording.channels if column in (None, name)]
    if len(names) != 1:
        raise InputError(
            f"{path}: expected one column of the belt velocity, found {listed(recording.channels)}: name it "
            f"after the file, as {path.name}:COLUMN"
        )
    channel = recording.channels[names[0]]
    instants = clock.first_s + np.arange(channel.values.size) / channel.rate_hz
    return instants, channel.values, channel.unit.strip()


def _velocity_of_markers(recording: Recording, labels: tuple[str, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Instants (s) and velocity (m/s) of the mean of belt-fixed markers along the axis they move on."""
    if recording.markers is None:
        raise InputError(
            f"{recording.name}: expected belt-fixed markers {listed(labels)}, found no markers: name a "
            "channel or a file with the belt velocity"
        )
    markers = select_markers(recording.markers, list(labels), recording.name)
    mean, _ = fill_gaps(
        markers.positions.mean(axis=1), markers.rate_hz, MAX_GAP_S, f"{recording.name}, belt-fixed markers"
    )
    mean[:, "xyz".index(recording.up[1])] = 0.0
    along = mean[:, int(np.argmax(np.ptp(mean, axis=0)))]
    instants = np.arange(along.size) / markers.rate_hz
    return instants, velocity_of_position(instants, along, markers.rate_hz)[0]


def _of_c3d(path: Path, velocity: BeltVelocity) -> BeltFile:
    recording = c3d.read_c3d_recording(path)
    loads = _loads(recording, _velocity_of(recording, velocity), path)

    def write(output, corrections, note) -> dict[str, float]:
        file = c3d.open_c3d(path)
        labels, scale, changed = list(recording.channels), c3d.metres_per_unit(file, path), {}
        for number, removed in _by_plate(corrections, len(recording.plates)).items():
            plate = recording.plates[number]
            channels = [recording.channels[label] for label in plate.channels]
            what = f"{path}, force plate {number + 1}"
            new = channels_without(file, number, plate, channels, removed, scale, what)
            changed |= {labels.index(label): x for label, x in zip(plate.channels, new, strict=True)}
        steps = write_c3d_copy(path, output, changed, GROUP, note)
        return {labels[k]: step for k, step in steps.items() if step}

    return BeltFile(path, loads, recording.plates, recording.up, write)


# parameter group of a C3D file with the note of a compensation
GROUP = "TEPSIPE_COMPENSATION"


def _by_plate(corrections: Mapping[str, np.ndarray], count: int) -> dict[int, np.ndarray]:
    """Number of the plate, from 0 -> correction of its six loads, shape (n, 6)."""
    size = next(iter(corrections.values())).size
    found = {}
    for number in range(count):
        names = [f"plate {number + 1} {component}" for component in COMPONENTS]
        if any(name in corrections for name in names):
            found[number] = np.column_stack([corrections.get(name, np.zeros(size)) for name in names])
    return found


def _rows(clock: Clock, count: int) -> np.ndarray:
    """Place on the clock of every row of a file; a row that repeats a sample has its place."""
    return clock.index[np.maximum(0, np.searchsorted(clock.rows, np.arange(count), side="right") - 1)]


def _of_dflow(path: Path, velocity: BeltVelocity) -> BeltFile:
    table = dflow.read_dflow(path)
    recording, source, file = dflow.dflow_recording(table), velocity, velocity.file()
    if file is not None and velocity.name not in recording.channels and format_of(file[0]) is dflow.FORMAT:
        record = dflow.read_dflow(file[0])
        speeds = [file[1]] if file[1] else list(record.speeds)
        if len(speeds) != 1 or speeds[0] not in record.columns:
            raise InputError(
                f"{file[0]}: expected one belt speed, found {listed(record.speeds)}: name it after the file, "
                f"as {file[0].name}:COLUMN"
            )
        whole, first, stop = aligned_record(table, record, velocity.markers)
        speed = whole.channels[speeds[0]]
        values = np.interp(np.arange(speed.values.size), np.arange(first, stop), speed.values[first:stop])
        channels = recording.channels | {speeds[0]: replace(speed, values=values)}
        recording, source = replace(recording, channels=channels), replace(velocity, name=speeds[0])
    loads = _loads(recording, _velocity_of(recording, source), path)
    plain = read_plain_table(path, "a text file of D-Flow")
    rows = _rows(dflow.frame_clock(table), len(table.lines))

    def write(output, corrections, note) -> dict[str, float]:
        numbers = list(dflow.plate_columns(table))
        changed = {}
        for number, removed in _by_plate(corrections, len(numbers)).items():
            names = [f"{numbers[number]}.{kind}{axis}" for kind in ("For", "Mom") for axis in "XYZ"]
            six = np.column_stack([table.columns[name] for name in names])
            new = six - removed[rows]
            changed |= {plain.names.index(name): x for name, x in zip(names, new.T, strict=True)}
            loaded = np.minimum(np.abs(six[:, 1]), np.abs(new[:, 1])) > LEAST_LOAD_N
            up = np.where(loaded, new[:, 1], np.nan)
            for axis, x in (("X", new[:, 5] / up), ("Z", -new[:, 3] / up)):
                name = f"{numbers[number]}.Cop{axis}"
                if name in plain.names:  # NaN leaves the field as it is
                    changed[plain.names.index(name)] = x
        write_text_copy(path, output, plain.delimiter, table.lines, changed, _lines(note))
        return {}

    return BeltFile(path, loads, recording.plates, recording.up, write)


def _of_plate_table(path: Path, velocity: BeltVelocity) -> BeltFile:
    recording = read_table_recording(path)
    loads = _loads(recording, _velocity_of(recording, velocity), path)
    plain = read_plain_table(path, "a table of a trial")
    rows = _rows(table_clock(plain)[0], len(plain.lines))

    def write(output, corrections, note) -> dict[str, float]:
        changed = {}
        for number, columns in enumerate(load_columns(plain.names, str(path)), start=1):
            for component, column in columns.items():
                if (removed := corrections.get(f"plate {number} {component}")) is not None:
                    place = plain.names.index(column)
                    part = removed[rows] / load_factor(component, column, str(path))
                    changed[place] = plain.values[:, place] - part
        write_text_copy(path, output, plain.delimiter, plain.lines, changed, _lines(note))
        return {}

    return BeltFile(path, loads, recording.plates, recording.up, write)


def _of_table(
    path: Path, names: list[str], delimiter: str, chosen: BeltChannels, shortest_s: float
) -> BeltFile:
    """Single loads of a text table, on the clock behind its time stamps."""
    velocity = chosen.velocity
    if len(names) != 3 and not (chosen.time and chosen.loads and velocity.name):
        raise InputError(
            f"{path}: expected three columns, time, load and belt velocity, found {listed(names)}: name them "
            "with --time, --load and --velocity"
        )
    time = chosen.time or names[0]
    loads = tuple(chosen.loads) or (names[1],)
    keys = {load: "load" if len(loads) == 1 else f"load {k + 1}" for k, load in enumerate(loads)}
    columns = {"time": time} | {key: load for load, key in keys.items()}
    file = velocity.file() if velocity.name not in names else None
    if file is None:
        columns["velocity"] = velocity.name or names[2]
    table = read_text_table(path, columns, delimiter, {key: f"--{key.split()[0]}" for key in columns})
    if file is None:
        speed = _scaled_column(table["velocity"], velocity)
    else:
        instants, values, unit = _velocity_table(*file)
        speed = np.interp(table["time"], instants, _scaled(values, unit, velocity, str(file[0])))
        columns["velocity"] = file[0].name
    found, rows = {}, {}
    for load, key in keys.items():
        part = {"time": table["time"], "load": table[key], "velocity": speed}
        named = {"time": time, "load": load, "velocity": "" if velocity.scale else columns["velocity"]}
        own = split_unit(load)[1]
        unit = own if len(loads) > 1 and own in UNITS else chosen.load_unit
        options = BeltTableOptions(load_unit=unit, max_gap_s=0.1, shortest_s=shortest_s)
        trial = ingest_belt_table(part, named, options, 0.0, str(path))
        found[load] = BeltLoad(trial.values("load"), unit, trial.values("belt_velocity"), trial.rate_hz)
        first = int(np.flatnonzero(np.isfinite(part["load"]) & np.isfinite(speed))[0])
        if trial.attributes["clock"] == "samples kept":
            rows[load] = np.arange(table["time"].size, dtype=float) - first
        else:
            rows[load] = (table["time"] - table["time"][first]) * trial.rate_hz
    plain = read_plain_table(path, "a table of samples")

    def write(output, corrections, note) -> dict[str, float]:
        changed = {}
        for load, removed in corrections.items():
            at = np.interp(rows[load], np.arange(removed.size), removed, left=np.nan, right=np.nan)
            changed[names.index(load)] = table[keys[load]] - at
        write_text_copy(path, output, delimiter, plain.lines, changed, _lines(note))
        return {}

    return BeltFile(path, found, (), "", write)


def _scaled_column(values: np.ndarray, source: BeltVelocity) -> np.ndarray:
    return (1.0 if source.scale is None else source.scale) * (values - source.offset)


def _lines(note: Mapping[str, Sequence[str]]) -> list[str]:
    """A note as lines of text; the first names the group, by which a second compensation is refused."""
    return [GROUP, *(f"{key}: {line}" for key, lines in note.items() for line in lines)]
