"""Electromyograms from the amplifier to their envelope, and faulty channels (thesis section 3-2).

Symbols: x raw, b band-passed, r rectified, e envelope (all uV).

    b = band-pass(x),   r = |b|,   e = low-pass(r)

Each filter is a fourth-order zero-lag Butterworth filter; orders are counted as in `tepsipe.signals.filters`.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated

import numpy as np
import scipy

from tepsipe.errors import InputError
from tepsipe.quantities import Band, FilterOrder, Frequency, Thesis
from tepsipe.signals.filters import butterworth_bandpass, butterworth_lowpass, notch

# ---- thresholds of `channel_fault`: a relaxed muscle shows 1 to 3 uV, the amplifier alone 0.5 to 1 uV
# band in which a channel is evaluated (Hz), and length of the windows over which medians are taken (s)
EVALUATED_BAND_HZ = (20.0, 450.0)
EVALUATED_WINDOW_S = 1.0
# samples count as clipped in runs of at least this length, within this fraction of the range of a limit,
# three steps of 16 bits. A single sample does not: many programs write the largest value as the limit
CLIPPED_RUN = 3
LIMIT_TOLERANCE = 5e-5
# where the limits are closer together than this (uV), a channel that stays at a limit is flat, not clipped
CLOSE_LIMITS_UV = 10.0
# samples also count as clipped where the channel stays at its own largest or smallest value for this long (s)
HELD_S = 0.010
# largest fraction of clipped samples; ten short artefacts in a minute stay below it
CLIPPED_SHARE = 0.01
# below this root mean square (uV) a window is flat: half the noise of an amplifier with shorted inputs
FLAT_UV = 0.25
# largest fraction of flat windows
FLAT_SHARE = 0.05
# mains hum is a fault above this root mean square (uV) and above this fraction of the channel's power
HUM_UV = 10.0
HUM_SHARE = 0.8
# half-width of the bands around the mains frequency and its harmonics that count as hum (Hz)
HUM_WIDTH_HZ = 2.0
# root mean square (uV) that surface electromyograms do not exceed for half of a trial
NOISE_UV = 1500.0


@dataclass(frozen=True)
class EmgOptions:
    """Options of the processing; the defaults follow the thesis."""

    band_hz: Annotated[Band, Thesis("3-2")] = (20.0, 300.0)
    """Butterworth band-pass."""
    band_order: Annotated[FilterOrder, Thesis("3-2")] = 4
    """Order of both passes together, at each edge."""
    envelope_cutoff_hz: Annotated[Frequency, Thesis("3-2")] = 6.0
    """Butterworth low-pass of the rectified signal; the envelope is only shown."""
    envelope_order: Annotated[FilterOrder, Thesis("3-2")] = 4
    """Order of both passes together."""
    mains_hz: Frequency | None = None
    """Mains frequency to remove, with its harmonics; null removes nothing."""
    notch_width_hz: Frequency = 2.0
    """Width of each notch, which rings for about 1 / width before and after a burst."""


@dataclass(frozen=True)
class ProcessedEmg:
    """The three stages of thesis section 3-2."""

    band_passed: np.ndarray
    """b (uV)."""
    rate_hz: float
    options: EmgOptions
    """Sampling rate, and how it was processed."""

    @property
    def rectified(self) -> np.ndarray:
        """Magnitude r (uV)."""
        return np.abs(self.band_passed)

    @cached_property
    def envelope(self) -> np.ndarray:
        """Envelope e (uV), which the 6 Hz low-pass smears over more than 60 ms to either side."""
        options = self.options
        return butterworth_lowpass(
            self.rectified, self.rate_hz, options.envelope_cutoff_hz, options.envelope_order
        )


def process_emg(raw: np.ndarray, rate_hz: float, options: EmgOptions) -> ProcessedEmg:
    """Band-pass, rectify and smooth electromyograms, thesis section 3-2.

    raw: x (uV), without NaN.
    """
    x = np.asarray(raw, dtype=float)
    if options.mains_hz is not None:
        for frequency in _harmonics(options.mains_hz, options.band_hz[1]):
            x = notch(x, rate_hz, frequency, options.notch_width_hz)
    band_passed = butterworth_bandpass(x, rate_hz, options.band_hz, options.band_order)
    return ProcessedEmg(band_passed, rate_hz, options)


def channel_fault(
    raw: np.ndarray, limits: Annotated[np.ndarray, "(2,)"], rate_hz: float, mains_hz: float = 50.0
) -> str | None:
    """Reason why a whole channel is unusable: NaN, clipping, a dead input, mains hum or noise.

    The thresholds are the constants at the head of this module. Offset and slow drift are ignored. Levels
    are medians over windows of one second, so bursts and artefacts do not affect them.

    raw: x (uV), as recorded.
    limits: lowest and highest value that the recorder can hold (uV).
    rate_hz, mains_hz: sampling rate and mains frequency.
    Returns: one sentence, without the channel's name, or None for a channel without fault.
    """
    x = np.asarray(raw, dtype=float)
    window = round(EVALUATED_WINDOW_S * rate_hz)
    if x.size < window:
        raise InputError(
            f"channel to evaluate: expected at least {EVALUATED_WINDOW_S:g} s, found "
            f"{x.size / rate_hz:.3g} s: record longer"
        )
    bad = np.flatnonzero(~np.isfinite(x))
    if bad.size:
        return (
            f"expected a number in every sample, found none in {bad.size}, the first at "
            f"{bad[0] / rate_hz:.3f} s: export the channel again"
        )
    at_limits, held = _at_limits(x, limits), _held(x, rate_hz)
    if at_limits.mean() > CLIPPED_SHARE:
        return (
            f"expected at most {100 * CLIPPED_SHARE:g} % of the samples at the recorder's limits "
            f"({limits[0]:.4g} and {limits[1]:.4g} uV), found {100 * at_limits.mean():.3g} %: the amplifier "
            "was saturated, reconnect the electrodes or lower the gain"
        )
    total, hum = _levels(x, rate_hz, mains_hz, window)
    flat = float((total < FLAT_UV).mean())
    if flat > FLAT_SHARE:
        return (
            f"expected at least {FLAT_UV:g} uV of signal and noise, found less in {100 * flat:.3g} % of the "
            "time: the channel is flat, check that its electrodes and the amplifier's input were connected"
        )
    if held.mean() > CLIPPED_SHARE:
        return (
            f"expected no plateaus at the extremes, found {100 * held.mean():.3g} % of the samples held at "
            f"{x.min():.4g} or {x.max():.4g} uV: the amplifier was saturated, reconnect the electrodes or "
            "lower the gain"
        )
    level, hum_level = float(np.median(total)), float(np.median(hum))
    share = float(np.median((hum / total) ** 2))
    if hum_level > HUM_UV and share > HUM_SHARE:
        return (
            f"expected at most {100 * HUM_SHARE:g} % of the power from the mains at {mains_hz:g} Hz, found "
            f"{100 * share:.3g} % ({hum_level:.3g} uV): an electrode was disconnected, reconnect it"
        )
    if level > NOISE_UV:
        return (
            f"expected a median root mean square of at most {NOISE_UV:g} uV, found {level:.4g} uV, more "
            "than a muscle generates: check the channel's unit and its electrodes"
        )
    return None


def clipped_perturbations(
    raw: np.ndarray,
    limits: Annotated[np.ndarray, "(2,)"],
    rate_hz: float,
    onsets_s: Annotated[np.ndarray, "(events,)"],
    before_s: float,
    after_s: float,
    start_s: float = 0.0,
) -> Annotated[np.ndarray, "(events,)"]:
    """Perturbations in which a channel was clipped for at least three samples.

    raw: x (uV), as recorded.
    limits: lowest and highest value that the recorder can hold (uV).
    onsets_s: instants of the perturbations.
    before_s, after_s: window around each of them.
    start_s: instant of the first sample.
    Returns: true where samples of the window are clipped.
    """
    x = np.asarray(raw, dtype=float)
    at = start_s + np.flatnonzero(_at_limits(x, limits) | _held(x, rate_hz)) / rate_hz
    onsets = np.asarray(onsets_s, dtype=float)[:, None]
    return ((at >= onsets - before_s) & (at <= onsets + after_s)).any(axis=1)


def _at_limits(x: np.ndarray, limits: np.ndarray) -> np.ndarray:
    """Samples at the recorder's limits, shape (n,)."""
    low, high = limits
    if high - low < CLOSE_LIMITS_UV:
        return np.zeros(x.size, dtype=bool)
    tolerance = LIMIT_TOLERANCE * (high - low)
    return _runs(x <= low + tolerance, CLIPPED_RUN) | _runs(x >= high - tolerance, CLIPPED_RUN)


