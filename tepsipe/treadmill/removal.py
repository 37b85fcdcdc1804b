"""Removal of the belt-induced load from a recording that is not filtered, and the error that remains.

A model is fitted to signals behind a low-pass, often a causal one. A correction is subtracted from the
recorded load, so it must neither lag behind it nor be too small near the cutoff f_c: it is the prediction of
the same model from a belt motion behind a linear-phase filter, whose gain is 1 up to f_c and 0 from 1.67 f_c.

On an empty belt the true load is 0 but for the zero of the transducers. The rest e of a test recording is
therefore the error of the corrected load. Its size grows with the correction p (p_rms over 0.2 s):

    |e(t)| < sqrt(c^2 + g^2 p_rms(t)^2)    in 95 % of the samples

g^2 / c^2 is fitted to e^2 by non-negative least squares, and both are scaled to 95 %. The same is done for e
behind the low-pass, which is smaller: much of e is noise and vibration above the cutoff.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import scipy

from tepsipe.signals.resampling import BAND_PER_RATE, resample
from tepsipe.treadmill.recording import BeltRecording
from tepsipe.treadmill.registry import FittedModel

COVERED = 0.95
AROUND_S = 0.2


# edge of the band of a correction, where its gain is 1/2, over the cutoff: it is 1 up to 0.75 of the edge
EDGE = 1.0 / 0.75


@dataclass(frozen=True)
class Band:
    """Linear-phase low-pass in place of the one of the calibration."""

    edge_hz: float
    """Frequency at which the gain is 1/2."""

    def __call__(self, x: np.ndarray, rate_hz: float) -> np.ndarray:
        """Filter ``x``, shape (n,) or (n, c), sampled at ``rate_hz`` (Hz); unit of ``x``."""
        time = np.arange(x.shape[0]) / rate_hz
        return resample(time, x, time, min(self.edge_hz, BAND_PER_RATE * rate_hz), rate_hz)


def removed_load(fitted: FittedModel, recording: BeltRecording) -> np.ndarray:
    """Belt-induced load below the model's cutoff (unit of the load), shape (n,).

    recording: not filtered, at the model's rate.
    """
    band = None if fitted.lowpass is None else Band(EDGE * fitted.lowpass.cutoff_hz)
    return replace(fitted, lowpass=band).predict(recording.filtered(band))


def half_width(error: Sequence[float], removed: np.ndarray, rate_hz: float) -> np.ndarray:
    """Half-width of the 95 % interval of a corrected load (unit of the load), shape (n,).

    error: c (unit of the load) and g.
    removed: what was subtracted (unit of the load).
    """
    return np.hypot(error[0], error[1] * _local_size(removed, rate_hz))


def held_out_errors(
    fitted: FittedModel, recordings: Sequence[BeltRecording]
) -> tuple[tuple[float, float], tuple[float, float]]:
    """Errors c (unit of the load) and g of unfiltered test recordings, and both behind the low-pass."""
    lowpass = fitted.lowpass
    errors, filtered, sizes = [], [], []
    for recording in recordings:
        removed, inside = removed_load(fitted, recording), recording.evaluated
        error = recording.load - removed
        below = error if lowpass is None else lowpass(error, recording.rate_hz)
        errors.append((error - error.mean())[inside])
        filtered.append((below - below.mean())[inside])
        sizes.append(_local_size(removed, recording.rate_hz)[inside])
    size = np.concatenate(sizes)
    return _covering(np.concatenate(errors), size), _covering(np.concatenate(filtered), size)


def _covering(error: np.ndarray, size: np.ndarray) -> tuple[float, float]:
    rows = np.column_stack([np.ones(error.size), size**2])
    constant, relative = np.sqrt(scipy.optimize.nnls(rows, error**2)[0])
    scale = np.quantile(np.abs(error) / np.maximum(np.hypot(constant, relative * size), 1e-300), COVERED)
    return float(scale * constant), float(scale * relative)


def _local_size(removed: np.ndarray, rate_hz: float) -> np.ndarray:
    return np.sqrt(
        scipy.ndimage.uniform_filter1d(removed**2, max(1, round(AROUND_S * rate_hz)), mode="nearest")
    )
