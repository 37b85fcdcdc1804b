"""Treadmill models without knowledge of the load on the belt: impulse responses, transfer functions, ripple.

`BeltModel` has the methods of every treadmill model. Impulse responses from belt acceleration to load:
finite least squares, and from spectra.

    L(k) = sum_j h_j a(k - j),    j = -lead ... lag

With lead = 0 the model is causal and can run in real time. A few samples of lead compensate for a velocity
that is logged later than the load, or smoothed.

Discrete transfer functions from belt acceleration to load, fitted to their output error.

    L(k) + f_1 L(k-1) + ... + f_n L(k-n) = b_0 a(k) + b_1 a(k-1) + ... + b_n a(k-n)

hnat2014, the published model of a treadmill's pitch moment, has n = 2 (Hnat & van den Bogert 2014,
J. Biomech. 47, 3758-3761).

Ripple at the orders of the rollers: lines in the spectrum over travelled distance, not over time.

    L(k) = L_model(k) + sum_i [ p_i cos(2 pi n_i x(k)) + q_i sin(2 pi n_i x(k)) ]

Symbols: x distance travelled by the belt (m), n_i order (cycles per metre), p_i, q_i amplitudes. Orders
are identified on the calibration trials, as narrow lines in the spectrum of a model's residual over
distance. Amplitude and phase are tracked on the trial itself, from past samples only, by a ridge
regression with exponential forgetting (memory T), regularised by the amplitude found in the calibration.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Annotated

import numpy as np
import scipy

from tepsipe.errors import InputError
from tepsipe.treadmill.options import RippleOptions
from tepsipe.treadmill.recording import BeltRecording


class BeltModel(ABC):
    """Base of the treadmill models, which predict the belt-induced load (N or N·m)."""

    @property
    def holds_errors(self) -> bool:
        """True if it holds draws of its constants' errors, and residuals of held-out trials."""
        return False

    @property
    def untracked(self) -> "BeltModel | None":
        """The model below one that tracks ripple (N or N·m); None where no ripple is tracked."""
        return None

    @abstractmethod
    def predict(self, recording: BeltRecording) -> np.ndarray:
        """Belt-induced load (N or N·m), shape (n,)."""

    def compensate(
        self, recording: BeltRecording, force: np.ndarray | None = None, friction: np.ndarray | None = None
    ) -> np.ndarray:
        """Measured load less the belt-induced one (N or N·m), shape (n,).

        ``force`` is the true fore-aft force (N), ``friction`` the belt's friction (N) where known already,
        both of shape (n,), for models that need them.
        """
        return recording.load - self.predict(recording)

    def added_per_kg(self, recording: BeltRecording) -> np.ndarray:
        """Friction of another kg on the belt, before the frame's response (N or N·m), shape (n,)."""
        return np.zeros(recording.load.size)

    def frame_acceleration(self, recording: BeltRecording) -> np.ndarray:
        """Acceleration of the frame (m/s²), shape (n,), from a recording of the fore-aft force.

        0 for models that know no frame.
        """
        return np.zeros(recording.load.size)

    def shared_friction(self, other: "BeltModel", recording: BeltRecording) -> np.ndarray | None:
        """Friction of the belt (N), shape (n,), if ``other`` has the same; None without such friction."""
        return None


RIDGE = 1e-7


@dataclass(frozen=True)
class ImpulseResponse(BeltModel):
    """Response of the load to belt acceleration."""

    taps: Annotated[np.ndarray, "(lead + lag + 1,)"]
    """h (unit of the load over m/s²)."""
    lead: int
    """Taps before the present sample (samples)."""
    rate_hz: float
    """Sampling rate for which it holds."""

    @property
    def order(self) -> int:
        """Number of taps."""
        return self.taps.size

    def predict(self, recording: BeltRecording) -> np.ndarray:
        """L (unit of the load), shape (n,)."""
        full = scipy.signal.oaconvolve(recording.acceleration, self.taps)
        return full[self.lead : self.lead + recording.acceleration.size]


