"""Zero-lag (forward-backward) filters (thesis section 3-1: fourth-order Butterworth).

The order counts both passes together, separately at each edge of a band: a fourth-order zero-lag
band-pass is a second-order high-pass and a second-order low-pass, each applied twice.
"""

from dataclasses import dataclass, replace
from functools import cache
from typing import Annotated

import numpy as np
import scipy

from tepsipe.arguments import checked, samples
from tepsipe.errors import InputError
from tepsipe.signals.array_types import Samples

# largest cutoff of `Lowpass.within` over the sampling rate: up to there signals that were resampled are
# complete (`tepsipe.signals.resampling.resample`), as are those of the cameras
WIDEST = 0.3
# smallest cutoff over the sampling rate, far above where the design becomes singular
LOWEST = 1e-6


def lowpass(
    x: "Samples", rate_hz: float, *, cutoff_hz: float = 20.0, order: int = 4, zero_lag: bool = True
) -> np.ndarray:
    """Butterworth low-pass (thesis section 3-1): filter all signals of a trial alike.

    Parameters
    ----------
    x : array_like or Signal, shape (n,) or (n, c)
        Signal.
    rate_hz : float
        Sampling rate (Hz).
    cutoff_hz : float
        Cutoff frequency (Hz).
    order : int
        Order, of both passes together where there are two.
    zero_lag : bool
        Forwards and backwards, without phase shift, or forwards only, as in real time.

    Returns
    -------
    ndarray, shape of ``x``
        Filtered signal (unit of ``x``).

    Raises
    ------
    InputError
        If the signal cannot be used, or the cutoff does not lie between 0 and half the rate.

    Examples
    --------
    >>> from tepsipe import load_example, lowpass
    >>> dummy = load_example("dummy")
    >>> smooth = lowpass(dummy.angle, 250.0, cutoff_hz=20.0)
    >>> smooth.shape == dummy.angle.shape
    True
    """
    rate_hz, cutoff_hz, order, zero_lag = checked(
        rate_hz=rate_hz, cutoff_hz=cutoff_hz, order=order, zero_lag=zero_lag
    )
    values = samples(x, None, "x", shape=None)
    return Lowpass(cutoff_hz, order, zero_lag)(values, rate_hz)


