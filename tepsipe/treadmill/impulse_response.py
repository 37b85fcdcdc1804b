"""Impulse responses from belt acceleration to load: finite least squares, and from spectra.

    L(k) = sum_j h_j a(k - j),    j = -lead ... lag

With lead = 0 the model is causal and can run in real time. A few samples of lead compensate for a velocity
that is logged later than the load, or smoothed.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
import scipy

from tepsipe.errors import InputError
from tepsipe.treadmill.belt_model import BeltModel
from tepsipe.treadmill.recording import BeltRecording

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
