"""Bootstrap of means over perturbations, and of least squares over blocks."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
import scipy


def bootstrap_blocks(
    regressors: Annotated[np.ndarray, "(n, p)"],
    y: np.ndarray,
    block: int,
    draws: int,
    rng: np.random.Generator,
    penalty: np.ndarray | float = 0.0,
) -> Annotated[np.ndarray, "(draws, p)"]:
    """Least-squares solutions for blocks drawn with replacement, from the blocks' normal equations.

    regressors: regressors, one column per parameter.
    y: signal to explain.
    block, draws: length of a block (samples) and number of draws.
    penalty: added to the normal equations of all samples (unit of the regressors, squared).
    Returns: solutions (units of y over units of the columns).
    """
    blocks = y.size // block
    scale = np.linalg.norm(regressors, axis=0)
    j = (regressors / scale)[: blocks * block].reshape(blocks, block, -1)
    normal = np.einsum("bni,bnj->bij", j, j)
    right = np.einsum("bni,bn->bi", j, y[: blocks * block].reshape(blocks, block))
    drawn = rng.integers(0, blocks, (draws, blocks))
    times = np.array([np.bincount(draw, minlength=blocks) for draw in drawn], dtype=float)
    added = penalty / np.outer(scale, scale)
    solutions = np.linalg.solve(np.tensordot(times, normal, 1) + added, (times @ right)[..., None])
    return solutions[..., 0] / scale


def expanded_tail(confidence: float, blocks: float) -> float:
    """Percentile of bootstrap draws at the low end of an interval, expanded for few blocks (Hesterberg 2015).

    Draws from n blocks scatter sqrt((n - 1) / n) times as much as estimates do, and their spread has n - 1
    degrees of freedom. So the end is the percentile Phi(-sqrt(n / (n - 1)) t[(1 + p) / 2, n - 1]) in place of
    (1 - p) / 2, with the quantile t of Student's distribution and the normal distribution Phi.

    confidence: probability p of the interval.
    blocks: number n of blocks from which the bootstrap draws, at least 2.
    Returns: the percentile (%) of the low end; the high end is at 100 minus it.
    """
    degrees = blocks - 1
    quantile = scipy.special.stdtrit(degrees, 0.5 * (1.0 + confidence))
    return float(100.0 * scipy.special.ndtr(-np.sqrt(blocks / degrees) * quantile))


@dataclass(frozen=True)
class Interval:
    """Uncertainty of a mean over perturbations."""

    standard_error: Annotated[np.ndarray, "(p,)"]
    """Standard error of each parameter's mean (unit of the parameter)."""
    low: Annotated[np.ndarray, "(p,)"]
    high: Annotated[np.ndarray, "(p,)"]
    """Ends of the interval (unit of the parameter)."""


def bootstrap_mean(
    values: Annotated[np.ndarray, "(n, p)"], draws: int, rng: np.random.Generator, confidence: float = 0.95
) -> Interval:
    """Bootstrap over perturbations, valid where residuals within a perturbation are correlated.

    Whole perturbations are drawn with replacement. Deviations of the drawn means are multiplied by
    sqrt(n / (n - 1)), the factor by which resampling n perturbations underestimates their spread.

    values: estimates of n perturbations.
    confidence: probability of the interval.
    Returns: standard errors and interval (units of ``values``); infinite for a single perturbation.
    """
    n = values.shape[0]
    if n < 2:
        unknown = np.full(values.shape[1], np.inf)
        return Interval(unknown, -unknown, unknown)
    drawn = values[rng.integers(0, n, (draws, n))].mean(axis=1)
    mean = values.mean(axis=0)
    deviations = np.sqrt(n / (n - 1.0)) * (drawn - mean)
    tail = round(50.0 * (1.0 - confidence), 9)
    low, high = np.percentile(deviations, [tail, 100.0 - tail], axis=0)
    return Interval(deviations.std(axis=0), mean + low, mean + high)