def butterworth_lowpass(
    x: Annotated[np.ndarray, "(..., n, ...)"], rate_hz: float, cutoff_hz: float, order: int = 4, axis: int = 0
) -> np.ndarray:
    """Filter with a Butterworth low-pass run forwards and backwards (no phase shift).

    ``order`` counts both passes, as the thesis and most of the field do: a fourth-order
    zero-lag filter is a second-order one applied twice, and its gain at the cutoff is 1/2.

    x: signal sampled along ``axis``.
    rate_hz, cutoff_hz: sampling rate and cutoff frequency.
    order: order of the two passes together, even.
    axis: time axis.
    Returns: filtered signal (unit of ``x``).
    """
    _refuse_cutoff(cutoff_hz, rate_hz)
    _refuse_odd(order)
    sections = _designed(order // 2, cutoff_hz, rate_hz)
    return _both_ways(sections, x, rate_hz, cutoff_hz, axis)


def butterworth_bandpass(
    x: Annotated[np.ndarray, "(n, ...)"], rate_hz: float, band_hz: tuple[float, float], order: int = 4
) -> np.ndarray:
    """Filter with a Butterworth band-pass run forwards and backwards (no phase shift).

    ``order`` counts both passes at one edge. The band-pass has the roll-off of the low-pass of the
    same order at each edge; its gain at both edges is 1/2.

    x: Signal.
    band_hz: lower and upper edge.
    order: order of the two passes together at each edge, even.
    Returns: filtered signal (unit of ``x``).
    """
    low, high = band_hz
    if not 0.0 < low < high < 0.5 * rate_hz:
        raise InputError(
            "band-pass: expected edges that rise between 0 and half the sampling rate "
            f"({0.5 * rate_hz:g} Hz), found {low:g} Hz and {high:g} Hz: change band_hz"
        )
    _refuse_odd(order)
    sections = _designed(order // 2, (low, high), rate_hz, "bandpass")
    return _both_ways(sections, x, rate_hz, low, axis=0)


def notch(
    x: Annotated[np.ndarray, "(n, ...)"], rate_hz: float, frequency_hz: float, width_hz: float
) -> np.ndarray:
    """Remove one frequency by a second-order notch run forwards and backwards (no phase shift).

    A notch rings for about 1 / width before and after a transient, so a burst leaks into the time
    before it.

    x: Signal.
    rate_hz, frequency_hz, width_hz: sampling rate, frequency that is removed, and width of the notch (Hz),
    at whose edges the gain is 1/2.
    Returns: filtered signal (unit of ``x``).
    """
    if not 0.0 < 0.5 * width_hz < frequency_hz < 0.5 * (rate_hz - width_hz):
        raise InputError(
            f"notch: expected a frequency between 0 and half the sampling rate ({0.5 * rate_hz:g} Hz), found "
            f"{frequency_hz:g} Hz with a width of {width_hz:g} Hz: change mains_hz or notch_width_hz"
        )
    sections = scipy.signal.tf2sos(*scipy.signal.iirnotch(frequency_hz, frequency_hz / width_hz, fs=rate_hz))
    return _both_ways(sections, x, rate_hz, width_hz, axis=0)


@cache
def _designed(
    order: int, edges_hz: float | tuple[float, float], rate_hz: float, kind: str = "lowpass"
) -> np.ndarray:
    """Second-order sections of a Butterworth filter, cached because design takes as long as filtering.

    Do not modify them: all filters of this design share them.
    """
    return scipy.signal.butter(order, edges_hz, btype=kind, fs=rate_hz, output="sos")


def _refuse_cutoff(cutoff_hz: float, rate_hz: float) -> None:
    """Refuse a cutoff that no digital filter has, or whose design is singular."""
    if not 0.0 < cutoff_hz < 0.5 * rate_hz:
        raise InputError(
            f"low-pass: expected a cutoff between 0 and half the sampling rate ({0.5 * rate_hz:g} Hz), "
            f"found {cutoff_hz:g} Hz: change the cutoff"
        )
    if cutoff_hz < LOWEST * rate_hz:
        raise InputError(
            f"low-pass: expected a cutoff of at least {LOWEST * rate_hz:g} Hz for samples at {rate_hz:g} Hz, "
            f"found {cutoff_hz:g} Hz: raise the cutoff"
        )


def _refuse_odd(order: int) -> None:
    """Refuse an order that two equal passes cannot have."""
    if order < 2 or order % 2:
        raise InputError(
            f"zero-lag filter: expected an even order, for two equal passes, found {order}: change the order"
        )


def _both_ways(
    sections: np.ndarray, x: np.ndarray, rate_hz: float, slowest_hz: float, axis: int
) -> np.ndarray:
    """Run a filter forwards and backwards; its memory is about one period of ``slowest_hz``."""
    x = np.asarray(x, dtype=float)
    if x.shape[axis] < 2:
        raise InputError(f"signal to filter: expected samples, found {x.shape[axis]}: record longer")
    if not np.isfinite(x).all():
        raise InputError(
            "signal to filter: expected finite samples, found NaN or infinite ones: fill or cut them first"
        )
    # the default padding is a few samples only
    padding = min(x.shape[axis] - 1, int(np.ceil(2.0 * rate_hz / slowest_hz)))
    return scipy.signal.sosfiltfilt(sections, x, axis=axis, padlen=padding)


@dataclass(frozen=True)
class Lowpass:
    """Butterworth low-pass that is applied to all signals of a recording."""

    cutoff_hz: float
    """Cutoff frequency."""
    order: int
    """Order; of both passes together if the filter is zero-lag."""
    zero_lag: bool
    """True: forwards and backwards, without phase shift. False: forwards only, as in real time."""

    def within(self, rate_hz: float) -> "Lowpass":
        """Filter with the cutoff lowered to `WIDEST` times a sampling rate (Hz) where it lies above."""
        return replace(self, cutoff_hz=min(self.cutoff_hz, WIDEST * rate_hz))

    def __call__(self, x: np.ndarray, rate_hz: float) -> np.ndarray:
        """Filter ``x``, shape (n,) or (n, c), sampled at ``rate_hz`` (Hz); unit of ``x``."""
        if self.zero_lag:
            return butterworth_lowpass(x, rate_hz, self.cutoff_hz, self.order)
        _refuse_cutoff(self.cutoff_hz, rate_hz)
        sections = _designed(self.order, self.cutoff_hz, rate_hz)
        return scipy.signal.sosfilt(sections, x, axis=0)
