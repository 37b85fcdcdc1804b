"""Residuals of a model: whiteness and memory; changes of parameters over a record."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np


@dataclass(frozen=True)
class CumulativePeriodogram:
    """Test of whiteness below a frequency."""

    frequency_hz: Annotated[np.ndarray, "(m,)"]
    """Lines of the periodogram."""
    cumulative: Annotated[np.ndarray, "(m,)"]
    """Fraction of the power up to each line."""
    limit: float
    """Distance from the straight line that white noise exceeds at some line in 5 of 100 records."""
    distance: float
    p_value: float
    """Largest distance from the straight line, and its probability for white noise."""


def cumulative_periodogram(x: np.ndarray, rate_hz: float, highest_hz: float) -> CumulativePeriodogram:
    """Whiteness up to a frequency by the normalised cumulative periodogram (Bartlett 1955; Durbin 1969).

    In a low-pass filtered record, only the frequencies that passed can be tested.

    x: Residual.
    Returns: cumulative power, and the Kolmogorov-Smirnov test of its distance from a straight line.
    """
    import scipy

    frequency = np.fft.rfftfreq(x.size, 1.0 / rate_hz)
    inside = (frequency > 0.0) & (frequency <= min(highest_hz, 0.5 * rate_hz * (1.0 - 1e-9)))
    power = np.abs(np.fft.rfft(x - x.mean())[inside]) ** 2
    lines, total = power.size, power.sum()
    cumulative = np.cumsum(power) / total if total > 0.0 else np.arange(1, lines + 1) / lines
    # the last line is always 1, so that lines - 1 fractions are free
    free = lines - 1
    distance = float(np.abs(cumulative - np.arange(1, lines + 1) / lines).max())
    # Stephens's correction for few lines
    size = np.sqrt(free) + 0.12 + 0.11 / np.sqrt(free)
    return CumulativePeriodogram(
        frequency[inside],
        cumulative,
        float(scipy.special.kolmogi(0.05) / size),
        distance,
        float(scipy.special.kolmogorov(size * distance)),
    )


def share_below(x: np.ndarray, rate_hz: float, frequency_hz: float) -> float:
    """Fraction of the mean square of a signal, its mean included, below a frequency."""
    power = np.abs(np.fft.rfft(x)) ** 2
    power[1 : (x.size + 1) // 2] *= 2.0
    at = np.fft.rfftfreq(x.size, 1.0 / rate_hz)
    return float(power[at < frequency_hz].sum() / max(power.sum(), 1e-300))


def memory_s(x: np.ndarray, rate_hz: float) -> float:
    """First lag (s) at which the autocorrelation of a signal is below 1/e."""
    size = x.size
    spectrum = np.fft.rfft(x - x.mean(), 2 * size)
    correlation = np.fft.irfft(np.abs(spectrum) ** 2)[: size // 2]
    if not correlation[0] > 0.0:
        return 0.0
    return float(np.argmax(correlation < correlation[0] / np.e) / rate_hz)


def solution_with_errors(
    regressors: Annotated[np.ndarray, "(n, p)"], y: np.ndarray, block: int
) -> tuple[np.ndarray, np.ndarray, int]:
    """Least squares with standard errors for residuals that are correlated within blocks of time.

    The jackknife over blocks (Efron 1982): every block is left out once.

    y: signal to explain.
    block: length of a block (samples).

    Returns:
        solution, error: parameters and their standard errors (units of y over units of the columns). Shape
        (p,).
        freedom: degrees of freedom of the errors: blocks - 1.
    """
    scale = np.linalg.norm(regressors, axis=0)
    scale[scale == 0.0] = 1.0
    x = regressors / scale
    normal = x.T @ x
    solution = np.linalg.pinv(normal, hermitian=True) @ (x.T @ y)
    blocks = max(2, y.size // block)
    parts = (np.array_split(z, blocks) for z in (x, y - x @ solution))
    changes = np.array(
        [
            np.linalg.pinv(normal - part.T @ part, hermitian=True) @ (part.T @ rest)
            for part, rest in zip(*parts, strict=True)
        ]
    )
    error = np.sqrt((blocks - 1.0) / blocks * np.sum((changes - changes.mean(axis=0)) ** 2, axis=0))
    return solution / scale, error / scale, blocks - 1


def equal_means_p(
    values: Annotated[np.ndarray, "(k,)"],
    errors: Annotated[np.ndarray, "(k,)"],
    freedom: Annotated[np.ndarray, "(k,)"],
) -> float:
    """Probability of a larger difference if the quantities are equal (Welch 1951, Biometrika 38, 330-336).

    values, errors: independent estimates and their standard errors.
    freedom: degrees of freedom of the errors.
    Returns: p; not a number where an error is not positive.
    """
    import scipy

    k = len(values)
    if k < 2 or not (np.asarray(errors) > 0.0).all():
        return float("nan")
    weight = np.asarray(errors) ** -2.0
    share = weight / weight.sum()
    distance = np.sum(weight * (values - share @ values) ** 2) / (k - 1.0)
    lack = np.sum((1.0 - share) ** 2 / np.asarray(freedom))
    statistic = distance / (1.0 + 2.0 * (k - 2.0) / (k**2 - 1.0) * lack)
    return float(scipy.stats.f.sf(statistic, k - 1.0, (k**2 - 1.0) / (3.0 * lack)))
