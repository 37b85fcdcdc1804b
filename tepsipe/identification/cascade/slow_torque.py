"""Slow torque of a person: the part of a joint's torque that does not respond to the imposed movement.

The torque that no model of the joint explains is a slow voluntary torque b and faster remains w:

    e[n] = b[n] + w[n],    b[n + 1] = phi b[n] + v[n],    phi = exp(-2 pi corner / rate)

with white v and w. The one-step error of the steady-state Kalman filter (its innovation) is white,

    (1 - phi z^-1) e / (1 - rho z^-1),    rho = exp(-2 pi sqrt(corner^2 + crossover^2) / rate)

so this filter of torque and regressors turns least squares into generalised least squares; below the
crossover the slow torque exceeds the remains. Corner and crossover maximise Whittle's likelihood of the
residual of a first fit (periodogram up to ``BAND_HZ``). The prediction of b for the time t + horizon from
residuals up to t is phi^horizon times the filter's estimate; it is causal in the torque.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
import scipy

# highest frequency used to estimate the slow torque (Hz); tried values of corner and crossover
BAND_HZ = 5.0
CORNERS_HZ = np.geomspace(0.02, 2.0, 13)
CROSSOVERS_HZ = np.concatenate([[0.0], np.geomspace(0.05, BAND_HZ, 13)])


@dataclass(frozen=True)
class SlowModel:
    """Spectrum of the slow torque relative to the rest of the residual."""

    corner_hz: float
    """Frequency (Hz) below which the spectrum of the slow torque is flat."""
    crossover_hz: float
    """Frequency (Hz) at which the slow torque falls below the remains, were its corner 0; 0 for none."""

    def poles(self, rate_hz: float) -> tuple[float, float]:
        """Constants phi and rho at a sampling rate (Hz)."""
        return tuple(
            float(np.exp(-2.0 * np.pi * f / rate_hz))
            for f in (self.corner_hz, np.hypot(self.corner_hz, self.crossover_hz))
        )

    def whiten(self, x: np.ndarray, rate_hz: float) -> np.ndarray:
        """Innovation of signals (their unit) along axis 0; the first sample is held before the start."""
        if self.crossover_hz == 0.0:
            return x
        phi, rho = self.poles(rate_hz)
        state = (rho - phi) / (1.0 - rho) * x[:1]
        return scipy.signal.lfilter([1.0, -phi], [1.0, -rho], x, axis=0, zi=state)[0]

    def predict(self, residual: np.ndarray, rate_hz: float, horizon: int) -> np.ndarray:
        """Slow torque from the residual (same unit) at least ``horizon`` samples before, 0 at the start."""
        phi, rho = self.poles(rate_hz)
        filtered = scipy.signal.lfilter([1.0 - rho / phi], [1.0, -rho], residual)
        held = np.concatenate([np.zeros(horizon), filtered[: residual.size - horizon]])
        return phi**horizon * held


def estimate_slow_model(residual: Annotated[np.ndarray, "(n,)", "N·m"], rate_hz: float) -> SlowModel:
    """Corner and crossover of the slow torque by Whittle's likelihood.

    residual: torque that a first model does not explain.
    Returns: its frequencies, from a fixed grid.
    """
    window = np.hanning(residual.size)
    power = np.abs(np.fft.rfft(window * (residual - residual.mean()))) ** 2
    frequency = np.fft.rfftfreq(residual.size, 1.0 / rate_hz)
    used = (frequency >= 1.5 * rate_hz / residual.size) & (frequency <= BAND_HZ)
    power, frequency = power[used], frequency[used]
    if not power.size or not power.all():
        return SlowModel(float(CORNERS_HZ[0]), 0.0)
    corner, crossover = (x.ravel() for x in np.meshgrid(CORNERS_HZ, CROSSOVERS_HZ, indexing="ij"))
    below = frequency**2 + corner[:, None] ** 2
    shape = (below + crossover[:, None] ** 2) / below
    # the level with the largest likelihood for the shape
    cost = np.log(shape).mean(axis=1) + np.log((power / shape).mean(axis=1))
    best = int(np.argmin(cost))
    return SlowModel(float(corner[best]), float(crossover[best]))
