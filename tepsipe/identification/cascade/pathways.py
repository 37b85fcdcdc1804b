"""Parts of the intrinsic and the reflex pathway of a parallel-cascade model (Kearney et al. 1997).

Short-range stiffness comes from elastic-plastic elements in parallel (Prandtl, Jenkin), each a spring in
series with a slider: its force follows the angle, but its deflection does not exceed its radius. A relaxing
element (Maxwell) is a spring in series with a damper: its deflection decays.
"""

from functools import lru_cache
from typing import Annotated

import numpy as np
import scipy

from tepsipe.mechanics.impedance_model import simulate_angle


def rectified(velocity: np.ndarray, direction: int, threshold: float) -> np.ndarray:
    """Velocity beyond a threshold in one direction (1 or -1), else 0; all of shape (n,), in rad/s."""
    return np.where(direction * velocity > threshold, velocity - direction * threshold, 0.0)


def stop_deflection(angle: Annotated[np.ndarray, "(n,)", "rad"], radius: float) -> np.ndarray:
    """Deflection of the spring of an elastic-plastic stop element, initially 0.

    angle: theta.
    radius: largest deflection (rad): beyond it the element yields.
    Returns: z (rad): dz = dtheta, limited to |z| <= radius. An element of stiffness w has the torque w z.
    """
    deflection, deflections = 0.0, []
    for step in np.diff(angle, prepend=angle[:1]).tolist():
        deflection += step
        # several times as fast as min and max
        if deflection > radius:
            deflection = radius
        elif deflection < -radius:
            deflection = -radius
        deflections.append(deflection)
    return np.array(deflections)


def relaxing_deflection(angle: np.ndarray, time_s: float, rate_hz: float) -> np.ndarray:
    """Deflection of the spring of a relaxing element, a spring and a damper in series, initially 0.

    angle: theta (rad), linear between samples.
    time_s, rate_hz: time constant of the relaxation (s), and sampling rate (Hz).
    Returns: z (rad): z' = theta' - z / time_s. An element of stiffness w has the torque w z.
    """
    late = 1.0 / (time_s * rate_hz)
    held = -np.expm1(-late) / late
    steps = np.diff(angle, prepend=angle[:1])
    return scipy.signal.lfilter([held], [1.0, -np.exp(-late)], steps)


def delayed(
    x: Annotated[np.ndarray, "(n, ...)"], delay_s: float, rate_hz: float, rows: slice | None = None
) -> np.ndarray:
    """A delayed signal, linear between samples; the first sample is held before the start.

    delay_s: delay (s); negative for a lead, with the last sample held after the end.
    rows: samples that are wanted; all if left out. A view where they are samples of the signal.
    Returns: x(t - delay) (unit of ``x``).
    """
    rows = rows or slice(0, x.shape[0])
    samples = round(delay_s * rate_hz, 6)
    whole = int(np.floor(samples))
    part = samples - whole
    if part == 0.0 and rows.start >= whole and rows.stop - whole <= x.shape[0]:
        return x[rows.start - whole : rows.stop - whole]
    at = np.arange(rows.start, rows.stop) - whole
    held = x[np.clip(at, 0, x.shape[0] - 1)]
    return held if part == 0.0 else (1.0 - part) * held + part * x[np.clip(at - 1, 0, x.shape[0] - 1)]


def lagged(x: np.ndarray, lags: np.ndarray, rows: slice) -> np.ndarray:
    """Regressors of a response to ``x`` at ``lags`` (samples), shape (rows, lags); ends are held."""
    at = np.arange(rows.start, rows.stop)[:, None] - np.asarray(lags)
    return x[np.clip(at, 0, x.size - 1)]


# every pathway of every design asks for them
@lru_cache(maxsize=16)
def knot_responses(
    length_s: float, knot_s: float, rate_hz: float
) -> Annotated[np.ndarray, "(samples, knots)"]:
    """Piecewise linear basis responses: one per inner knot, 1 at this knot and 0 at all others.

    length_s, knot_s: length, and distance of the knots (s), at most half of the length.
    Returns: the responses at 0, 1 / rate, ....
    """
    knots = max(2, round(length_s / knot_s))
    time = np.arange(int(knots * knot_s * rate_hz) + 1) / rate_hz
    return np.column_stack(
        [np.interp(time, np.arange(knots + 1) * knot_s, np.eye(knots + 1)[k]) for k in range(1, knots)]
    )


@lru_cache(maxsize=16)
def laguerre_responses(
    length_s: float, pole_per_s: float, order: int, rate_hz: float
) -> Annotated[np.ndarray, "(samples, order)"]:
    """Orthonormal basis of t^k exp(-pole t), k = 1 ... order: Laguerre functions that begin at 0.

    The first one is the impulse response of a critically damped second-order muscle.

    length_s: time after which all responses are cut.
    Returns: the responses at 0, 1 / rate, ..., with a sum of squares of ``rate_hz`` samples each.
    """
    time = np.arange(int(length_s * rate_hz) + 1) / rate_hz
    late = pole_per_s * time[:, None]
    basis, upper = np.linalg.qr(late ** np.arange(1, order + 1) * np.exp(-late))
    return np.sqrt(rate_hz) * basis * np.sign(np.diag(upper))


def muscle_response(x: np.ndarray, rate_hz: float, frequency_hz: float, damping: float) -> np.ndarray:
    """Response of the muscle to a signal: second-order low-pass of static gain 1, initially at rest.

    rate_hz, frequency_hz: sampling rate, and the muscle's natural frequency.
    damping: zeta.
    Returns: w^2 / (s^2 + 2 zeta w s + w^2) x (unit of ``x``).
    """
    w = 2.0 * np.pi * frequency_hz
    return simulate_angle(np.array([1.0 / w**2, 2.0 * damping / w, 1.0]), x, rate_hz)
