"""Fixed-step integration of the rigs' equations of motion.

Plain floats and tuples: for a handful of states this is several times faster than arrays,
and every run gives the same bits.
"""

from collections.abc import Callable

import numpy as np

State = tuple[float, ...]


def integrate(
    derivative: Callable[[float, State], State],
    initial: State,
    duration_s: float,
    rate_hz: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Integrate with the classical fourth-order Runge-Kutta rule.

    Parameters
    ----------
    derivative : callable
        ``derivative(t, state)`` returns the time derivative of every state (unit of the state per s).
    initial : tuple of float
        State at t = 0.
    duration_s : float
        Length of the run (s).
    rate_hz : float
        Steps per second (Hz).

    Returns
    -------
    time : ndarray, shape (n,)
        Grid 0, 1/rate, 2/rate, ... (s), the last point at or just after ``duration_s``.
    states : ndarray, shape (n, len(initial))
        One row per grid point (units of the states).

    Raises
    ------
    FloatingPointError
        If the run diverges, that is a state is no longer finite.
    """
    steps = int(np.ceil(duration_s * rate_hz))
    h = 1.0 / rate_hz
    states = np.empty((steps + 1, len(initial)))
    x = tuple(float(value) for value in initial)
    states[0] = x
    for k in range(steps):
        x = runge_kutta_step(derivative, k * h, x, h)
        states[k + 1] = x
    if not np.isfinite(states[-1]).all():
        raise FloatingPointError("the integration of the rig diverged: check the rig's constants")
    return np.arange(steps + 1) * h, states


def runge_kutta_step(derivative: Callable[[float, State], State], t: float, x: State, h: float) -> State:
    """State a step ``h`` (s) after the state ``x`` at ``t`` (s), by the classical fourth-order rule.

    ``derivative`` is as for `integrate` (unit of the state per s).
    """
    half = 0.5 * h
    sixth = h / 6.0
    k1 = derivative(t, x)
    k2 = derivative(t + half, tuple([a + half * b for a, b in zip(x, k1, strict=True)]))
    k3 = derivative(t + half, tuple([a + half * b for a, b in zip(x, k2, strict=True)]))
    k4 = derivative(t + h, tuple([a + h * b for a, b in zip(x, k3, strict=True)]))
    return tuple(
        [a + sixth * (b + 2.0 * (c + d) + e) for a, b, c, d, e in zip(x, k1, k2, k3, k4, strict=True)]
    )
