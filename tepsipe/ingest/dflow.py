"""Belt speeds from D-Flow's record file on the clock of its mocap file.

The record module writes at an irregular rate, on D-Flow's own clock. Its samples are placed by the frame
counter if that was recorded with them; otherwise by the time stamps, which D-Flow sets when it receives a
frame, and then by a signal that both files hold.
"""

from dataclasses import replace
from pathlib import Path

import numpy as np

from tepsipe.errors import InputError, listed
from tepsipe.ingest.belt_table import belt_clock
from tepsipe.io.readers.clock import BLOCKS, Clock, line_through
from tepsipe.io.readers.dflow import DFlowTable, dflow_recording, frame_clock, read_dflow, unit_of
from tepsipe.io.readers.recording import Channel, Recording
from tepsipe.signals.resampling import repair_time_stamps
from tepsipe.signals.time_alignment import common_signal_delay

LEAST_CORRELATION = 0.7
# two records of one belt velocity (m/s) agree in size
GAIN = (0.9, 1.1)
# the belt's speed is regulated: smaller changes cannot align two files
STEADY_M_PER_S = 0.02
BACKWARD = "XYZ".index("Z")
# longest time for which samples of the record file may be missing (s)
MAX_GAP_S = 0.1
# longest error of the time stamps between the two files (s)
SEARCH_S = 5.0


def read_dflow_files(
    mocap: str | Path, record: str | Path | None, belt_fixed_labels: tuple[str, ...]
) -> Recording:
    """Read D-Flow's mocap file and, if there is one, its record file; see `with_record`.

    mocap, record: paths of the two files; ``record`` is None if there is none.
    belt_fixed_labels: belt-fixed markers, whose velocity along the belt is compared with the recorded belt
    speed.
    Returns: markers, force plates, belt speeds and channels in the axes of D-Flow.
    """
    table = read_dflow(mocap)
    if record is None:
        return dflow_recording(table)
    return with_record(table, read_dflow(record), belt_fixed_labels)


def with_record(mocap: DFlowTable, record: DFlowTable, belt_fixed_labels: tuple[str, ...]) -> Recording:
    """One recording of D-Flow's mocap file and its record file.

    Signals of the record file are interpolated linearly at the instants of the frames. Frames that it does
    not cover are cut off.

    mocap: markers, force plates and channels.
    record: belt speeds and other signals.
    belt_fixed_labels: belt-fixed markers, whose velocity along the belt is compared with the recorded belt
    speed.
    Returns: as `dflow_recording`, with the record file's signals among the channels. A belt's speed is
    positive where its surface moves backward, along z.
    """
    return _cut(*aligned_record(mocap, record, belt_fixed_labels))


def aligned_record(
    mocap: DFlowTable, record: DFlowTable, belt_fixed_labels: tuple[str, ...]
) -> tuple[Recording, int, int]:
    """The same with all frames, NaN where the record file has none, and the first and last frame it covers.

    Returns: recording (m, N, N·m, m/s), first covered frame, and the frame after the last.
    """
    if record.is_mocap and not record.speeds:
        raise InputError(
            f"{record.name}: expected belt speeds of D-Flow's record module, found markers or force plates: "
            "name the mocap file in the column of the markers and the record file in that of the log"
        )
    recording, clock = dflow_recording(mocap), frame_clock(mocap)
    n = clock.size
    counted = mocap.frames is not None and record.frames is not None
    if counted:
        sample = _by_counter(mocap, record)
    else:
        sample = (_stamps(record, MAX_GAP_S) - clock.first_s) / clock.period_s
    _refuse_no_overlap(mocap, record, sample, n)
    order = np.concatenate([[True], np.diff(sample) > 0.0])
    signals = {name: x for name, x in record.columns.items() if np.isfinite(x).any()}
    if not signals:
        raise InputError(
            f"{record.name}: expected belt speeds of D-Flow's record module, found no numbers: record again"
        )

    def at(late: float) -> dict[str, np.ndarray]:
        """Signals at the frames, if the record file is late by a number of samples."""
        where = np.arange(n) + late
        interpolated = {name: np.interp(where, sample[order], x[order]) for name, x in signals.items()}
        outside = (where < sample[0] - 1.0) | (where > sample[-1] + 1.0)
        return {name: np.where(outside, np.nan, x) for name, x in interpolated.items()}

    late = 0.0 if counted else _late(recording, record, at(0.0), clock, belt_fixed_labels)
    interpolated = at(late)
    seen = np.flatnonzero(np.isfinite(np.column_stack(list(interpolated.values()))).any(axis=1))
    if seen.size < 0.5 * n:
        raise InputError(
            f"{record.name}: expected samples for the {n} frames of {mocap.name}, found them for "
            f"{seen.size}: it is of another trial, or was stopped early"
        )
    channels = {
        name: Channel(x, unit_of(name), clock.rate_hz)
        for name, x in interpolated.items()
        if name not in recording.channels
    }
    whole = replace(recording, channels=recording.channels | channels)
    return whole, seen[0], seen[-1] + 1


