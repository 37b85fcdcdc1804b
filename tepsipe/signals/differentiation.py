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


def interpolated(time: Annotated[np.ndarray, "(n,)", "s"], x: np.ndarray, instants: np.ndarray) -> np.ndarray:
    """Values at instants (s), of any shape, of the cubic spline through the samples (unit of ``x``).

    Bit by bit those of ``scipy.interpolate.CubicSpline(time, x)(instants)``, but with the coefficients of
    pieces that hold an instant only: for fewer instants than samples.
    """
    if not _is_plain(time, x):
        return scipy.interpolate.CubicSpline(time, x)(instants)
    k = np.clip(np.searchsorted(time, instants, side="right") - 1, 0, time.size - 2)
    slopes = _slopes_at_knots(time, x)
    wide = (..., *(None,) * (x.ndim - 1))
    since, step = (instants - time[k])[wide], (time[k + 1] - time[k])[wide]
    return _piece(x[k], x[k + 1], slopes[k], slopes[k + 1], step, since)[0]


def _slopes(time: np.ndarray, x: np.ndarray, degree: int) -> np.ndarray:
    """As `derivative`, for one piece."""
    if degree != 3:
        return scipy.interpolate.make_interp_spline(time, x, degree).derivative()(time)
    if not _is_plain(time, x):
        return scipy.interpolate.CubicSpline(time, x)(time, 1)
    slopes = _slopes_at_knots(time, x)
    # bit by bit those of that class, which evaluates its last piece at the last knot
    step = time[-1] - time[-2]
    slopes[-1] = _piece(x[-2], x[-1], slopes[-2], slopes[-1], step, step)[1]
    return slopes + 0.0


def _is_plain(time: np.ndarray, x: np.ndarray) -> bool:
    """Test for samples that `scipy.interpolate.CubicSpline` neither refuses nor treats as a special case."""
    return bool(time.size > 3 and np.isfinite(x).all() and (np.diff(time) > 0.0).all())


def _slopes_at_knots(time: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Slopes of the cubic spline that is smooth over its second and last but one knot.

    They solve the equations of `scipy.interpolate.CubicSpline` and are the same, bit by bit; what that class
    computes besides takes longer than the solution.
    """
    h = np.diff(time)
    rise = np.diff(x, axis=0).T / h
    first, last = time[2] - time[0], time[-1] - time[-3]
    diagonal = np.concatenate([h[1:2], 2.0 * (h[:-1] + h[1:]), h[-2:-1]])
    right = np.empty(x.shape[::-1])
    right[..., 1:-1] = 3.0 * (h[1:] * rise[..., :-1] + h[:-1] * rise[..., 1:])
    # the square of a number may differ from that of an array in its last bit; that class has both
    a, z = (h[0], h[-1]) if x.ndim == 1 else (h[:1], h[-1:])
    right[..., 0] = ((a + 2.0 * first) * h[1] * rise[..., 0] + a**2 * rise[..., 1]) / first
    right[..., -1] = (z**2 * rise[..., -2] + (2.0 * last + z) * h[-2] * rise[..., -1]) / last
    below, above = np.append(h[1:], last), np.append(first, h[:-1])
    columns = right.reshape(-1, time.size).T
    slopes = scipy.linalg.lapack.dgtsv(below, diagonal, above, columns, 1, 1, 1, 1)[3]
    return np.ascontiguousarray(slopes.T.reshape(right.shape).T)


def _piece(x0, x1, slope0, slope1, step, since):
    """Value and slope of the cubic between two knots a ``step`` apart, some time since the first (s)."""
    rise = (x1 - x0) / step
    bend = (slope0 + slope1 - 2.0 * rise) / step
    second, third = (rise - slope0) / step - bend, bend / step
    squared = since * since
    value = x0 + slope0 * since + second * squared + third * (squared * since)
    return value, slope0 + second * since * 2.0 + third * squared * 3.0
