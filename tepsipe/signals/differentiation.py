"""Time derivatives of sampled signals."""

import numpy as np
import scipy


def derivative(time: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Time derivative at the samples, from a cubic spline through them.

    Its error is of fourth order in the sampling period: at 250 Hz a 20 Hz component comes out
    0.04 % too small, against 4 % by central differences, so that a signal and its derivatives keep
    the same gain.

    Parameters
    ----------
    time : ndarray, shape (n,)
        Instants (s).
    x : ndarray, shape (n,) or (n, c)
        Signal (any unit).

    Returns
    -------
    ndarray, shape of ``x``
        Derivative (unit of ``x`` per s).
    """
    return scipy.interpolate.CubicSpline(time, x)(time, 1)
