"""Open-loop spectral estimates and coherence (thesis eqs 3-3 and 3-4)."""

from dataclasses import dataclass

import numpy as np

from tepsipe.errors import InputError
from tepsipe.signals.units import regular_rate, same_length, samples


@dataclass(frozen=True)
class FrequencyResponse:
    """Frequency response from u to y, with its coherence.

    Attributes
    ----------
    frequency_hz : ndarray, shape (n,)
        Frequencies (Hz).
    response : ndarray of complex, shape (n,)
        S_uy / S_uu (unit of y over unit of u).
    coherence : ndarray, shape (n,)
        |S_uy|^2 / (S_uu S_yy), 0 to 1 (-).
    averages : float or ndarray, shape (n,)
        Number of independent raw spectra averaged into each value (-).
    error : ndarray, shape (n,), or None
        Standard error of the gain relative to the gain, and of the phase in rad (-), where the estimator
        does not leave it to the coherence.
    freedom : ndarray, shape (n,), or None
        Degrees of freedom of this error (-).
    """

    frequency_hz: np.ndarray
    response: np.ndarray
    coherence: np.ndarray
    averages: float | np.ndarray
    error: np.ndarray | None = None
    freedom: np.ndarray | None = None

    def band(self, low_hz: float, high_hz: float) -> "FrequencyResponse":
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
        parts = (self.response, self.coherence, self.averages, self.error, self.freedom)
        return FrequencyResponse(self.frequency_hz[inside], *(x[inside] if np.ndim(x) else x for x in parts))

    def to_frame(self):
        """The response as a pandas table: frequency (Hz), gain, phase (degrees), coherence (-)."""
        import pandas as pd

        return pd.DataFrame(
            {
                "frequency_hz": self.frequency_hz,
                "gain": np.abs(self.response),
                "phase_deg": np.degrees(np.unwrap(np.angle(self.response))),
                "coherence": self.coherence,
            }
        )

    def plot(self):
        """Gain, phase and coherence as a matplotlib figure (units in its labels)."""
        import matplotlib.pyplot as plt

        table, (factor, half) = self.to_frame(), self.confidence_band()
        figure, axes = plt.subplots(3, 1, sharex=True, layout="constrained")
        ends = [(table.gain / factor, table.gain * factor), (table.phase_deg - half, table.phase_deg + half)]
        for axis, (low, high) in zip(axes, ends, strict=False):
            axis.fill_between(table.frequency_hz, low, high, color="0.85", label="95 % confidence")
        axes[0].loglog(table.frequency_hz, table.gain, color="0.2")
        axes[1].semilogx(table.frequency_hz, table.phase_deg, color="0.2")
        axes[2].semilogx(table.frequency_hz, table.coherence, color="0.2")
        level = np.broadcast_to(self.coherence_threshold(), table.frequency_hz.shape)
        axes[2].semilogx(table.frequency_hz, level, color="#c8371b", linewidth=0.8, linestyle="--")
        axes[0].set(ylabel="Gain (output/input)")
        axes[1].set(ylabel="Phase (degrees)")
        axes[2].set(ylabel="Coherence (–)", xlabel="Frequency (Hz)", ylim=(0.0, 1.05))
        return figure

    def coherence_threshold(self, confidence: float = 0.95) -> float | np.ndarray:
        """Coherence (-) that unrelated signals exceed with the probability 1 - ``confidence`` (-).

        One number, or one per frequency where the number of averages differs; 1 for fewer than two.
        """
        others = np.maximum(np.asarray(self.averages, dtype=float) - 1.0, 1e-9)
        found = np.where(others < 1.0, 1.0, 1.0 - (1.0 - confidence) ** (1.0 / others))
        return found if found.ndim else float(found)

    def confidence_band(self, confidence: float = 0.95) -> tuple[np.ndarray, np.ndarray]:
        """Confidence bands of gain and phase at each frequency, by Student's t.

        Without an error of its own, the response is a regression of n averaged spectra, with the relative
        error sqrt((1 - coherence) / coherence / (2 n - 2)) of 2 n - 2 degrees of freedom (Bendat & Piersol
        2010, Random Data, 4th ed., ch. 9). Such bands hold noise and distortion that is not coherent with
        the input; they do not hold leakage, or a resolution too coarse for the response.

        Parameters
        ----------
        confidence : float
            Probability of each band at each frequency (-).

        Returns
        -------
        factor, half_width_deg : ndarray, shape (n,)
            The band of the gain runs from gain / factor to gain x factor (-), that of the phase is +-
            half_width_deg (degrees), 180 where the phase is unknown.
        """
        import scipy

        freedom, error = self.freedom, self.error
        if error is None:
            freedom = np.maximum(2.0 * np.asarray(self.averages, dtype=float) - 2.0, 1e-9)
            with np.errstate(divide="ignore"):
                error = np.sqrt((1.0 - self.coherence) / (self.coherence * freedom))
        half = scipy.stats.t.ppf(0.5 + 0.5 * confidence, np.maximum(freedom, 1.0)) * error
        with np.errstate(over="ignore"):
            return np.exp(half), np.minimum(180.0, np.degrees(half))


