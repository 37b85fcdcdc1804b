"""A file of D-Flow's mocap module as a recording: markers, force plates and channels on the frames' clock.

D-Flow stamps a frame when it receives it, not when it was taken: frames queue up and are stamped together.
The clock is therefore the frame counter, and stamps only give its rate.
"""

from pathlib import Path

import numpy as np

from tepsipe.errors import InputError, listed
from tepsipe.io.readers.c3d import Markers
from tepsipe.io.readers.clock import BLOCKS, Clock, bridged, line_through, regular_clock, rounded_rate
from tepsipe.io.readers.dflow import (
    MARKER,
    DFlowTable,
    marker_columns,
    plate_columns,
    read_dflow,
    unit_of,
)
from tepsipe.io.readers.recording import Channel, ForcePlate, Recording

# longest time without frames (s): what is shorter is a gap of the markers
LONGEST_GAP_S = 0.5


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
