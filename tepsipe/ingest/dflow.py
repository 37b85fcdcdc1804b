"""From D-Flow's text files to one recording on the clock of the motion capture system.

D-Flow's time stamps say when D-Flow received a frame, not when it was taken: frames queue up and are
stamped together. The clock is therefore the frame counter, and stamps only give its rate and, coarsely, the
time between the two files. The record module's samples are placed by the frame counter if it was recorded
with them; otherwise by the stamps and then by a signal that both files hold.
"""

from dataclasses import dataclass, replace

import numpy as np

from tepsipe.errors import InputError, listed
from tepsipe.ingest.belt_table import belt_clock, rounded_rate
from tepsipe.io.readers.c3d import Markers
from tepsipe.io.readers.dflow import FRAME, MARKER, DFlowTable, marker_columns, plate_columns, unit_of
from tepsipe.io.readers.recording import Channel, ForcePlate, Recording
from tepsipe.signals.resampling import repair_time_stamps
from tepsipe.signals.time_alignment import common_signal_delay

# stamps are medians over so many blocks before a line is fitted: frames that queued up do not matter
BLOCKS = 20
LEAST_CORRELATION = 0.7
# two records of one belt velocity (m/s) agree in size
GAIN = (0.9, 1.1)
# the belt's speed is regulated: smaller changes cannot align two files
STEADY_M_PER_S = 0.02
BACKWARD = "XYZ".index("Z")


@dataclass(frozen=True)
class DFlowOptions:
    """How to make one recording of D-Flow's files.

    Attributes
    ----------
    max_gap_s : float
        Longest time for which frames may be missing (s).
    belt_fixed_labels : tuple of str
        Belt-fixed markers, whose velocity along the belt is compared with the recorded belt speed.
    search_s : float
        Longest error of the time stamps between the two files (s).
    """

    max_gap_s: float
    belt_fixed_labels: tuple[str, ...] = ()
    search_s: float = 5.0


@dataclass(frozen=True)
class _Clock:
    """Where the rows of a mocap file stand on a regular clock, and D-Flow's time of its first frame."""

    rows: np.ndarray  # rows that are frames of their own
    index: np.ndarray  # number of the sample, counted from the first (-)
    rate_hz: float
    first_s: float  # stamp of sample 0, by a line through all stamps (s)
    period_s: float  # stamps per sample, by the same line (s)


def dflow_recording(mocap: DFlowTable, record: DFlowTable | None, options: DFlowOptions) -> Recording:
    """One recording of D-Flow's mocap file and, if there is one, its record file.

    Repeated frames are dropped. Where frames were dropped, markers are NaN and forces and channels are
    interpolated linearly. Signals of the record file are interpolated linearly at the instants of the frames.

    Parameters
    ----------
    mocap : DFlowTable
        Markers (m), force plates (N, N·m) and channels.
    record : DFlowTable or None
        Belt speeds (m/s) and other signals.
    options : DFlowOptions
        Longest gap (s), belt-fixed markers, longest error of the stamps (s).

    Returns
    -------
    Recording
        Markers (m), plates (N, N·m) and channels in the axes of D-Flow: x to the right, y up, z backward. A
        belt's speed is positive where its surface moves backward.

    Raises
    ------
    InputError
        If the mocap file holds neither markers nor plates, frames are missing for too long, or the record
        file is of another trial or shares no signal with the mocap file.
    """
    if not mocap.is_mocap:
        raise InputError(
            f"{mocap.name}: expected markers (.PosX) or force plates (FP1.ForX), found "
            f"{listed(mocap.columns)}: name the file of D-Flow's mocap module"
        )
    clock = _clock(mocap, options.max_gap_s)
    n = int(clock.index[-1]) + 1

    def on_grid(values: np.ndarray) -> np.ndarray:
        """Samples at their place on the clock, NaN where none was recorded."""
        grid = np.full((n, *values.shape[1:]), np.nan)
        grid[clock.index] = values[clock.rows]
        return grid

    positions = {label: on_grid(x) for label, x in marker_columns(mocap).items()}
    markers = None
    if positions:
        markers = Markers(clock.rate_hz, tuple(positions), np.stack(list(positions.values()), axis=1))
    plates = tuple(
        ForcePlate(_bridged(on_grid(force)), _bridged(on_grid(moment)), clock.rate_hz)
        for force, moment in plate_columns(mocap).values()
    )
    channels = {
        name: Channel(_bridged(on_grid(x)), unit_of(name), clock.rate_hz)
        for name, x in mocap.columns.items()
        if not MARKER.fullmatch(name) and np.isfinite(x).any()
    }
    recording = Recording(mocap.name, markers, plates, channels)
    return recording if record is None else _with_record(recording, mocap, record, clock, options)


