"""Active markers, strobed one after another, as the motion capture system records them."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from annotated_types import Ge, Gt, Le

from tepsipe.quantities import Angle, Height, NotNegative, Pause, Rate

# positions x, y, z of a marker (m), shape (n, 3), at instants (s), shape (n,)
MarkerPath = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class CaptureTruth:
    """Motion capture."""

    rate_hz: Rate
    """Frames per second."""
    marker_sampling_hz: Rate
    """Markers per second within a frame."""
    latency_s: Annotated[float, Ge(0), Le(10)]
    """Time from the trigger to the first marker of the first frame."""
    clock_ppm: Annotated[float, Ge(-100000), Le(100000), "parts per million"]
    """How much faster the clock runs than that of the treadmill's log."""
    length_scale: Annotated[float, Gt(0), Le(10)]
    """Measured over true lengths."""
    vertical_rad: Angle
    """Angle by which an upright rod is seen to lean forwards."""
    noise_m: Height
    """Standard deviation of each coordinate."""
    occlusions_per_minute: Annotated[NotNegative, "1/min"]
    """Mean number of occlusions of a marker per minute."""
    occlusion_s: Pause
    """Their mean length; each hides a frame at least."""


def record_markers(
    capture: CaptureTruth,
    paths: list[MarkerPath],
    trigger_s: float,
    frames: int,
    rng: np.random.Generator,
) -> Annotated[np.ndarray, "(frames, markers, 3)"]:
    """Marker positions frame by frame.

    paths: exact position x, y, z, shape (n, 3), at instants, shape (n,), of each marker, in the strober's
    order.
    trigger_s: time of the trigger's edge on the paths' clock.
    Returns: x, y, z (m); NaN while a marker is hidden.
    """
    faster = 1.0 + 1e-6 * capture.clock_ppm
    first = trigger_s + capture.latency_s + np.arange(frames) / (faster * capture.rate_hz)
    positions = np.empty((frames, len(paths), 3))
    for k, path in enumerate(paths):
        positions[:, k] = path(first + k / capture.marker_sampling_hz)
    if capture.vertical_rad:
        lean, upright = np.sin(capture.vertical_rad), np.cos(capture.vertical_rad)
        y, z = positions[:, :, 1].copy(), positions[:, :, 2].copy()
        positions[:, :, 1], positions[:, :, 2] = upright * y + lean * z, upright * z - lean * y
    positions *= capture.length_scale
    positions += capture.noise_m * rng.standard_normal(positions.shape)
    expected = capture.occlusions_per_minute * frames / capture.rate_hz / 60.0
    further_frames = max(capture.occlusion_s * capture.rate_hz - 1.0, 0.0)
    for k in range(len(paths)):
        for start in rng.integers(0, frames, rng.poisson(expected)):
            length = 1 + rng.poisson(further_frames)
            positions[start : start + length, k] = np.nan
    return positions
