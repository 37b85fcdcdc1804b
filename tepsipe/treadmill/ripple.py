"""Ripple at the orders of the rollers: lines in the spectrum over travelled distance, not over time.

    L(k) = L_model(k) + sum_i [ p_i cos(2 pi n_i x(k)) + q_i sin(2 pi n_i x(k)) ]

Symbols: x distance travelled by the belt (m), n_i order (cycles per metre), p_i, q_i amplitudes. Orders
are identified on the calibration trials, as narrow lines in the spectrum of a model's residual over
distance. Amplitude and phase are tracked on the trial itself, from past samples only, by a ridge
regression with exponential forgetting (memory T), regularised by the amplitude found in the calibration.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
import scipy
from annotated_types import Ge, Gt

from tepsipe.quantities import Time
from tepsipe.treadmill.belt_model import BeltModel
from tepsipe.treadmill.recording import BeltRecording

BLOCK_S = 0.1
MEDIAN_LINES = 101
SHORTEST_M = 10.0


@dataclass(frozen=True)
class RippleOptions:
    """Options of the detection and tracking of ripple."""

    most_orders: Annotated[int, Ge(0)] = 12
    """Largest number of tracked lines."""
    line_to_floor: Annotated[float, Gt(1)] = 30.0
    """Power of a line over the running median of the spectrum around it."""
    # a shorter memory follows faster, but mistakes more of the signal near the ripple for ripple
    memory_s: Time = 20.0  # T
    """Memory of the tracked amplitudes."""


@dataclass(frozen=True)
class RippleTracker(BeltModel):
    """A model and the ripple that is tracked in its residual."""

    base: object
    """Model of the load due to acceleration."""
    orders_per_m: Annotated[np.ndarray, "(m,)"]
    amplitudes: Annotated[np.ndarray, "(m,)"]
    """Amplitudes found in the calibration (unit of the load)."""
    noise: float
    """Standard deviation of the residual in the calibration (unit of the load)."""
    memory_s: float
    rate_hz: float
    """Sampling rate for which it holds."""

    @property
    def untracked(self) -> BeltModel:
        """The model of the load due to acceleration (N or N·m)."""
        return self.base

    @property
    def order(self) -> int:
        """Number of tracked orders."""
        return self.orders_per_m.size

    def predict(self, recording: BeltRecording) -> np.ndarray:
        """L (unit of the load), shape (n,); its ripple is estimated from the load before each block."""
        predicted = self.base.predict(recording)
        if not self.order:
            return predicted
        return predicted + self._track(recording, recording.load - predicted)

    def _track(self, recording: BeltRecording, residual: np.ndarray) -> np.ndarray:
        phi = _waves(recording, self.orders_per_m)
        block = max(1, round(BLOCK_S * self.rate_hz))
        blocks = -(-residual.size // block)
        pad = blocks * block - residual.size
        phi = np.pad(phi, ((0, pad), (0, 0))).reshape(blocks, block, -1)
        y = np.pad(residual, (0, pad)).reshape(blocks, block)
        forget = np.exp(-block / (self.memory_s * self.rate_hz))
        normal = np.einsum("kbi,kbj->kij", phi, phi)
        right = np.einsum("kbi,kb->ki", phi, y)
        ridge = np.diag(self.noise**2 / np.repeat(self.amplitudes**2, 2))
        known_normal, known_right = np.zeros_like(normal), np.zeros_like(right)
        for k in range(1, blocks):
            known_normal[k] = forget * (known_normal[k - 1] + normal[k - 1])
            known_right[k] = forget * (known_right[k - 1] + right[k - 1])
        amplitudes = np.linalg.solve(known_normal + ridge, known_right[..., None])
        return (phi @ amplitudes).reshape(-1)[: residual.size]


def fit_ripple_tracker(recordings: list[BeltRecording], base, options: RippleOptions) -> RippleTracker:
    """Find the orders of the ripple in the residual of a model.

    base: fitted model of the load due to acceleration.
    options: threshold of a line and memory of its tracking.
    Returns: strongest lines first; without orders if there is no line or the belt does not travel.
    """
    rate = recordings[0].rate_hz
    leftover = [r.load - base.predict(r) for r in recordings]
    lines: list[tuple[float, float]] = []
    for r, residual in zip(recordings, leftover, strict=True):
        lines += _lines(r, residual, options.line_to_floor)
    orders: list[float] = []
    for _, order in sorted(lines, reverse=True):
        if all(abs(order - other) > 0.03 for other in orders) and len(orders) < options.most_orders:
            orders.append(order)
    separate = np.array(orders)
    noise = float(np.sqrt(np.mean(_evaluated(recordings, leftover) ** 2)))
    # phases differ between recordings: amplitudes are averaged, not waves
    amplitudes = [
        np.linalg.lstsq(_waves(r, separate)[r.evaluated], residual[r.evaluated], rcond=1e-9)[0].reshape(-1, 2)
        for r, residual in zip(recordings, leftover, strict=True)
    ]
    typical = np.mean([np.hypot(*parts.T) for parts in amplitudes], axis=0)
    return RippleTracker(base, separate, typical, noise, options.memory_s, rate)


def _evaluated(recordings: list[BeltRecording], signals: list[np.ndarray]) -> np.ndarray:
    return np.concatenate([x[r.evaluated] for r, x in zip(recordings, signals, strict=True)])


def _waves(recording: BeltRecording, orders_per_m: np.ndarray) -> np.ndarray:
    """Cosine and sine of every order over travelled distance, filtered like the load, shape (n, 2 m)."""
    phase = 2.0 * np.pi * np.outer(recording.position, orders_per_m)
    waves = np.stack([np.cos(phase), np.sin(phase)], axis=2).reshape(phase.shape[0], -1)
    return recording.through_lowpass(waves)


@dataclass(frozen=True)
class DistanceSpectrum:
    """Spectrum of a load over travelled distance."""

    order_per_m: Annotated[np.ndarray, "(k,)"]
    """Cycles per metre."""
    power: Annotated[np.ndarray, "(k,)"]
    """Squared amplitude of a sine of that order (unit of the load, squared)."""
    floor: Annotated[np.ndarray, "(k,)"]
    """Running median of the power."""


def spectrum_over_distance(recording: BeltRecording, load: np.ndarray) -> DistanceSpectrum | None:
    """Spectrum of ``load`` (unit of the load), shape (n,), over distance; None if the belt hardly travels."""
    inside = np.flatnonzero(recording.evaluated)
    part = slice(inside[0], inside[-1] + 1)
    x, y = recording.position[part], load[part]
    travelled = np.maximum.accumulate(x)
    forwards = np.concatenate([[True], np.diff(travelled) > 0.0])
    samples = int(forwards.sum())
    if travelled[-1] - travelled[0] < SHORTEST_M or samples < 4 * MEDIAN_LINES:
        return None
    step = (travelled[-1] - travelled[0]) / samples
    grid = travelled[0] + step * np.arange(samples)
    over_distance = np.interp(grid, travelled[forwards], y[forwards])
    tapered = (over_distance - over_distance.mean()) * np.hanning(samples)
    power = (4.0 / samples * np.abs(np.fft.rfft(tapered))) ** 2
    return DistanceSpectrum(
        np.fft.rfftfreq(samples, step),
        power,
        scipy.ndimage.median_filter(power, MEDIAN_LINES, mode="reflect"),
    )


def _lines(recording: BeltRecording, residual: np.ndarray, line_to_floor: float) -> list[tuple[float, float]]:
    """(power, order in 1/m) of the narrow lines in the spectrum of ``residual`` over distance."""
    spectrum = spectrum_over_distance(recording, residual)
    if spectrum is None:
        return []
    power = spectrum.power
    peak = np.concatenate([[False], (power[1:-1] > power[:-2]) & (power[1:-1] >= power[2:]), [False]])
    wanted = np.flatnonzero(peak & (power > line_to_floor * spectrum.floor))
    return [(float(power[k]), _between(spectrum.order_per_m, power, k)) for k in wanted]


def _between(order: np.ndarray, power: np.ndarray, k: int) -> float:
    """Order of a line between two frequencies of the spectrum, by a parabola through the logarithm."""
    left, middle, right = np.log(power[k - 1 : k + 2])
    return float(order[k] + 0.5 * (left - right) / (left - 2.0 * middle + right) * (order[1] - order[0]))