def _clock(mocap: DFlowTable, max_gap_s: float) -> _Clock:
    """Regular clock of a mocap file: its frame counter, or its stamps if they come from a regular clock."""
    repaired = repair_time_stamps(mocap.time, np.inf, mocap.name)
    if mocap.frames is None:
        found = belt_clock(mocap.time)
        if not found.regular:
            raise InputError(
                f"{mocap.name}: expected the column {FRAME!r} or regular time stamps, found none, and stamps "
                f"up to {1e3 * found.largest_deviation_s:.3g} ms from a regular clock: export the file with "
                "its frame counter"
            )
        rows, index = np.arange(mocap.time.size), np.arange(mocap.time.size)
    else:
        rows = np.flatnonzero(np.diff(mocap.frames, prepend=mocap.frames[0] - 1) != 0)
        index = mocap.frames[rows] - mocap.frames[0]
    if rows.size < BLOCKS or not repaired.longest_step_s > 0.0:
        raise InputError(
            f"{mocap.name}: expected at least {BLOCKS} frames at different times, found {rows.size} frames: "
            "record again"
        )
    period, first = _line(index, mocap.time[rows])
    if not 1e-4 < period < 1.0:
        raise InputError(
            f"{mocap.name}: expected frames at 1 to 10000 Hz, found {period:.3g} s between frames: check "
            "that the time stamps are in seconds"
        )
    steps = np.diff(index)
    longest = float(steps.max() - 1) * period
    if longest > max_gap_s:
        k = int(np.argmax(steps))
        raise InputError(
            f"{mocap.name}: expected no more than {max_gap_s:g} s without frames, found {longest:.3g} s from "
            f"line {mocap.lines[rows[k]]} on: cut the trial there or allow longer gaps in the configuration"
        )
    return _Clock(rows, index, rounded_rate(1.0 / period), first, period)


def _line(index: np.ndarray, time: np.ndarray) -> tuple[float, float]:
    """Slope (s) and intercept (s) of a line through the medians of blocks of stamps."""
    blocks = np.array_split(np.arange(index.size), min(BLOCKS, index.size))
    middle = [(np.median(index[block]), np.median(time[block])) for block in blocks]
    slope, start = np.polyfit(*zip(*middle, strict=True), 1)
    return float(slope), float(start)


def _bridged(values: np.ndarray) -> np.ndarray:
    """Samples, shape (n, ...), with missing ones interpolated linearly."""
    columns = values.reshape(values.shape[0], -1)
    index = np.arange(columns.shape[0])
    for column in columns.T:
        there = np.isfinite(column)
        if there.any() and not there.all():
            column[~there] = np.interp(index[~there], index[there], column[there])
    return columns.reshape(values.shape)


def _with_record(
    recording: Recording, mocap: DFlowTable, record: DFlowTable, clock: _Clock, options: DFlowOptions
) -> Recording:
    """The recording with the signals of the record file, NaN where they were not recorded."""
    if record.is_mocap and not record.speeds:
        raise InputError(
            f"{record.name}: expected belt speeds of D-Flow's record module, found markers or force plates: "
            "name the mocap file in the column of the markers and the record file in that of the log"
        )
    n = int(clock.index[-1]) + 1
    if mocap.frames is not None and record.frames is not None:
        sample = _by_counter(mocap, record)
    else:
        sample = (_stamps(record, options.max_gap_s) - clock.first_s) / clock.period_s
    _refuse_no_overlap(mocap, record, sample, n)
    order = np.concatenate([[True], np.diff(sample) > 0.0])
    signals = {name: x for name, x in record.columns.items() if np.isfinite(x).any()}

    def at(late: float) -> dict[str, np.ndarray]:
        """Signals at the frames, if the record file is late by so many samples."""
        where = np.arange(n) + late
        found = {name: np.interp(where, sample[order], x[order]) for name, x in signals.items()}
        outside = (where < sample[0] - 1.0) | (where > sample[-1] + 1.0)
        return {name: np.where(outside, np.nan, x) for name, x in found.items()}

    late = 0.0
    if mocap.frames is None or record.frames is None:
        late = _late(recording, record, at(0.0), clock.rate_hz, options)
    channels = {
        name: Channel(x, unit_of(name), clock.rate_hz)
        for name, x in at(late).items()
        if name not in recording.channels
    }
    return replace(recording, channels=recording.channels | channels)


def _by_counter(mocap: DFlowTable, record: DFlowTable) -> np.ndarray:
    """Samples at which the record file's rows stand (-): rows of one frame are spread over it evenly."""
    frames = record.frames - mocap.frames[0]
    first = np.flatnonzero(np.diff(frames, prepend=frames[0] - 1) != 0)
    counts = np.diff(np.append(first, frames.size))
    within = np.arange(frames.size) - np.repeat(first, counts)
    return frames + within / np.repeat(counts, counts)


