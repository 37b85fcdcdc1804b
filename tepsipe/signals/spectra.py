"""Open-loop spectral estimates and coherence (thesis eqs 3-3 and 3-4)."""

from dataclasses import dataclass

import numpy as np

from tepsipe.errors import InputError


@dataclass(frozen=True)
class SpectralEstimate:
    """Frequency response from u to y, with its coherence.

    Attributes
    ----------
    frequency_hz : ndarray, shape (n,)
        Frequencies (Hz).
    response : ndarray of complex, shape (n,)
        S_uy / S_uu (unit of y over unit of u).
    coherence : ndarray, shape (n,)
        |S_uy|^2 / (S_uu S_yy), 0 to 1 (-).
    averages : int
        Number of raw spectra averaged into each value (-).
    """

    frequency_hz: np.ndarray
    response: np.ndarray
    coherence: np.ndarray
    averages: int

    def band(self, low_hz: float, high_hz: float) -> "SpectralEstimate":
        """The part between two frequencies (Hz), both included.

        Raises
        ------
        InputError
            If fewer than four frequencies lie in the band.
        """
        inside = (self.frequency_hz >= low_hz - 1e-9) & (self.frequency_hz <= high_hz + 1e-9)
        if inside.sum() < 4:
            raise InputError(
                f"expected at least 4 frequencies between {low_hz:g} and {high_hz:g} Hz, found "
                f"{inside.sum()}: average over fewer bins, widen the band, or record longer"
            )
        return SpectralEstimate(
            self.frequency_hz[inside], self.response[inside], self.coherence[inside], self.averages
        )


def frequency_averaged(
    u: np.ndarray, y: np.ndarray, rate_hz: float, bins: int, taper: bool = False
) -> SpectralEstimate:
    """Spectral estimate of one record, raw spectra averaged over neighbouring frequencies.

    This is the estimator of the thesis. A record that does not hold whole periods of a periodic
    perturbation leaks: see `period_averaged`. Above the perturbation's band an untapered record shows only
    the step between its ends, whose coherence is 1.

    Parameters
    ----------
    u, y : ndarray, shape (n,)
        Input and output (any units).
    rate_hz : float
        Sampling rate (Hz).
    bins : int
        Number of neighbouring raw frequencies averaged into one (-).
    taper : bool
        Whether to taper both ends with a Hann window (-).

    Returns
    -------
    SpectralEstimate
        From near 0 Hz (without the mean) to half the rate (Hz).
    """
    frequency = np.fft.rfftfreq(u.size, 1.0 / rate_hz)[1:]
    window = np.hanning(u.size) if taper else np.ones(u.size)
    spectrum_u, spectrum_y = np.fft.rfft(window * u)[1:], np.fft.rfft(window * y)[1:]
    groups = frequency.size // bins

    def average(x: np.ndarray) -> np.ndarray:
        return x[: groups * bins].reshape(groups, bins).mean(axis=1)

    s_uu = average(np.abs(spectrum_u) ** 2)
    s_yy = average(np.abs(spectrum_y) ** 2)
    s_uy = average(np.conj(spectrum_u) * spectrum_y)
    return _estimate(average(frequency), s_uu, s_yy, s_uy, bins)


def period_averaged(
    u: np.ndarray, y: np.ndarray, rate_hz: float, period_s: float, band_hz: tuple[float, float]
) -> SpectralEstimate:
    """Spectral estimate at the lines of a periodic perturbation, averaged over whole periods.

    Each transform covers exactly one period, so there is no leakage; no frequencies are averaged, so
    there is no smearing. The last whole periods of the record are used.

    Parameters
    ----------
    u, y : ndarray, shape (n,)
        Input, periodic, and output (any units).
    rate_hz : float
        Sampling rate (Hz).
    period_s : float
        Period of the perturbation (s), a whole number of samples.
    band_hz : (float, float)
        Lowest and highest excited frequency (Hz).

    Returns
    -------
    SpectralEstimate
        At the multiples of 1 / period within the band (Hz).

    Raises
    ------
    InputError
        If the period is not a whole number of samples, or the record holds fewer than two.
    """
    samples = round(period_s * rate_hz)
    if abs(samples - period_s * rate_hz) > 1e-6:
        raise InputError(
            f"expected a perturbation period of whole samples at {rate_hz:g} Hz, found {period_s:g} s: "
            "change the resampling rate in the configuration"
        )
    periods = u.size // samples
    if periods < 2:
        raise InputError(
            f"expected at least two periods of {period_s:g} s after cutting the ends, found "
            f"{u.size / rate_hz:.3g} s of record: cut less or record longer"
        )
    kept = periods * samples
    spectra_u = np.fft.rfft(u[-kept:].reshape(periods, samples), axis=1)
    spectra_y = np.fft.rfft(y[-kept:].reshape(periods, samples), axis=1)
    frequency = np.fft.rfftfreq(samples, 1.0 / rate_hz)
    lines = (frequency >= band_hz[0] - 1e-9) & (frequency <= band_hz[1] + 1e-9)
    u_lines, y_lines = spectra_u[:, lines], spectra_y[:, lines]
    s_uu = np.mean(np.abs(u_lines) ** 2, axis=0)
    s_yy = np.mean(np.abs(y_lines) ** 2, axis=0)
    s_uy = np.mean(np.conj(u_lines) * y_lines, axis=0)
    return _estimate(frequency[lines], s_uu, s_yy, s_uy, periods)


def _estimate(frequency, s_uu, s_yy, s_uy, averages) -> SpectralEstimate:
    if not (s_uu > 0.0).all() or not (s_yy > 0.0).all():
        raise InputError(
            "expected power in input and output at every frequency, found some without: check that "
            "the joint was perturbed and its motion recorded"
        )
    return SpectralEstimate(frequency, s_uy / s_uu, np.abs(s_uy) ** 2 / (s_uu * s_yy), averages)
