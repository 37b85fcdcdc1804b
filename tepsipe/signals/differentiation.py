"""Time derivatives of sampled signals, and splines through them."""

from collections.abc import Callable, Iterator
from typing import Annotated

import numpy as np
import scipy

# at lower rates a cubic spline is not enough for the signals of a treadmill (Hz)
FAST_HZ, SLOW_DEGREE = 200.0, 7
# samples of a spline that are solved at a time, which bounds the memory of long records, and samples beside
# them: those beyond change the spline by less than rounding does (degree 7: 0.54^100)
PIECE, BESIDE = 2**18, 100


def degree_at(rate_hz: float) -> int:
    """Degree of the spline for `derivative` at a sampling rate (Hz): 3, and 7 below 200 Hz.

    At 100 Hz the derivative of a 20 Hz component by a cubic spline is 1.7 % too small, and 10 % at 30 Hz. A
    weight of 60 kg needs a force of a thousand newtons, of which 1 % is a sixth of the belt's friction.
    """
    return 3 if rate_hz > (1.0 - 1e-6) * FAST_HZ else SLOW_DEGREE


def derivative(time: Annotated[np.ndarray, "(n,)", "s"], x: np.ndarray, degree: int = 3) -> np.ndarray:
    """Time derivative at the samples, from a spline through them.

    The error is of fourth order in the sampling period: at 250 Hz the derivative of a 20 Hz
    component is 0.04 % too small (4 % with central differences), 0.2 % at 30 Hz; with a spline of degree 5,
    of sixth order, 0.02 % at 30 Hz. A signal and its derivatives therefore keep the same gain, at low rates
    with the degree of `degree_at`.

    degree: {3, 5, 7}: Degree of the spline.
    Returns: derivative (unit of ``x`` per s).
    """
    found = []
    for around, within in spline_pieces(time.size):
        slopes = _slopes(time[around], x[around], degree)
        found.append(slopes[within.start - around.start : within.stop - around.start])
    return np.concatenate(found)


def spline_pieces(count: int) -> Iterator[tuple[slice, slice]]:
    """Pieces of a record: samples through which a spline is put, and those among them for which it is used.

    count: samples of the record; up to ``PIECE`` are one piece.
    """
    for start in range(0, count, PIECE):
        stop = min(start + PIECE, count)
        yield slice(max(0, start - BESIDE), min(stop + BESIDE, count)), slice(start, stop)


def interpolant(
    time: Annotated[np.ndarray, "(n,)", "s"], x: np.ndarray
) -> Callable[[np.ndarray], np.ndarray]:
    """Cubic spline through the samples, a function of increasing instants (s)."""
    pieces = list(spline_pieces(time.size))
    splines = [scipy.interpolate.make_interp_spline(time[around], x[around]) for around, _ in pieces]
    starts = time[[within.start for _, within in pieces[1:]]]

    def values(instants: np.ndarray) -> np.ndarray:
        parts = np.split(instants, np.searchsorted(instants, starts))
        return np.concatenate([spline(part) for spline, part in zip(splines, parts, strict=True)])

    return values


def _slopes(time: np.ndarray, x: np.ndarray, degree: int) -> np.ndarray:
    """As `derivative`, for one piece."""
    if degree != 3:
        return scipy.interpolate.make_interp_spline(time, x, degree).derivative()(time)
    spline = scipy.interpolate.CubicSpline(time, x)
    # at its knots the derivative is a coefficient and needs evaluation at the last one only
    return np.concatenate([spline.c[2] + 0.0, spline(time[-1:], 1)])
