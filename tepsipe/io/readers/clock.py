"""Regular clocks behind time stamps: the sampling rate, and the position of each sample on the clock.

Instruments sample at a regular rate; the times in their files are rounded, jitter, or were taken by the
computer that wrote them. Samples are kept as they are and placed on the regular clock; missing ones leave
gaps.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
import scipy

from tepsipe.errors import InputError

# a line is fitted to medians over this number of blocks, so that single late stamps do not matter
BLOCKS = 20
# one late stamp affects one sample, a missing sample shifts all that follow: the median over this many
# stamps separates the two
SMOOTHED_STAMPS = 51
# share of the stamps that lie within 0.4 periods of the clock
WITHIN_PERIODS, SHARE = 0.4, 0.99
# a rate this close to a value with three significant digits is rounded to it
ROUNDED_WITHIN = 1e-3
# longest time of missing forces and channels that a straight line bridges (s)
LONGEST_BRIDGE_S = 0.05


@dataclass(frozen=True)
class Clock:
    """A regular clock and the positions of the samples on it."""

    rate_hz: float
    """Samples per second."""
    rows: np.ndarray
    """Rows of the file that are samples of their own."""
    index: np.ndarray
    """Place of each of these on the clock, counted from the first."""
    first_s: float
    """Time stamp of the first place, by a line through all stamps."""
    period_s: float
    """Time between two places by the same line (s), on the clock of the stamps."""

    @property
    def size(self) -> int:
        """Number of positions from the first sample to the last."""
        return int(self.index[-1]) + 1

    def placed(self, values: np.ndarray) -> np.ndarray:
        """Rows of a file, shape (rows, ...), at their positions, shape (size, ...), in their unit; or NaN."""
        grid = np.full((self.size, *values.shape[1:]), np.nan)
        grid[self.index] = values[self.rows]
        return grid


def rounded_rate(rate_hz: float) -> float:
    """A measured rate (Hz), rounded so that two recordings have the same rate despite clock drift.

    Rounded to three significant digits if that changes it by at most 0.1 % (100.004 becomes 100),
    otherwise to four.
    """
    rounded = float(f"{rate_hz:.3g}")
    return rounded if abs(rounded - rate_hz) <= ROUNDED_WITHIN * rate_hz else float(f"{rate_hz:.4g}")


def line_through(index: np.ndarray, time: np.ndarray) -> tuple[float, float]:
    """Slope and intercept (s) of a line through the medians of blocks of stamps ``time`` (s)."""
    blocks = np.array_split(np.arange(index.size), min(BLOCKS, index.size))
    middle = [(np.median(index[block]), np.median(time[block])) for block in blocks]
    slope, start = np.polyfit(*zip(*middle, strict=True), 1)
    return float(slope), float(start)


def regular_clock(time: np.ndarray, name: str, max_gap_s: float = 0.5) -> Clock:
    """The regular clock of a file's time stamps.

    time: time stamps (s). A step is about a whole number of periods, and a stamp that repeats the one
    before is no sample of its own. Where that fails, samples may have queued up before a computer stamped
    them. They are taken as regular if the stamps, smoothed by a running median over 51, stay within 0.4
    periods of a line.
    name: names the file in messages.
    max_gap_s: longest time for which samples may be missing.
    Returns: rate and the place of each sample.
    """
    bad = np.flatnonzero(~np.isfinite(time))
    if bad.size:
        raise InputError(
            f"{name}: expected a time stamp on every line, found none on line {bad[0] + 1} of the "
            "samples: repair or cut the file there"
        )
    steps = np.diff(time)
    back = np.flatnonzero(steps < 0.0)
    if back.size:
        raise InputError(
            f"{name}: expected time to increase, found it running backwards from {time[back[0]]:.6g} s to "
            f"{time[back[0] + 1]:.6g} s at sample {back[0] + 2}: cut the file into trials or repair it"
        )
    rows = np.flatnonzero(np.concatenate([[True], steps > 0.0]))
    if rows.size < BLOCKS:
        raise InputError(
            f"{name}: expected at least {BLOCKS} samples at different times, found {rows.size}: record "
            "again, or export the time with more decimals"
        )
    steps = np.diff(time[rows])
    period = float(np.median(steps))
    k = int(np.argmax(steps))
    if steps[k] > max_gap_s + 1.5 * period:
        raise InputError(
            f"{name}: expected no step longer than {max_gap_s:g} s, found one of {steps[k]:.3g} s at "
            f"{time[rows][k]:.6g} s: cut the trial there"
        )
    index = np.concatenate([[0], np.cumsum(np.maximum(1, np.round(steps / period)))]).astype(np.int64)
    slope, first = line_through(index, time[rows])
    away = np.abs(time[rows] - (first + slope * index)) / slope
    if rows.size < 0.9 * time.size or np.mean(away <= WITHIN_PERIODS) < SHARE:
        queued = _queued(time)
        if queued is not None:
            return queued
    if rows.size < 0.9 * time.size:
        share = 100.0 * (1.0 - rows.size / time.size)
        raise InputError(
            f"{name}: expected a different time stamp for every sample, found {share:.0f} % equal to the "
            "preceding one: export the time with more decimals"
        )
    if np.mean(away <= WITHIN_PERIODS) < SHARE:
        raise InputError(
            f"{name}: expected the time stamps of a regular clock, found stamps up to "
            f"{1e3 * slope * away.max():.3g} ms away from one of {1.0 / slope:.4g} Hz: export the samples at "
            "a regular rate, with enough decimals of the time"
        )
    return Clock(rounded_rate(1.0 / slope), rows, index, first, slope)


def _queued(time: np.ndarray) -> Clock | None:
    """Clock of samples none of which is missing, but some of which queued up before they were stamped."""
    if time.size < 4 * SMOOTHED_STAMPS:
        return None
    every = np.arange(time.size)
    slope, first = line_through(every, time)
    smoothed = scipy.ndimage.median_filter(
        time - (first + slope * every), size=SMOOTHED_STAMPS, mode="reflect"
    )
    if np.abs(smoothed).max() > WITHIN_PERIODS * slope:
        return None
    return Clock(rounded_rate(1.0 / slope), every, every, first, slope)


def bridged(values: Annotated[np.ndarray, "(n, ...)"], rate_hz: float) -> np.ndarray:
    """Samples, shape (n, ...), in their unit, with short gaps bridged by straight lines.

    Where more than `LONGEST_BRIDGE_S` is missing, they stay NaN.

    values: Samples; NaN where one is missing.
    """
    columns = values.reshape(values.shape[0], -1).copy()
    index = np.arange(columns.shape[0])
    for column in columns.T:
        known = np.flatnonzero(np.isfinite(column))
        if not 0 < known.size < column.size:
            continue
        ends = np.concatenate(([-1], known, [column.size]))
        following = np.searchsorted(ends, index)
        within = ends[following] - ends[following - 1] <= LONGEST_BRIDGE_S * rate_hz + 1.5
        column[within] = np.interp(index[within], known, column[known])
    return columns.reshape(values.shape)
