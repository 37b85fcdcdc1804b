"""Parts of the intrinsic and the reflex pathway of a parallel-cascade model (Kearney et al. 1997)."""

import numpy as np

from tepsipe.mechanics.impedance_model import simulate_angle
from tepsipe.signals.differentiation import derivative


def rectified_velocity(angle: np.ndarray, rate_hz: float, direction: int) -> np.ndarray:
    """Velocity of an angle in one direction: theta' where it has the sign of ``direction``, else 0.

    Parameters
    ----------
    angle : ndarray, shape (n,)
        theta (rad).
    rate_hz : float
        Sampling rate (Hz).
    direction : {1, -1}
        Sign of the velocity that is kept (-).

    Returns
    -------
    ndarray, shape (n,)
        u (rad/s).
    """
    velocity = derivative(np.arange(angle.size) / rate_hz, angle)
    return np.where(direction * velocity > 0.0, velocity, 0.0)


def delayed(x: np.ndarray, delay_s: float, rate_hz: float) -> np.ndarray:
    """A delayed signal, linear between samples; the first sample is held before the start.

    Parameters
    ----------
    x : ndarray, shape (n, ...)
        Signal (any unit).
    delay_s : float
        Delay (s); negative for a lead, with the last sample held after the end.
    rate_hz : float
        Sampling rate (Hz).

    Returns
    -------
    ndarray, shape of ``x``
        x(t - delay) (unit of ``x``).
    """
    samples = round(delay_s * rate_hz, 6)
    whole = int(np.floor(samples))
    part = samples - whole
    at = np.arange(x.shape[0]) - whole
    held = x[np.clip(at, 0, x.shape[0] - 1)]
    return held if part == 0.0 else (1.0 - part) * held + part * x[np.clip(at - 1, 0, x.shape[0] - 1)]


def lagged(x: np.ndarray, lags: np.ndarray) -> np.ndarray:
    """Regressors of a response to ``x`` (any unit) at ``lags`` (samples), shape (n, lags); ends are held."""
    at = np.arange(x.size)[:, None] - np.asarray(lags)
    return x[np.clip(at, 0, x.size - 1)]


def knot_responses(length_s: float, knot_s: float, rate_hz: float) -> np.ndarray:
    """Piecewise linear basis responses: one per inner knot, 1 at this knot and 0 at all others.

    Parameters
    ----------
    length_s, knot_s : float
        Length, and distance of the knots (s), at most half of the length.
    rate_hz : float
        Sampling rate (Hz).

    Returns
    -------
    ndarray, shape (samples, knots)
        The responses at 0, 1 / rate, ... (-).
    """
    knots = max(2, round(length_s / knot_s))
    time = np.arange(int(knots * knot_s * rate_hz) + 1) / rate_hz
    return np.column_stack(
        [np.interp(time, np.arange(knots + 1) * knot_s, np.eye(knots + 1)[k]) for k in range(1, knots)]
    )


def muscle_response(x: np.ndarray, rate_hz: float, frequency_hz: float, damping: float) -> np.ndarray:
    """Response of the muscle to a signal: second-order low-pass of static gain 1, initially at rest.

    Parameters
    ----------
    x : ndarray, shape (n,)
        Signal (any unit).
    rate_hz, frequency_hz : float
        Sampling rate, and the muscle's natural frequency (Hz).
    damping : float
        zeta (-).

    Returns
    -------
    ndarray, shape (n,)
        w^2 / (s^2 + 2 zeta w s + w^2) x (unit of ``x``).
    """
    w = 2.0 * np.pi * frequency_hz
    return simulate_angle(np.array([1.0 / w**2, 2.0 * damping / w, 1.0]), x, rate_hz)
