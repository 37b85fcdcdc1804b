"""Open-loop spectral estimates and coherence (thesis eqs 3-3 and 3-4)."""

import numpy as np

from tepsipe.arguments import (
    checked,
    pair,
    refuse_constant,
    refuse_same,
    regular_rate,
    same_length,
    samples,
)
from tepsipe.errors import InputError
from tepsipe.signals.array_types import Samples
from tepsipe.signals.multitaper import multitaper_response
from tepsipe.signals.response import FrequencyResponse


def frequency_response(
    time: "Samples",
    u: "Samples",
    y: "Samples",
    *,
    averaged_bins: int | None = 16,
    taper: bool = True,
    period_s: float | None = None,
    band_hz: tuple[float, float] = (0.0, np.inf),
) -> FrequencyResponse:
    """Frequency response from u to y, with its coherence (thesis eqs 3-3 and 3-4).

    With the torque as u and the angle as y it is the admittance of the joint, the other way round its
    impedance. Means are removed. If the perturbation is periodic, give its period: whole periods are then
    averaged, which causes neither leakage nor smearing.

    Parameters
    ----------
    time : array_like or Signal, shape (n,)
        Instants (s), on a regular clock.
    u, y : array_like or Signal, shape (n,)
        Input and output; a `Signal` is taken in its own unit.
    averaged_bins : int or None
        Number of neighbouring raw frequencies averaged into one, without a period. None: bands that
        widen with the frequency, whose confidence bands also hold where response or perturbation vary
        within a band (`tepsipe.signals.multitaper`); for random perturbations.
    taper : bool
        Whether to fade both ends out with a Hann window, without a period.
    period_s : float, optional
        Period of the perturbation (s), a whole number of samples.
    band_hz : (float, float)
        Lowest and highest frequency (Hz).

    Returns
    -------
    FrequencyResponse
        Response (unit of y over unit of u) and coherence.

    Raises
    ------
    InputError
        If the signals cannot be used, or hold too few periods or frequencies.

    Examples
    --------
    >>> from tepsipe import frequency_response, load_example
    >>> rig = load_example("manipulator")
    >>> response = frequency_response(
    ...     rig.time, rig.torque, rig.angle, period_s=rig.period_s, band_hz=(1.0, 20.0)
    ... )
    >>> print(f"{response.frequency_hz.size} frequencies, coherence above {response.coherence.min():.2f}")
    191 frequencies, coherence above 1.00
    """
    time, rate_hz = regular_rate(time)
    u, y = (samples(x, None, name) for x, name in ((u, "u"), (y, "y")))
    same_length(time, u=u, y=y)
    averaged_bins, taper, period_s = checked(
        ("averaged_bins", "period_s"), averaged_bins=averaged_bins, taper=taper, period_s=period_s
    )
    band_hz = pair(band_hz, "band_hz")
    refuse_constant(u=u, y=y)
    refuse_same(u=u, y=y)
    u, y = u - u.mean(), y - y.mean()
    highest = min(band_hz[1], 0.5 * rate_hz)
    if period_s is not None:
        if period_s * rate_hz < 4.0:
            raise InputError(
                f"period_s: expected a period of at least 4 samples at {rate_hz:g} Hz, found {period_s:g} s: "
                "give the period of the perturbation"
            )
        lowest = max(band_hz[0], 0.5 / period_s)
        found = period_averaged(u, y, rate_hz, period_s, (lowest, highest))
        if not found.frequency_hz.size:
            raise InputError(
                f"band_hz: expected multiples of {1.0 / period_s:g} Hz between {lowest:g} and {highest:g} "
                "Hz, found none: widen the band"
            )
        return found
    if averaged_bins is None:
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

    u, y: input and output.
    taper: whether to taper both ends with a Hann window.
    Returns: from near 0 Hz (without the mean) to half the rate.
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
    averages, width_hz = _independent(bins) if taper else bins, bins * rate_hz / u.size
    return _estimate(average(frequency), s_uu, s_yy, s_uy, averages, resolution_hz=width_hz)


def _independent(bins: int) -> float:
    """Number of independent ones among neighbouring lines of a record tapered by a Hann window.

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

    u, y: input, periodic, and output.
    period_s: period of the perturbation (s), a whole number of samples.
    band_hz: lowest and highest excited frequency.
    Returns: at the multiples of 1 / period within the band.
    """
    frequency, u_lines = period_spectra(u, rate_hz, period_s, band_hz)
    _, y_lines = period_spectra(y, rate_hz, period_s, band_hz)
    s_uu = np.mean(np.abs(u_lines) ** 2, axis=0)
    s_yy = np.mean(np.abs(y_lines) ** 2, axis=0)
    s_uy = np.mean(np.conj(u_lines) * y_lines, axis=0)
    return _estimate(frequency, s_uu, s_yy, s_uy, len(u_lines), input_power=s_uu)


def period_spectra(
    x: np.ndarray, rate_hz: float, period_s: float, band_hz: tuple[float, float]
) -> tuple[np.ndarray, np.ndarray]:
    """Spectrum of each of the last whole periods of a record.

    x: Signal.
    rate_hz, period_s: sampling rate (Hz), and period, a whole number of samples (s).
    band_hz: lowest and highest frequency.
    Returns: multiples of 1 / period within the band (Hz), and the discrete Fourier transform (unit of x).
    """
    length = round(period_s * rate_hz)
    if abs(length - period_s * rate_hz) > 1e-6:
        raise InputError(
            f"expected a perturbation period of whole samples at {rate_hz:g} Hz, found {period_s:g} s: "
            "resample to a rate of which the period is a whole number of samples"
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


def _estimate(frequency, s_uu, s_yy, s_uy, averages, **further) -> FrequencyResponse:
    if not (s_uu > 0.0).all() or not (s_yy > 0.0).all():
        raise InputError(
            "expected power in input and output at every frequency, found some without: check that "
            "the joint was perturbed and its motion recorded"
        )
    coherence = np.abs(s_uy) ** 2 / (s_uu * s_yy)
    return FrequencyResponse(frequency, s_uy / s_uu, coherence, averages, **further)
