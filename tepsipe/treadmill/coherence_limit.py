"""Upper limit of R2 for linear, time-invariant models of the belt acceleration, from coherence."""

import numpy as np

from tepsipe.treadmill.recording import BeltRecording


def coherence_limit(recordings: list[BeltRecording], segment_s: float) -> float:
    """Fraction of the load's power that is coherent with the belt acceleration (-).

    The spectra are averaged over half-overlapping Hann segments of continuous recordings, or over the
    zero-padded perturbations of transient ones. The coherence of unrelated signals averaged over n
    segments has a bias of 1/n, which is removed.

    Parameters
    ----------
    recordings : list of BeltRecording
        Recordings on which models are evaluated.
    segment_s : float
        Length of the segments of continuous recordings (s).

    Returns
    -------
    float
        sum gamma^2 S_LL / sum S_LL over all frequencies but 0 Hz (-), the upper limit of R2. NaN for a
        single segment.
    """
    s_aa, s_al, s_ll, count = 0.0, 0.0, 0.0, 0.0
    for r in recordings:
        a, load = _segments(r.acceleration, r, segment_s), _segments(r.load, r, segment_s)
        overlapping = 1.0 if r.onsets else HANN_HALF_OVERLAP
        spectrum_a, spectrum_l = (np.fft.rfft(x, axis=1)[:, 1:] for x in (a, load))
        s_aa = s_aa + np.sum(np.abs(spectrum_a) ** 2, axis=0)
        s_ll = s_ll + np.sum(np.abs(spectrum_l) ** 2, axis=0)
        s_al = s_al + np.sum(np.conj(spectrum_a) * spectrum_l, axis=0)
        count += overlapping * a.shape[0]
    if count <= 1.0:
        return float("nan")
    power = s_aa * s_ll
    coherence = np.abs(s_al) ** 2 / np.where(power > 0.0, power, 1.0)
    unbiased = (count * coherence - 1.0) / (count - 1.0)
    return float(np.clip(np.sum(unbiased * s_ll) / np.sum(s_ll), 0.0, 1.0))


# number of independent averages per half-overlapping Hann segment (Welch 1967)
HANN_HALF_OVERLAP = 0.947


def _segments(x: np.ndarray, recording: BeltRecording, segment_s: float) -> np.ndarray:
    """Segments without their mean, tapered or padded, shape (segments, samples)."""
    if recording.onsets:
        parts = recording.segments(x)
        return np.pad(parts, ((0, 0), (0, parts.shape[1])))
    samples = min(round(segment_s * recording.rate_hz), int(recording.evaluated.sum()))
    inside = x[recording.evaluated] - x[recording.evaluated].mean()
    parts = np.lib.stride_tricks.sliding_window_view(inside, samples)[:: max(1, samples // 2)]
    return parts * np.hanning(samples)
