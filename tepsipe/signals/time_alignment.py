"""Alignment of markers and force plate to a fraction of a sample, from the motion of the belt.

A trigger aligns two instruments to about one sample, but markers may still be sampled with a
latency. Half a millisecond matters: forces change by a tenth within that time. A belt-fixed marker has
the velocity of the belt, which the treadmill logs, so the delay is measured in every trial.
"""

import numpy as np
import scipy

from tepsipe.errors import InputError
from tepsipe.signals.differentiation import derivative

LONGEST_S = 0.02


def marker_delay(time: np.ndarray, position: np.ndarray, belt_velocity: np.ndarray, what: str) -> float:
    """Time by which the recorded motion of a belt-fixed marker lags behind the logged belt velocity.

    Gauss-Newton on sum (y'(t + delay) - v(t))^2.

    Parameters
    ----------
    time : ndarray, shape (n,)
        Instants of both signals (s).
    position : ndarray, shape (n,)
        Position of a belt-fixed marker along the belt (m), filtered like the velocity.
    belt_velocity : ndarray, shape (n,)
        Logged velocity of the belt (m/s).
    what : str
        Names the trial in messages.

    Returns
    -------
    float
        Delay (s), positive where the marker lags behind.

    Raises
    ------
    InputError
        If the delay is longer than 20 ms, the marker does not follow the belt, or nothing moves.
    """
    delay, moved = 0.0, derivative(time, position)
    if not np.ptp(moved) > 0.0 or not np.ptp(belt_velocity) > 0.0:
        raise InputError(
            f"{what}: expected a marker and a belt that move, found one that stands still: check the "
            "belt-fixed markers, and that the belt was perturbed"
        )
    spline = scipy.interpolate.CubicSpline(time, moved)
    for _ in range(6):
        shifted = np.clip(time + delay, time[0], time[-1])
        left, slope = spline(shifted) - belt_velocity, spline(shifted, 1)
        delay -= float(left @ slope / (slope @ slope))
        if abs(delay) > LONGEST_S:
            break
    left = spline(np.clip(time + delay, time[0], time[-1])) - belt_velocity
    if abs(delay) > LONGEST_S or left @ left > 0.25 * (belt_velocity @ belt_velocity):
        raise InputError(
            f"{what}: expected a marker that follows the belt within {1e3 * LONGEST_S:g} ms, found one that "
            "does not: check the trigger of the motion capture, the direction of the axes, and that the "
            "body does not slip"
        )
    return delay


def advanced(time: np.ndarray, x: np.ndarray, delay_s: float) -> np.ndarray:
    """``x`` advanced by a delay (s), shape (n, ...), at the instants ``time`` (s); ends are held."""
    return scipy.interpolate.CubicSpline(time, x)(np.clip(time + delay_s, time[0], time[-1]))