def fit_finite_response(recordings: list[BeltRecording], lead_s: float, lag_s: float) -> ImpulseResponse:
    """Finite impulse response by least squares.

    The normal equations are regularised by a very small ridge, because low-pass filtered signals do not
    determine the response far above the cutoff.

    lead_s, lag_s: length of the response towards the future and towards the past.
    """
    rate = recordings[0].rate_hz
    lead, lag = round(lead_s * rate), round(lag_s * rate)
    taps = lead + lag + 1
    samples = sum(int(r.evaluated.sum()) for r in recordings)
    if samples < 10 * taps:
        raise InputError(
            f"{recordings[0].name}: expected at least {10 * taps} samples to fit {taps} taps, found "
            f"{samples}: record longer or "
            "decrease fir_lag_s and fir_lead_s"
        )
    normal, right = np.zeros((taps, taps)), np.zeros(taps)
    for r in recordings:
        padded = np.concatenate([np.zeros(lag), r.acceleration, np.zeros(lead)])
        # row k holds a(k + lead) ... a(k - lag)
        rows = np.lib.stride_tricks.sliding_window_view(padded, taps)[r.evaluated, ::-1]
        normal += rows.T @ rows
        right += rows.T @ r.load[r.evaluated]
    normal[np.diag_indices(taps)] += RIDGE * np.trace(normal) / taps
    return ImpulseResponse(np.linalg.solve(normal, right), lead, rate)


