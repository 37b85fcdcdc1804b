"""Coverage of intervals: the share that include the truth, with its uncertainty.

Estimates of one laboratory share its errors and form a cluster, so n estimates of m laboratories carry less
information on the coverage than n independent ones. With x_j of n_j estimates of laboratory j covered, and
p = sum x_j / sum n_j,

    var(p) = m / (m - 1)  sum_j (x_j - p n_j)^2 / n^2        (ratio estimator, clusters drawn independently)
    n_eff  = p (1 - p) / var(p)

and the interval is Clopper and Pearson's for n_eff p of n_eff (E. L. Korn and B. I. Graubard (1998),
Confidence intervals for proportions with small expected number of positive counts estimated from survey data,
Survey Methodology 24, 193-201). If all or none are covered, var(p) is 0 and carries no information: then a
laboratory counts as one estimate, the least that the data can hold.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy

CONFIDENCE = 0.95


@dataclass(frozen=True)
class Share:
    """A share of estimates, with its interval."""

    n: int
    held: int
    """Number of estimates, and of those that count."""
    clusters: int
    """Number of laboratories with any."""
    low: float
    high: float
    """Ends of the 95 % interval of the share; not a number without estimates."""

    @property
    def value(self) -> float:
        """Share held / n; not a number without estimates."""
        return self.held / self.n if self.n else math.nan


def clopper_pearson(held: float, n: float) -> tuple[float, float]:
    """Exact binomial interval of a share.

    held, n: number held, and number of all; effective numbers need not be whole.
    Returns: ends, within 0 to 1.
    """
    tail = 0.5 * (1.0 - CONFIDENCE)
    low = 0.0 if held <= 0.0 else float(scipy.special.betaincinv(held, n - held + 1.0, tail))
    high = 1.0 if held >= n else float(scipy.special.betaincinv(held + 1.0, n - held, 1.0 - tail))
    return low, high


def share_of(held: Sequence[bool], clusters: Sequence[object]) -> Share:
    """Share of estimates that count, with the interval for clusters described in this module's docstring.

    held: whether an estimate counts, for example is covered.
    clusters: laboratory of each estimate, of the same length.
    Returns: with n_eff between the numbers of laboratories and of estimates.
    """
    names = list(dict.fromkeys(clusters))
    place = {name: k for k, name in enumerate(names)}
    index = np.array([place[name] for name in clusters], dtype=int)
    x = np.bincount(index, np.asarray(held, dtype=float), minlength=len(names))
    size = np.bincount(index, minlength=len(names)).astype(float)
    n, total = float(size.sum()), float(x.sum())
    if n == 0.0:
        return Share(0, 0, 0, math.nan, math.nan)
    effective = _effective_number(x, size)
    low, high = clopper_pearson(total * effective / n, effective)
    return Share(int(n), int(total), len(names), low, high)


def _effective_number(x: np.ndarray, size: np.ndarray) -> float:
    """n_eff for x of size estimates in each cluster."""
    n, m = size.sum(), len(size)
    p = x.sum() / n
    if m == 1 or p in (0.0, 1.0):
        return float(m)
    variance = m / (m - 1.0) * np.sum((x - p * size) ** 2) / n**2
    if variance == 0.0:  # every laboratory has the same share
        return float(n)
    return float(np.clip(p * (1.0 - p) / variance, m, n))
