"""Cubic splines through samples, in half the time of scipy.interpolate.CubicSpline, with the same numbers.

Its slopes s_i at the samples x_i, with steps h_i = t_(i+1) - t_i and d_i = (x_(i+1) - x_i) / h_i:

    h_i s_(i-1) + 2 (h_(i-1) + h_i) s_i + h_(i-1) s_(i+1) = 3 (h_i d_(i-1) + h_(i-1) d_i)

The first two pieces are one cubic, as are the last two. Derivatives need the slopes only.
"""

from typing import Annotated

import numpy as np
import scipy

FEWEST = 4


def cubic_spline(time: Annotated[np.ndarray, "(n,)"], x: np.ndarray) -> "scipy.interpolate.PPoly":
    """The spline through samples ``x``, shape (n, ...), at increasing instants (s)."""
    return pieces(time, x, slopes(time, x))


def slopes(time: Annotated[np.ndarray, "(n,)"], x: np.ndarray) -> np.ndarray:
    """Derivative of the spline at the samples (unit of ``x`` per s), shape of ``x``."""
    h = np.diff(time)
    if time.size < FEWEST or not (h > 0.0).all() or not np.isfinite(x).all():
        return scipy.interpolate.CubicSpline(time, x)(time, 1)  # through three samples, or refused there
    below, diagonal, above = np.empty(h.size), np.empty(time.size), np.empty(h.size)
    below[:-1], diagonal[1:-1], above[1:] = h[1:], 2.0 * (h[:-1] + h[1:]), h[:-1]
    diagonal[0], above[0] = h[1], time[2] - time[0]
    diagonal[-1], below[-1] = h[-2], time[-1] - time[-3]
    # one row per signal, contiguous as the solver wants them
    rows = np.ascontiguousarray(x.reshape(time.size, -1).T, dtype=float)
    d, right = np.diff(rows) / h, np.empty(rows.shape)
    right[:, 1:-1] = 3.0 * (h[1:] * d[:, :-1] + h[:-1] * d[:, 1:])
    right[:, 0] = ((h[0] + 2.0 * above[0]) * h[1] * d[:, 0] + h[0] ** 2 * d[:, 1]) / above[0]
    right[:, -1] = (h[-1] ** 2 * d[:, -2] + (2.0 * below[-1] + h[-1]) * h[-2] * d[:, -1]) / below[-1]
    solution = scipy.linalg.lapack.dgtsv(below, diagonal, above, right.T, 1, 1, 1, 1)[3]
    return np.ascontiguousarray(solution).reshape(x.shape)


def pieces(time: np.ndarray, x: np.ndarray, s: np.ndarray) -> "scipy.interpolate.PPoly":
    """Cubic pieces through samples with given slopes."""
    time, x = np.ascontiguousarray(time, dtype=float), np.asarray(x, dtype=float)
    h = np.diff(time).reshape(-1, *[1] * (x.ndim - 1))
    d = np.diff(x, axis=0) / h
    bend = (s[:-1] + s[1:] - 2.0 * d) / h
    coefficients = np.empty((4, *d.shape))
    np.divide(bend, h, out=coefficients[0])
    np.subtract((d - s[:-1]) / h, bend, out=coefficients[1])
    coefficients[2], coefficients[3] = s[:-1], x[:-1]
    return scipy.interpolate.PPoly.construct_fast(coefficients, time, True)
