"""The low-pass filter of the study (thesis section 3-1: fourth-order bidirectional Butterworth)."""

import numpy as np
from scipy import signal

from tepsipe.errors import InputError


def butterworth_lowpass(
    x: np.ndarray, rate_hz: float, cutoff_hz: float, order: int = 4, axis: int = 0
) -> np.ndarray:
    """Filter with a Butterworth low-pass run forwards and backwards (no phase shift).

    ``order`` counts both passes, as the thesis and most of the field do: a fourth-order
    bidirectional filter is a second-order one applied twice, and its gain at the cutoff is 1/2.

    Parameters
    ----------
    x : ndarray, shape (..., n, ...)
        Signal (any unit) sampled along ``axis``.
    rate_hz, cutoff_hz : float
        Sampling rate and cutoff frequency (Hz).
    order : int
        Order of the two passes together (-), even.
    axis : int
        Time axis (-).

    Returns
    -------
    ndarray, shape of ``x``
        Filtered signal (unit of ``x``).

    Raises
    ------
    InputError
        If the cutoff does not lie between 0 and half the rate, the order is odd, the signal is too
        short to be padded, or it holds a NaN.
    """
    x = np.asarray(x, dtype=float)
    if not 0.0 < cutoff_hz < 0.5 * rate_hz:
        raise InputError(
            f"low-pass cutoff must lie between 0 and half the sampling rate ({0.5 * rate_hz:g} Hz), "
            f"found {cutoff_hz:g} Hz: change the cutoff in the configuration"
        )
    if order < 2 or order % 2:
        raise InputError(
            f"order of a bidirectional filter must be even (two equal passes), found {order}: "
            "change the order in the configuration"
        )
    if x.shape[axis] < 2:
        raise InputError(f"signal to filter: expected samples, found {x.shape[axis]}: record longer")
    if not np.isfinite(x).all():
        raise InputError("signal to filter holds NaN or infinite samples: fill or cut them first")
    sections = signal.butter(order // 2, cutoff_hz, fs=rate_hz, output="sos")
    # the default padding is a few samples; the filter's memory is about one period of the cutoff
    padding = min(x.shape[axis] - 1, int(np.ceil(2.0 * rate_hz / cutoff_hz)))
    return signal.sosfiltfilt(sections, x, axis=axis, padlen=padding)