def _stamps(record: DFlowTable, max_gap_s: float) -> np.ndarray:
    """Time stamps of a record file (s), replaced by a line if its samples come from a regular clock."""
    repair_time_stamps(record.time, max_gap_s, record.name)
    if record.time.size < BLOCKS or not np.ptp(record.time) > 0.0:
        raise InputError(
            f"{record.name}: expected at least {BLOCKS} samples at different times, found "
            f"{record.time.size}: record again"
        )
    clock = belt_clock(record.time)
    if not clock.regular:
        return record.time
    index = np.arange(record.time.size)
    slope, start = _line(index, record.time)
    return start + slope * index


def _refuse_no_overlap(mocap: DFlowTable, record: DFlowTable, sample: np.ndarray, n: int) -> None:
    """Refuse a record file that covers less than half of the mocap file."""
    covered = (min(sample[-1], n - 1.0) - max(sample[0], 0.0)) / (n - 1.0)
    if covered < 0.5:
        by = "frames" if record.frames is not None and mocap.frames is not None else "times"
        a, b = ((t.frames if by == "frames" else t.time)[[0, -1]].tolist() for t in (mocap, record))
        raise InputError(
            f"{record.name}: expected the {by} of {mocap.name} ({a[0]:.8g} to {a[1]:.8g}), found "
            f"{b[0]:.8g} to {b[1]:.8g}: it is of another trial, name the record file of this one"
        )


def _late(
    recording: Recording,
    record: DFlowTable,
    signals: dict[str, np.ndarray],
    rate_hz: float,
    options: DFlowOptions,
) -> float:
    """Samples by which the record file is late after alignment by stamps (-), from a common signal."""
    common = [name for name in signals if name in recording.channels]
    pairs = [(name, recording.channels[name].values, signals[name], False) for name in common]
    speeds = [name for name in record.speeds if name in signals]
    moving = [name for name in speeds if np.nanstd(signals[name]) > STEADY_M_PER_S]
    velocity = _belt_fixed_velocity(recording, options.belt_fixed_labels)
    if velocity is not None:
        pairs += [(name, velocity, _over_two_frames(signals[name]), True) for name in moving]
    pairs = [pair for pair in pairs if np.nanstd(pair[1]) > 0.0 and np.nanstd(pair[2]) > 0.0]
    if not pairs:
        if speeds and not moving:
            return 0.0  # at constant speed there is nothing to align, and no need to
        raise InputError(
            f"{record.name}: expected a signal that the mocap file holds, too, or belt-fixed markers, found "
            f"{listed(signals)}: record a common channel or the frame counter with the belt speed, or name "
            "belt-fixed markers in the configuration"
        )
    scored = [
        (abs(r), name, delay, gain, is_speed)
        for name, reference, signal, is_speed in pairs
        for delay, r, gain in [common_signal_delay(reference, signal, rate_hz, options.search_s)]
    ]
    # a common channel is an exact copy; it goes before a marker that follows the belt
    correlation, name, delay, gain, is_speed = max(scored, key=lambda score: (not score[4], score[0]))
    what = "the velocity of the belt-fixed markers" if is_speed else f"the same channel of {recording.name}"
    if correlation < LEAST_CORRELATION:
        raise InputError(
            f"{record.name}: expected {name!r} to follow {what} (correlation at least "
            f"{LEAST_CORRELATION:g}), found {correlation:.2f} within {options.search_s:g} s of the stamps: "
            "it is of another trial, or the markers are not fixed to the belt"
        )
    if is_speed and not GAIN[0] <= abs(gain) <= GAIN[1]:
        raise InputError(
            f"{record.name}: expected {name!r} to be as large as {what}, found {1.0 / abs(gain):.2f} times "
            "that: it is of another trial, or not in m/s"
        )
    return delay * rate_hz


def _over_two_frames(speed: np.ndarray) -> np.ndarray:
    """Mean over the frames before and after (m/s), as the central difference of a position gives it."""
    mean = speed.copy()
    mean[1:-1] = 0.25 * (speed[:-2] + 2.0 * speed[1:-1] + speed[2:])
    return mean


def _belt_fixed_velocity(recording: Recording, labels: tuple[str, ...]) -> np.ndarray | None:
    """Mean velocity of the belt-fixed markers backward along the belt (m/s), shape (n,); NaN while hidden.

    Raises
    ------
    InputError
        If a marker is not in the file.
    """
    if recording.markers is None or not labels:
        return None
    known = recording.markers.labels
    for label in labels:
        if label not in known:
            raise InputError(
                f"{recording.name}: expected the belt-fixed marker {label!r}, found {listed(known)}: name "
                "the file's markers in the configuration"
            )
    backward = recording.markers.positions[:, [known.index(label) for label in labels], BACKWARD]
    velocity = recording.markers.rate_hz * np.gradient(backward, axis=0)
    seen = np.isfinite(velocity).all(axis=1)
    mean = np.where(seen, np.where(np.isfinite(velocity), velocity, 0.0).mean(axis=1), np.nan)
    return mean if seen.any() else None
