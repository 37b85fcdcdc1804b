"""Frequency response of one record by sine multitapers, with bands that widen with frequency.

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

import numpy as np

from tepsipe.errors import InputError
from tepsipe.signals.response import FrequencyResponse

# complex unknowns at each frequency: H and its first two derivatives
UNKNOWNS = 3
# half width of a band as a fraction of its frequency, its upper limit (Hz), and the number of tapers of a
# band that would hold fewer
RELATIVE_HALF_BAND, WIDEST_HALF_BAND_HZ, FEWEST_TAPERS = 0.08, 0.5, 12


def multitaper_response(
    u: np.ndarray,
    y: np.ndarray,
    rate_hz: float,
    highest_hz: float,
) -> FrequencyResponse:
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