def frequency_response(
    time: np.ndarray,
    u: np.ndarray,
    y: np.ndarray,
    *,
    averaged_bins: int | None = 16,
    taper: bool = True,
    period_s: float | None = None,
    band_hz: tuple[float, float] = (0.0, np.inf),
) -> FrequencyResponse:
    """Frequency response from u to y, with its coherence (thesis eqs 3-3 and 3-4).

    With the torque as u and the angle as y it is the admittance of the joint, the other way round its
    impedance. Means are removed. If the perturbation is periodic, say so: whole periods are then averaged,
    which neither leaks nor smears.

    Parameters
    ----------
    time : array_like or Signal, shape (n,)
        Instants (s), on a regular clock.
    u, y : array_like or Signal, shape (n,)
        Input and output; a `Signal` is taken in its own unit.
    averaged_bins : int or None
        Number of neighbouring raw frequencies averaged into one (-), without a period. None: bands that
        widen with the frequency, whose confidence bands also hold where response or perturbation vary
        within a band (`tepsipe.signals.multitaper`); for random perturbations.
    taper : bool
        Whether to fade both ends out with a Hann window (-), without a period.
    period_s : float, optional
        Period of the perturbation (s), a whole number of samples.
    band_hz : (float, float)
        Lowest and highest frequency (Hz).

    Returns
    -------
    FrequencyResponse
        Response (unit of y over unit of u) and coherence (-).

    Raises
    ------
    InputError
        If the signals cannot be used, or hold too few periods or frequencies.
    """
    time, rate_hz = regular_rate(time)
    u, y = (samples(x, getattr(x, "unit", ""), name) for x, name in ((u, "u"), (y, "y")))
    same_length(time, u=u, y=y)
    u, y = u - u.mean(), y - y.mean()
    highest = min(band_hz[1], 0.5 * rate_hz)
    if period_s is not None:
        lowest = max(band_hz[0], 0.5 / period_s)
        return period_averaged(u, y, rate_hz, period_s, (lowest, highest))
    if averaged_bins is None:
        from tepsipe.signals.multitaper import multitaper_response

        return multitaper_response(u, y, rate_hz, highest).band(band_hz[0], highest)
    if not 2 <= averaged_bins <= u.size // 8:
        raise InputError(
            f"averaged_bins: expected 2 to {u.size // 8} for {u.size} samples, found {averaged_bins}: "
            f"coherence "
            "needs averages, and the response some frequencies"
        )
    return frequency_averaged(u, y, rate_hz, averaged_bins, taper).band(band_hz[0], highest)


def frequency_averaged(
    u: np.ndarray, y: np.ndarray, rate_hz: float, bins: int, taper: bool = False
) -> FrequencyResponse:
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
    FrequencyResponse
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
    return _estimate(average(frequency), s_uu, s_yy, s_uy, _independent(bins) if taper else bins)