def _held(x: np.ndarray, rate_hz: float) -> np.ndarray:
    """Samples of long runs at the channel's own extremes, shape (n,), where an amplifier saturates."""
    run = max(2, round(HELD_S * rate_hz))
    return _runs(x == x.max(), run) | _runs(x == x.min(), run)


def _runs(marked: np.ndarray, length: int) -> np.ndarray:
    """Boolean array without runs of True that are shorter than ``length`` samples, shape (n,)."""
    if np.count_nonzero(marked) < length:  # as in every good recording
        return np.zeros_like(marked)
    return scipy.ndimage.binary_opening(marked, np.ones(length, dtype=bool))


def _levels(x: np.ndarray, rate_hz: float, mains_hz: float, window: int) -> tuple[np.ndarray, np.ndarray]:
    """Root mean square of everything and of the hum in the evaluated band (uV), each of shape (windows,)."""
    frequency, _, density = scipy.signal.spectrogram(
        x, rate_hz, window="hann", nperseg=window, noverlap=0, detrend="constant"
    )
    power = density * (frequency[1] - frequency[0])
    low, high = EVALUATED_BAND_HZ
    evaluated = (frequency >= low) & (frequency <= min(high, 0.45 * rate_hz))
    mains = np.array(_harmonics(mains_hz, 0.5 * rate_hz))
    near = np.abs(frequency[:, None] - mains).min(axis=1, initial=np.inf) <= HUM_WIDTH_HZ
    return np.sqrt(power[evaluated].sum(axis=0)), np.sqrt(power[evaluated & near].sum(axis=0))


def _harmonics(mains_hz: float, below_hz: float) -> list[float]:
    """The mains frequency and its multiples below a frequency (Hz)."""
    return [k * mains_hz for k in range(1, int(np.ceil(below_hz / mains_hz)))]
