"""Fewer points of a long trace, without losing an extreme: all samples where it matters, elsewhere pairs.

Samples around perturbations are kept. The others are grouped into buckets of equal length, of which the
lowest and the highest sample are kept, in their order in time.
"""

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np

LARGEST = 32767
MISSING = -32768


@dataclass(frozen=True)
class Run:
    """Consecutive samples that are kept, or grouped into buckets."""

    start: int
    stop: int
    """First sample, and the one after the last (samples)."""
    step: int
    """1 where every sample is kept, otherwise the length of a bucket (samples)."""

    @property
    def points(self) -> int:
        """Number of points that remain (-)."""
        length = self.stop - self.start
        return length if self.step == 1 else 2 * -(-length // self.step)


def plan_runs(samples: int, points: int, focus: Sequence[tuple[int, int]] = ()) -> tuple[Run, ...]:
    """Decide which samples to keep and which to group.

    samples: length of the trace (samples).
    points: number of points that may remain (-), apart from two for each part of the trace.
    focus: parts that are kept whole if they fit into three quarters of the points (samples).
    Returns: runs that cover the trace without gaps (samples).
    """
    if samples <= points:
        return (Run(0, samples, 1),) if samples else ()
    parts = _merged(focus, samples)
    kept = sum(stop - start for start, stop in parts)
    if not parts or kept > 0.75 * points:
        return (Run(0, samples, max(2, -(-2 * samples // points))),)
    step = max(2, -(-2 * (samples - kept) // (points - kept)))
    runs, at = [], 0
    for start, stop in parts:
        if start > at:
            runs.append(Run(at, start, step))
        runs.append(Run(start, stop, 1))
        at = stop
    if at < samples:
        runs.append(Run(at, samples, step))
    return tuple(runs)


def _merged(focus: Sequence[tuple[int, int]], samples: int) -> list[tuple[int, int]]:
    """Parts in their order, clipped to the trace, those that touch joined."""
    merged: list[tuple[int, int]] = []
    for start, stop in sorted((max(0, int(a)), min(samples, int(b))) for a, b in focus):
        if stop <= start:
            continue
        if merged and start <= merged[-1][1]:
            merged[-1] = (merged[-1][0], max(stop, merged[-1][1]))
        else:
            merged.append((start, stop))
    return merged


def decimate(x: np.ndarray, runs: Sequence[Run]) -> Annotated[np.ndarray, "(points,)"]:
    """Points of a trace that remain.

    x: the trace (any unit); NaN where a sample is missing.
    runs: from `plan_runs` (samples).
    Returns: samples, or lowest and highest of each bucket in their order (unit of ``x``); NaN for a bucket
    without a sample.
    """
    x = np.asarray(x, dtype=float)
    parts = [x[r.start : r.stop] if r.step == 1 else _extremes(x[r.start : r.stop], r.step) for r in runs]
    return np.concatenate(parts) if parts else np.empty(0)


def _extremes(x: np.ndarray, step: int) -> np.ndarray:
    full = np.full(-(-x.size // step) * step, np.nan)
    full[: x.size] = np.where(np.isfinite(x), x, np.nan)
    buckets = full.reshape(-1, step)
    missing = np.isnan(buckets)
    low = np.where(missing, np.inf, buckets).argmin(axis=1)
    high = np.where(missing, -np.inf, buckets).argmax(axis=1)
    at = np.sort(np.column_stack([low, high]), axis=1)
    return np.take_along_axis(buckets, at, axis=1).ravel()


@dataclass(frozen=True)
class Packed:
    """A trace as 16-bit numbers in text."""

    offset: float
    scale: float
    """The value is offset + scale * number (unit of the trace)."""
    text: str
    """Numbers, two bytes each, the low byte first, in base64; the lowest number is a missing sample."""


def pack(x: Annotated[np.ndarray, "(points,)"]) -> Packed:
    """Write points as 16-bit numbers: the step is 1/65534 of their range.

    x: from `decimate` (any unit).
    Returns: text, and what brings it back to the unit of ``x``.
    """
    there = np.isfinite(x)
    low, high = (float(x[there].min()), float(x[there].max())) if there.any() else (0.0, 0.0)
    offset, scale = 0.5 * low + 0.5 * high, (0.5 * high - 0.5 * low) / LARGEST
    numbers = np.full(x.size, MISSING, dtype="<i2")
    if scale > 0.0:
        steps = np.rint((x[there] - offset) / scale)
        numbers[there] = np.clip(steps, -LARGEST, LARGEST).astype("<i2")
    else:
        numbers[there] = 0
    return Packed(offset, scale, base64.b64encode(numbers.tobytes()).decode("ascii"))


def unpack(packed: Packed) -> np.ndarray:
    """Points of a packed trace, as the page reads them (unit of the trace), shape (points,)."""
    numbers = np.frombuffer(base64.b64decode(packed.text), dtype="<i2")
    return np.where(numbers == MISSING, np.nan, packed.offset + packed.scale * numbers)
