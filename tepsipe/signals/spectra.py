"""Open-loop spectral estimates and coherence (thesis eqs 3-3 and 3-4), and responses by multitapers.

Frequency response of one record by sine multitapers, with bands that widen with frequency.

Tapers of Riedel & Sidorenko (1995, IEEE Trans. Signal Process. 43, 188-195), at each frequency as many as its
band holds (Barbour & Parker 2014, Comput. Geosci. 63, 1-8). Of the record x_1 ... x_N

    X_k(f) = sum over n of x_n sin(pi k n / (N + 1)) exp(-2 pi i f n / rate) ~ X(f - k w) - X(f + k w)

with w = rate / (2 N + 2), k = 1 ... K, are uncorrelated samples of the spectrum in the band f +- (K + 1) w. A
response H(f) that bends within the band, and a perturbation whose spectrum is not flat there, would bias the
mean of U_k* Y_k / |U_k|^2. As in the local polynomial method (Pintelon & Schoukens 2012, System
Identification, 2nd ed., ch. 7), H is therefore a polynomial of second order around f:

    Y_k = H U_k + H' w k (U(f + k w) + U(f - k w)) (-1) + H'' (w k)^2 / 2 U_k + E_k

by least squares, so that the error of H has 2 (K - 3) degrees of freedom.
"""

from dataclasses import replace

import numpy as np
import scipy

from tepsipe.arguments import checked, pair, refuse_constant, refuse_same, regular_rate, same_length, samples
from tepsipe.errors import InputError
from tepsipe.signals.array_types import Samples
from tepsipe.signals.response import FrequencyResponse
from tepsipe.signals.sample_faults import of_samples

# complex unknowns at each frequency: H and its first two derivatives
UNKNOWNS = 3
# probability of a difference between parts of a record, and of a residual, that is taken for chance; smallest
# relative difference that matters
CHANCE, LEAST_DIFFERENCE = 1e-4, 0.03
# part of a record in whole periods, below which it is noted that the rest is not used
LEAST_USED = 0.9
# half width of a band as a fraction of its frequency, its upper limit (Hz), and the number of tapers of a
# band that would hold fewer
RELATIVE_HALF_BAND, WIDEST_HALF_BAND_HZ, FEWEST_TAPERS = 0.08, 0.5, 12


def multitaper_response(u: np.ndarray, y: np.ndarray, rate_hz: float, highest_hz: float) -> FrequencyResponse:
    """Frequency response from u to y of one record of any perturbation, after removal of straight lines.

    u, y: input and output.
    Returns: response (unit of y over unit of u) at frequencies half a band apart, coherence, number of
    tapers, and error of the response.
    """
    step = 0.5 * rate_hz / (u.size + 1)
    last = min(highest_hz, 0.5 * rate_hz - WIDEST_HALF_BAND_HZ)
    at, tapers = _bands(last / step, WIDEST_HALF_BAND_HZ / step)
    if len(at) < 4:
        raise InputError(
            f"expected a record that holds at least 4 bands of frequencies up to {highest_hz:g} Hz, found "
            f"{len(at)} in {u.size / rate_hz:.3g} s: record longer"
        )
    of_u, of_y = _padded_spectrum(u), _padded_spectrum(y)
    estimates = [_at_one_frequency(of_u, of_y, *band) for band in zip(at, tapers, strict=True)]
    response, error, coherence = (np.array(column) for column in zip(*estimates, strict=True))
    return FrequencyResponse(step * at, response, coherence, tapers, error, 2.0 * (tapers - UNKNOWNS))


def _at_one_frequency(of_u, of_y, j: int, tapers: int) -> tuple[complex, float, float]:
    """Response (unit of y over unit of u), its relative standard error, and the coherence."""
    k = np.arange(1, tapers + 1)
    u, y = (x[j - k] - x[j + k] for x in (of_u, of_y))
    power_u, power_y = np.vdot(u, u).real, np.vdot(y, y).real
    if not (power_u > 0.0 and power_y > 0.0):
        raise InputError(
            "expected power in input and output at every frequency, found some without: check that "
            "the joint was perturbed and its motion recorded"
        )
    place = k / tapers
    columns = np.column_stack([u, place * (of_u[j - k] + of_u[j + k]), place**2 * u])
    inverse = np.linalg.pinv(columns.conj().T @ columns, hermitian=True)
    solution = inverse @ (columns.conj().T @ y)
    residual = y - columns @ solution
    variance = np.vdot(residual, residual).real / (tapers - UNKNOWNS)
    # standard error of the real and of the imaginary part
    error = np.sqrt(0.5 * variance * inverse[0, 0].real) / max(abs(solution[0]), 1e-300)
    return solution[0], error, min(1.0, abs(np.vdot(u, y)) ** 2 / (power_u * power_y))