def _cut(recording: Recording, first: int, stop: int) -> Recording:
    """The frames that both files cover; all signals of a recording of D-Flow have one clock."""
    within = slice(first, stop)
    markers = recording.markers
    if markers is not None:
        markers = replace(markers, positions=markers.positions[within])
    plates = tuple(replace(p, force=p.force[within], moment=p.moment[within]) for p in recording.plates)
    channels = {name: replace(c, values=c.values[within]) for name, c in recording.channels.items()}
    return replace(recording, markers=markers, plates=plates, channels=channels)


def _by_counter(mocap: DFlowTable, record: DFlowTable) -> np.ndarray:
    """Samples of the record file's rows; rows of one frame are spread over it evenly."""
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
    slope, start = line_through(index, record.time)
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
    clock: Clock,
    belt_fixed_labels: tuple[str, ...],
) -> float:
    """Delay of the record file after alignment by stamps (samples), from a common signal."""
    common = [name for name in signals if name in recording.channels]
    pairs = [(name, recording.channels[name].values, signals[name], False) for name in common]
    pairs = [pair for pair in pairs if np.nanstd(pair[1]) > 0.0 and np.nanstd(pair[2]) > 0.0]
    speeds = [name for name in record.speeds if name in signals]
    moving = [name for name in speeds if np.nanstd(signals[name]) > STEADY_M_PER_S]
    # an empty belt has no such markers: a common channel is used instead
    velocity = None if pairs else _belt_fixed_velocity(recording, belt_fixed_labels)
    if velocity is not None:
        pairs += [(name, velocity, _over_two_frames(signals[name]), True) for name in moving]
    if not pairs:
        if speeds and not moving:
            return 0.0  # at constant speed there is nothing to align, and no need to
        raise InputError(
            f"{record.name}: expected a signal that the mocap file holds, too, or belt-fixed markers, found "
            f"{listed(signals)}: record a common channel or the frame counter with the belt speed, or "
            "name belt-fixed markers in plate_treadmill.recording.belt_velocity"
        )
    scored = [
        (abs(r), name, delay, gain, is_speed)
        for name, reference, signal, is_speed in pairs
        for delay, r, gain in [common_signal_delay(reference, signal, clock.rate_hz, SEARCH_S)]
    ]
    # a common channel is an exact copy, preferred to a marker that follows the belt
    correlation, name, delay, gain, is_speed = max(scored, key=lambda score: (not score[4], score[0]))
    what = "the velocity of the belt-fixed markers" if is_speed else f"the same channel of {recording.name}"
    if correlation < LEAST_CORRELATION:
        raise InputError(
            f"{record.name}: expected {name!r} to follow {what} (correlation at least "
            f"{LEAST_CORRELATION:g}), found {correlation:.2f} within {SEARCH_S:g} s of the stamps: "
            "it is of another trial, or the markers are not fixed to the belt"
        )
    if is_speed and not GAIN[0] <= abs(gain) <= GAIN[1]:
        raise InputError(
            f"{record.name}: expected {name!r} to be as large as {what}, found {1.0 / abs(gain):.2f} times "
            "that: it is of another trial, or not in m/s"
        )
    return delay * clock.rate_hz


def _over_two_frames(speed: np.ndarray) -> np.ndarray:
    """Mean over the frames before and after (m/s), as the central difference of a position gives it."""
    mean = speed.copy()
    mean[1:-1] = 0.25 * (speed[:-2] + 2.0 * speed[1:-1] + speed[2:])
    return mean


def _belt_fixed_velocity(recording: Recording, labels: tuple[str, ...]) -> np.ndarray | None:
    """Mean velocity of the belt-fixed markers backward along the belt (m/s), shape (n,); NaN while hidden."""
    if recording.markers is None or not labels:
        return None
    known = recording.markers.labels
    for label in labels:
        if label not in known:
            raise InputError(
                f"{recording.name}: expected the belt-fixed marker {label!r}, found {listed(known)}: "
                "correct plate_treadmill.recording.belt_velocity.markers"
            )
    backward = recording.markers.positions[:, [known.index(label) for label in labels], BACKWARD]
    velocity = recording.markers.rate_hz * np.gradient(backward, axis=0)
    seen = np.isfinite(velocity).all(axis=1)
    mean = np.where(seen, np.where(np.isfinite(velocity), velocity, 0.0).mean(axis=1), np.nan)
    return mean if seen.any() else None