def _independent(bins: int) -> float:
    """Number of independent ones among neighbouring lines of a record tapered by a Hann window (-).

    Lines one and two apart have the correlations 2/3 and 1/6.
    """
    shared = (1.0 - 1.0 / bins) * (2.0 / 3.0) ** 2 + max(0.0, 1.0 - 2.0 / bins) * (1.0 / 6.0) ** 2
    return bins / (1.0 + 2.0 * shared)


def period_averaged(
    u: np.ndarray, y: np.ndarray, rate_hz: float, period_s: float, band_hz: tuple[float, float]
) -> FrequencyResponse:
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
    FrequencyResponse
        At the multiples of 1 / period within the band (Hz).

    Raises
    ------
    InputError
        If the period is not a whole number of samples, or the record holds fewer than two.
    """
    frequency, u_lines = period_spectra(u, rate_hz, period_s, band_hz)
    _, y_lines = period_spectra(y, rate_hz, period_s, band_hz)
    s_uu = np.mean(np.abs(u_lines) ** 2, axis=0)
    s_yy = np.mean(np.abs(y_lines) ** 2, axis=0)
    s_uy = np.mean(np.conj(u_lines) * y_lines, axis=0)
    return _estimate(frequency, s_uu, s_yy, s_uy, len(u_lines))


def period_spectra(
    x: np.ndarray, rate_hz: float, period_s: float, band_hz: tuple[float, float]
) -> tuple[np.ndarray, np.ndarray]:
    """Spectrum of each of the last whole periods of a record.

    Parameters
    ----------
    x : ndarray, shape (n,)
        Signal (any unit).
    rate_hz, period_s : float
        Sampling rate (Hz), and period, a whole number of samples (s).
    band_hz : (float, float)
        Lowest and highest frequency (Hz).

    Returns
    -------
    frequency, spectra : ndarray of shape (lines,), (periods, lines)
        Multiples of 1 / period within the band (Hz), and the discrete Fourier transform (unit of x).

    Raises
    ------
    InputError
        If the period is not a whole number of samples, or the record holds fewer than two.
    """
    length = round(period_s * rate_hz)
    if abs(length - period_s * rate_hz) > 1e-6:
        raise InputError(
            f"expected a perturbation period of whole samples at {rate_hz:g} Hz, found {period_s:g} s: "
            "change the resampling rate in the configuration"
        )
    periods = x.size // length
    if periods < 2:
        raise InputError(
            f"expected at least two periods of {period_s:g} s after cutting the ends, found "
            f"{x.size / rate_hz:.3g} s of record: cut less or record longer"
        )
    frequency = np.fft.rfftfreq(length, 1.0 / rate_hz)
    lines = (frequency >= band_hz[0] - 1e-9) & (frequency <= band_hz[1] + 1e-9)
    return frequency[lines], np.fft.rfft(x[-periods * length :].reshape(periods, length), axis=1)[:, lines]


def power_at_lines(u: np.ndarray, rate_hz: float, period_s: float, frequency_hz: np.ndarray) -> np.ndarray:
    """Mean power of a periodic signal over its last whole periods.

    Parameters
    ----------
    u : ndarray, shape (n,)
        Signal (any unit).
    rate_hz, period_s : float
        Sampling rate (Hz), and period, a whole number of samples (s).
    frequency_hz : ndarray, shape (lines,)
        Multiples of 1 / period (Hz).

    Returns
    -------
    ndarray, shape (lines,)
        |U|^2 of the discrete Fourier transform (unit of u, squared).
    """
    length = round(period_s * rate_hz)
    periods = u[-(u.size // length) * length :].reshape(-1, length)
    lines = np.round(np.asarray(frequency_hz) * period_s).astype(int)
    return np.mean(np.abs(np.fft.rfft(periods, axis=1)[:, lines]) ** 2, axis=0)


def _estimate(frequency, s_uu, s_yy, s_uy, averages) -> FrequencyResponse:
    if not (s_uu > 0.0).all() or not (s_yy > 0.0).all():
        raise InputError(
            "expected power in input and output at every frequency, found some without: check that "
            "the joint was perturbed and its motion recorded"
        )
    return FrequencyResponse(frequency, s_uy / s_uu, np.abs(s_uy) ** 2 / (s_uu * s_yy), averages)