def _padded_spectrum(x: np.ndarray) -> np.ndarray:
    """Spectrum (unit of x) of a record less its straight line, x_1 ... x_N among 2 (N + 1) samples."""
    time = np.linspace(-1.0, 1.0, x.size)
    detrended = x - x.mean() - time * (time @ x) / (time @ time)
    return np.fft.fft(np.concatenate([[0.0], detrended, np.zeros(x.size + 1)]))


def _bands(last: float, widest: float) -> tuple[np.ndarray, np.ndarray]:
    """Centres of the bands and their numbers of tapers, in steps of half a line up to ``last``."""
    at, tapers = [], []
    j = FEWEST_TAPERS + 2
    while j <= last:
        half = max(FEWEST_TAPERS + 1, int(min(RELATIVE_HALF_BAND * j, widest)))
        at.append(j)
        tapers.append(half - 1)
        j += half
    return np.array(at, dtype=int), np.array(tapers, dtype=int)


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
        within a band (`tepsipe.signals.spectra`); for random perturbations.
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
    notes = of_samples(input=u, output=y)

    def estimate(u: np.ndarray, y: np.ndarray) -> FrequencyResponse:
        return _response(u, y, rate_hz, averaged_bins, taper, period_s, (band_hz[0], highest))

    found = estimate(u, y)
    half = u.size // 2
    try:
        parts = [estimate(u[part], y[part]) for part in (slice(half), slice(half, None))]
    except InputError:  # half of the record is too short
        parts = []
    notes += () if period_s is None else _of_use(u.size / rate_hz, period_s)
    return replace(found, notes=notes + (_of_halves(*parts) if parts else ()))


def _of_use(lasts_s: float, period_s: float) -> tuple[str, ...]:
    """Record (s) of which a part is not used, because it does not hold whole periods (s)."""
    used = period_s * int(lasts_s / period_s + 1e-6)
    if used >= LEAST_USED * lasts_s:
        return ()
    return (
        f"Only the last {used:.4g} s of {lasts_s:.4g} s are used, which are whole periods of {period_s:g} s: "
        "check period_s, or record whole periods.",
    )


def _response(
    u: np.ndarray,
    y: np.ndarray,
    rate_hz: float,
    averaged_bins: int | None,
    taper: bool,
    period_s: float | None,
    band_hz: tuple[float, float],
) -> FrequencyResponse:
    """Response by the estimator that the perturbation needs."""
    if period_s is not None:
        if period_s * rate_hz < 4.0:
            raise InputError(
                f"period_s: expected a period of at least 4 samples at {rate_hz:g} Hz, found {period_s:g} s: "
                "give the period of the perturbation"
            )
        lowest = max(band_hz[0], 0.5 / period_s)
        found = period_averaged(u, y, rate_hz, period_s, (lowest, band_hz[1]))
        if not found.frequency_hz.size:
            raise InputError(
                f"band_hz: expected multiples of {1.0 / period_s:g} Hz between {lowest:g} and {band_hz[1]:g} "
                "Hz, found none: widen the band"
            )
        return found
    if averaged_bins is None:
        return multitaper_response(u, y, rate_hz, band_hz[1]).band(*band_hz)
    if not 2 <= averaged_bins <= u.size // 8:
        raise InputError(
            f"averaged_bins: expected 2 to {u.size // 8} for {u.size} samples, found {averaged_bins}: "
            f"coherence "
            "needs averages, and the response some frequencies"
        )
    return frequency_averaged(u, y, rate_hz, averaged_bins, taper).band(*band_hz)


def _of_halves(first: FrequencyResponse, second: FrequencyResponse) -> tuple[str, ...]:
    """Sentence on a gain that differs between the halves of a record by more than its scatter.

    log|H| of the halves is compared at common frequencies by Student's test, each weighted by its coherence.
    """
    frequency = first.frequency_hz
    inside = (frequency >= second.frequency_hz[0]) & (frequency <= second.frequency_hz[-1])
    if inside.sum() < 8:
        return ()
    other = np.interp(frequency[inside], second.frequency_hz, np.log(np.abs(second.response)))
    ratio = other - np.log(np.abs(first.response[inside]))
    weight = np.interp(frequency[inside], second.frequency_hz, second.coherence) * first.coherence[inside]
    mean = float(np.average(ratio, weights=weight))
    error = np.sqrt(np.sum((weight * (ratio - mean)) ** 2)) / weight.sum()
    chance = 2.0 * float(scipy.special.stdtr(inside.sum() - 1.0, -abs(mean) / max(float(error), 1e-300)))
    if not (chance < CHANCE and abs(mean) > LEAST_DIFFERENCE):
        return ()
    return (
        f"The gain of the second half of the record is {np.exp(mean):.3g} times that of the first: the joint "
        "or the recording changed. Check mounts and sensors, and fit the halves separately.",
    )


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
