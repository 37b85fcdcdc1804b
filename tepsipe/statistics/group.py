"""Mean over people: its spread, and its 95 % interval by Student's t.

With the values x_1 ... x_n of n people,

    mean = sum x_i / n,    SD^2 = sum (x_i - mean)^2 / (n - 1),    SEM = SD / sqrt(n),

and the interval is mean +- t SEM, where t is the 97.5 % quantile of Student's distribution with n - 1 degrees
of freedom. SD includes both the differences between people and the uncertainty of each person's value.
"""

from dataclasses import dataclass

import numpy as np
import scipy

CONFIDENCE = 0.95


@dataclass(frozen=True)
class GroupMean:
    """Mean over people."""

    n: int
    """Number of people."""
    mean: float
    """Mean of their values (unit of the values)."""
    sd: float | None
    sem: float | None
    """Standard deviation between people, standard error of the mean (same unit); None for one person."""
    low: float | None
    high: float | None
    """Ends of the 95 % interval of the mean (same unit); None for one person."""


def group_mean(values: np.ndarray) -> GroupMean:
    """Mean over people, with the interval by Student's t.

    values: one value per person, at least one.
    Returns: mean, spread and interval (unit of ``values``). They do not depend on the order of the people.
    """
    ordered = np.sort(np.asarray(values, dtype=float))
    n, mean = ordered.size, float(ordered.mean())
    if n < 2:
        return GroupMean(n, mean, None, None, None, None)
    sd = float(ordered.std(ddof=1))
    sem = sd / np.sqrt(n)
    half = float(scipy.special.stdtrit(n - 1, 0.5 * (1.0 + CONFIDENCE)) * sem)
    return GroupMean(n, mean, sd, float(sem), mean - half, mean + half)


def typical_uncertainty(standard_errors: np.ndarray) -> float | None:
    """Root mean square of the standard errors of several people, shape (n,); None for nobody.

    The square of the observed SD between people is on average the sum of the variance between people and of
    the square of this uncertainty.
    """
    errors = np.sort(np.asarray(standard_errors, dtype=float))
    return float(np.sqrt(np.mean(errors**2))) if errors.size else None
