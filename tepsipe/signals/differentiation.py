"""Time derivatives of sampled signals."""

import numpy as np
import scipy


def derivative(time: np.ndarray, x: np.ndarray, degree: int = 3) -> np.ndarray:
    """Time derivative at the samples, from a spline through them.

    The error is of fourth order in the sampling period: at 250 Hz the derivative of a 20 Hz
    component is 0.04 % too small (4 % with central differences), 0.2 % at 30 Hz; with a spline of degree 5,
    of sixth order, 0.02 % at 30 Hz. A signal and its derivatives therefore keep the same gain.

    Parameters
    ----------
    time : ndarray, shape (n,)
        Instants (s).
    x : ndarray, shape (n,) or (n, c)
        Signal.
    degree : {3, 5}
        Degree of the spline.

    Returns
    -------
    ndarray, shape of ``x``
        Derivative (unit of ``x`` per s).
    """
    if degree != 3:
        return scipy.interpolate.make_interp_spline(time, x, degree).derivative()(time)
    spline = scipy.interpolate.CubicSpline(time, x)
    # at its knots the derivative is a coefficient and needs evaluation at the last one only
    return np.concatenate([spline.c[2] + 0.0, spline(time[-1:], 1)])