def fit_spectral(recordings: list[BeltRecording], segment_s: float) -> ImpulseResponse:
    """Spectral estimate H1 = S_aL / S_aa as a non-causal compensator.

    segment_s: length of the half-overlapping Hann segments, and of the response.
    Returns: inverse transform of H1, tapered at both ends; half of it lies in the future.
    """
    rate = recordings[0].rate_hz
    samples = 2 * round(0.5 * segment_s * rate)
    s_aa, s_al = 0.0, 0.0
    for r in recordings:
        inside = np.flatnonzero(r.evaluated)
        part = slice(inside[0], inside[-1] + 1)
        options = {"fs": rate, "nperseg": min(samples, part.stop - part.start), "noverlap": samples // 2}
        options |= {"nfft": samples, "detrend": False}
        s_aa = s_aa + scipy.signal.welch(r.acceleration[part], **options)[1]
        s_al = s_al + scipy.signal.csd(r.acceleration[part], r.load[part], **options)[1]
    response = s_al / (s_aa + RIDGE * s_aa.max())
    taps = np.fft.fftshift(np.fft.irfft(response, samples)) * scipy.signal.windows.hann(samples, sym=False)
    return ImpulseResponse(taps, samples // 2, rate)


PUBLISHED_START = 0.001
PUBLISHED_BOUND = 10.0
# of the output-error model: rounds of its start, and evaluations after which the search ends
ROUNDS, MOST_EVALUATIONS = 8, 60


@dataclass(frozen=True)
class DiscreteTransfer(BeltModel):
    """Transfer function from a (m/s²) to L."""

    numerator: Annotated[np.ndarray, "(n + 1,)"]
    """b_0 ... b_n (unit of the load over m/s²)."""
    denominator: Annotated[np.ndarray, "(n + 1,)"]
    """1, f_1 ... f_n."""
    rate_hz: float
    """Sampling rate for which it holds."""
    converged: bool = True
    """Whether the optimisation converged."""

    @property
    def order(self) -> int:
        """Number of poles, n."""
        return self.denominator.size - 1

    def predict(self, recording: BeltRecording) -> np.ndarray:
        """L (unit of the load), shape (n,)."""
        return scipy.signal.lfilter(self.numerator, self.denominator, recording.acceleration)


def fit_hnat2014(recordings: list[BeltRecording], most_evaluations: int) -> DiscreteTransfer:
    """hnat2014, the published procedure: output error over five coefficients from 0.001 within +-10.

    most_evaluations: evaluations of the model after which the search ends.
    """

    def coefficients(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return x[2:], np.concatenate([[1.0], x[:2]])

    def error(x: np.ndarray) -> np.ndarray:
        b, f = coefficients(x)
        residual = [(scipy.signal.lfilter(b, f, r.acceleration) - r.load)[r.evaluated] for r in recordings]
        return np.clip(np.nan_to_num(np.concatenate(residual), nan=1e6), -1e6, 1e6)

    solution = scipy.optimize.least_squares(
        error,
        np.full(5, PUBLISHED_START),
        bounds=(-PUBLISHED_BOUND, PUBLISHED_BOUND),
        max_nfev=most_evaluations,
    )
    return DiscreteTransfer(*coefficients(solution.x), recordings[0].rate_hz, bool(solution.success))


def fit_discrete_output_error(recordings: list[BeltRecording], order: int) -> DiscreteTransfer:
    """Output-error model of any order, by Gauss-Newton from the Steiglitz-McBride solution."""
    start = _steiglitz_mcbride(recordings, order)
    scale = np.maximum(np.abs(start), 1e-3 * np.abs(start).max())

    def split(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return x[: order + 1], np.concatenate([[1.0], x[order + 1 :]])

    def error(z: np.ndarray) -> np.ndarray:
        b, f = split(z * scale)
        if np.abs(np.roots(f)).max(initial=0.0) >= 1.0:
            return np.concatenate([np.full(int(r.evaluated.sum()), 1e6) for r in recordings])
        return np.concatenate(
            [(scipy.signal.lfilter(b, f, r.acceleration) - r.load)[r.evaluated] for r in recordings]
        )

    def jacobian(z: np.ndarray) -> np.ndarray:
        b, f = split(z * scale)
        blocks = []
        for r in recordings:
            by_input = scipy.signal.lfilter([1.0], f, r.acceleration)
            by_output = -scipy.signal.lfilter([1.0], f, scipy.signal.lfilter(b, f, r.acceleration))
            columns = [_delayed(by_input, k) for k in range(order + 1)]
            columns += [_delayed(by_output, k) for k in range(1, order + 1)]
            blocks.append(np.column_stack(columns)[r.evaluated])
        return np.concatenate(blocks) * scale

    solution = scipy.optimize.least_squares(
        error, start / scale, jac=jacobian, ftol=1e-6, max_nfev=MOST_EVALUATIONS
    )
    b, f = split(solution.x * scale)
    if np.abs(np.roots(f)).max(initial=0.0) >= 1.0:
        raise InputError(
            f"{recordings[0].name}: expected a stable output-error model of order {order}, found none: "
            "decrease output_error_order"
        )
    return DiscreteTransfer(b, f, recordings[0].rate_hz, bool(solution.success))


def _steiglitz_mcbride(recordings: list[BeltRecording], order: int) -> np.ndarray:
    """b_0 ... b_n, f_1 ... f_n: least squares on signals filtered by the last denominator, repeated."""
    f = np.concatenate([[1.0], np.zeros(order)])
    best = None
    for _ in range(ROUNDS):
        rows, right = [], []
        for r in recordings:
            a, load = (scipy.signal.lfilter([1.0], f, x) for x in (r.acceleration, r.load))
            columns = [_delayed(a, k) for k in range(order + 1)]
            columns += [-_delayed(load, k) for k in range(1, order + 1)]
            rows.append(np.column_stack(columns)[r.evaluated])
            right.append(load[r.evaluated])
        x = np.linalg.lstsq(np.concatenate(rows), np.concatenate(right), rcond=1e-10)[0]
        f = _stabilised(np.concatenate([[1.0], x[order + 1 :]]))
        b = x[: order + 1]
        errors = [(scipy.signal.lfilter(b, f, r.acceleration) - r.load)[r.evaluated] for r in recordings]
        cost = sum(float(e @ e) for e in errors)
        if best is None or cost < best[0]:
            best = (cost, np.concatenate([b, f[1:]]))
    return best[1]


def _stabilised(f: np.ndarray) -> np.ndarray:
    """Denominator with its poles reflected into the unit circle."""
    poles = np.roots(f)
    size = np.abs(poles)
    poles = np.where(size > 1.0, poles / np.maximum(size, 1.0) ** 2, poles)
    return np.real(np.poly(np.where(np.abs(poles) > 0.995, 0.995 * poles / np.abs(poles), poles)))


def _delayed(x: np.ndarray, samples: int) -> np.ndarray:
    """``x`` delayed by a number of samples, with zeros before its start."""
    return x if samples == 0 else np.concatenate([np.zeros(samples), x[:-samples]])


BLOCK_S = 0.1
MEDIAN_LINES = 101
SHORTEST_M = 10.0


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
