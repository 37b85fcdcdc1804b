"""Contents of one file of a laboratory: markers, force plates and analog channels on one clock.

Readers of whole trials (C3D, D-Flow text, tables) return a `Recording`, whatever the file's own layout,
units and axes conventions are; ingest knows `Recording` only.
"""

from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import numpy as np

from tepsipe.errors import InputError, listed

METRES_PER_UNIT = {"mm": 1e-3, "cm": 1e-2, "m": 1.0}
DIRECTIONS = {
    f"{sign}{axis}": np.array([value * (axis == other) for other in "xyz"])
    for sign, value in (("+", 1.0), ("-", -1.0))
    for axis in "xyz"
}


@dataclass(frozen=True)
class Markers:
    """Marker positions as the motion capture system recorded them."""

    rate_hz: float
    """Frames per second."""
    labels: tuple[str, ...]
    positions: Annotated[np.ndarray, "(frames, markers, 3)"]
    """x, y, z (m); NaN while a marker was hidden. One that lacks a coordinate, or has an infinite one, is
    hidden."""

    def __post_init__(self) -> None:
        """Hide markers with incomplete coordinates."""
        whole = np.isfinite(self.positions).all(axis=-1, keepdims=True)
        object.__setattr__(self, "positions", np.where(whole, self.positions, np.nan))


@dataclass(frozen=True)
class Channel:
    """One analog channel, from the recording's first instant on."""

    values: np.ndarray
    """Samples in ``unit``; NaN where the file has none."""
    unit: str
    """Unit as the file names it; empty if it names none."""
    rate_hz: float
    limits: tuple[float, float] | None = None
    """Lowest and highest value that the recorder could write, in ``unit``, if the file gives them."""


@dataclass(frozen=True)
class ForcePlate:
    """Calibrated load of one force plate in the axes of the laboratory."""

    force: Annotated[np.ndarray, "(n, 3)"]
    """Ground reaction force on what stands on the plate (N): its vertical component is positive under
    load."""
    moment: Annotated[np.ndarray, "(n, 3)", "N·m"]
    """Moment of the same force system about the origin of the laboratory."""
    rate_hz: float
    corners: Annotated[np.ndarray, "(4, 3)"] | None = None
    """Corners of the plate's surface (m), if the file gives them."""
    origin: Annotated[np.ndarray, "(3,)"] | None = None
    """Vector from the plate's own origin to the centre of its surface in the axes of the laboratory (m), if
    the moment depends on it."""
    fault: str | None = None
    """Why the plate cannot be used, one sentence; force and moment are then NaN."""
    channels: tuple[str, ...] = ()
    """Labels of its analog channels."""
    calibration: Annotated[np.ndarray, "(6, channels)"] | None = None
    """Force and moment per unit of each channel (N, N·m over the channel's unit)."""

    @property
    def normal(self) -> np.ndarray | None:
        """Unit vector from the plate's surface upward, shape (3,), by the order of its corners."""
        if self.corners is None:
            return None
        down = np.cross(self.corners[0] - self.corners[1], self.corners[0] - self.corners[3])
        return -down / np.linalg.norm(down)


def centre_of_pressure(force: np.ndarray, moment: np.ndarray, up: np.ndarray) -> np.ndarray:
    """Centre of pressure up x M / (up F) on a level surface through the moment's origin (m), shape (n, 3).

    force, moment: F (N) and M (N·m), shape (n, 3).
    """
    return np.cross(up, moment) / (force @ up)[:, None]


@dataclass(frozen=True)
class Recording:
    """All signals in one trial's file, on one clock whose time 0 is the first sample of all."""

    name: str
    """Names the file in messages."""
    markers: Markers | None
    """Positions in the axes of the laboratory (m); None if the file holds none."""
    plates: tuple[ForcePlate, ...]
    """In the order of the file."""
    channels: dict[str, Channel] = field(default_factory=dict)
    """Analog channels by the label in the file, including the channels of force plates."""
    up: str = "+z"
    """Upward direction in the axes of the file, ``+x`` to ``-z``, as far as the file shows it."""


@dataclass(frozen=True)
class EmgRecording:
    """Electromyograms as the recorder wrote them, on the clock of the recorder."""

    rate_hz: float
    """Sampling rate of every channel."""
    muscles: tuple[str, ...]
    """Muscles whose channel is in the file, in the wanted order."""
    signals: Annotated[np.ndarray, "(n, muscles)"]
    """Raw electromyograms (uV)."""
    trigger: np.ndarray | None
    """Trigger line (V if its unit is a voltage, otherwise as recorded); None if it started the recorder."""
    limits: Annotated[np.ndarray, "(muscles, 2)"]
    """Lowest and highest value that each channel can hold (uV)."""
    missing: tuple[str, ...]
    """Wanted muscles whose channel is not in the file."""


def select_markers(markers: Markers, labels: list[str], name: str | Path) -> Markers:
    """Select markers of a file (m), in the wanted order.

    A label without the name of a subject before a colon also names the only marker of that label with one.
    """
    available = list(markers.labels)
    without_subject = [label.rpartition(":")[2] for label in available]
    columns = []
    for label in labels:
        known = available if label in available else without_subject
        if label not in known:
            raise InputError(
                f"{name}: expected a marker named {label!r}, found {listed(available)}: "
                "name the file's markers in the configuration"
            )
        if known.count(label) > 1:
            raise InputError(
                f"{name}: expected one marker named {label!r}, found {known.count(label)}: rename them "
                "when exporting"
            )
        columns.append(known.index(label))
    return Markers(markers.rate_hz, tuple(labels), markers.positions[:, columns])
