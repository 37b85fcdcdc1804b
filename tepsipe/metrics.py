"""How good a fit is, as printed in the thesis and as it should be (thesis section 3, eqs 3-1, 3-2)."""

from dataclasses import dataclass

import numpy as np


def vaf(measured: np.ndarray, predicted: np.ndarray) -> float:
    """Variance accounted for (%), thesis eq (3-1): means are *not* removed.

    Parameters
    ----------
    measured, predicted : ndarray, shape (n,)
        Signals in the same unit.

    Returns
    -------
    float
        100 % for a perfect prediction, 0 % for a prediction of zero, without lower bound.
    """
    return float(100.0 * (1.0 - np.sum((measured - predicted) ** 2) / np.sum(measured**2)))


@dataclass(frozen=True)
class LinearFit:
    """Least-squares solution of ``J p = y`` with its measures of uncertainty.

    R are the residuals, N their number, p the number of parameters.

    Attributes
    ----------
    parameters : ndarray, shape (p,)
        Solution (units of y over units of J's columns).
    residuals : ndarray, shape (N,)
        y - J p (unit of y).
    sem_as_printed : ndarray, shape (p,)
        sqrt(R'R diag((J'J)^-1) / ||R||), thesis eq (3-2). It is neither dimensionless nor a standard
        error: R'R / ||R|| = ||R||.
    standard_error : ndarray, shape (p,)
        sqrt(R'R / (N - p) diag((J'J)^-1)), right for white residuals only.
    condition_number : float
        Ratio of the largest to the smallest singular value of J after scaling its columns to unit
        length (-).
    """

    parameters: np.ndarray
    residuals: np.ndarray
    sem_as_printed: np.ndarray
    standard_error: np.ndarray
    condition_number: float


def least_squares_line(jacobian: np.ndarray, y: np.ndarray) -> LinearFit:
    """Solve a linear least-squares problem (thesis eq 3-9 solved per data segment).

    Parameters
    ----------
    jacobian : ndarray, shape (N, p)
        Regressors, one column per parameter (any units).
    y : ndarray, shape (N,)
        Signal to explain (any unit).

    Returns
    -------
    LinearFit
        Solution, residuals and uncertainties (units as above).

    Raises
    ------
    numpy.linalg.LinAlgError
        If the regressors are linearly dependent, so that the parameters are not determined.
    """
    scale = np.linalg.norm(jacobian, axis=0)
    if not (scale > 0.0).all():
        raise np.linalg.LinAlgError("a regressor is zero throughout")
    scaled = jacobian / scale
    solution, _, rank, singular = np.linalg.lstsq(scaled, y, rcond=1e-12)
    if rank < jacobian.shape[1]:
        raise np.linalg.LinAlgError("the regressors are linearly dependent")
    residuals = y - scaled @ solution
    inverse = np.diag(np.linalg.inv(scaled.T @ scaled)) / scale**2
    return LinearFit(
        parameters=solution / scale,
        residuals=residuals,
        sem_as_printed=sem_as_printed(residuals, inverse),
        standard_error=standard_error(residuals, inverse),
        condition_number=float(singular[0] / singular[-1]),
    )


def sem_as_printed(residuals: np.ndarray, inverse_diagonal: np.ndarray) -> np.ndarray:
    """Thesis eq (3-2) as printed, sqrt(R'R (J'J)^-1 / ||R||).

    Parameters
    ----------
    residuals : ndarray, shape (N,)
        R (unit of the fitted signal).
    inverse_diagonal : ndarray, shape (p,)
        Diagonal of (J'J)^-1.

    Returns
    -------
    ndarray, shape (p,)
        As printed; its unit is that of the parameter over the square root of the signal's.
    """
    return np.sqrt(np.linalg.norm(residuals) * inverse_diagonal)


def standard_error(residuals: np.ndarray, inverse_diagonal: np.ndarray) -> np.ndarray:
    """Standard error for white residuals, sqrt(R'R / (N - p) diag((J'J)^-1)).

    Parameters
    ----------
    residuals : ndarray, shape (N,)
        R (unit of the fitted signal).
    inverse_diagonal : ndarray, shape (p,)
        Diagonal of (J'J)^-1.

    Returns
    -------
    ndarray, shape (p,)
        Standard errors (units of the parameters); infinite if N <= p.
    """
    freedom = residuals.size - inverse_diagonal.size
    if freedom <= 0:
        return np.full(inverse_diagonal.size, np.inf)
    return np.sqrt(residuals @ residuals / freedom * inverse_diagonal)


@dataclass(frozen=True)
class HeldOutVaf:
    """How good a prediction is on the part that was fitted and on the part that was not.

    Attributes
    ----------
    training, held_out : float
        VAF (%) of either part about the mean of the fitted part.
    held_out_any_offset : float
        VAF (%) of the held-out part, of measurement and prediction about their own means: blind to a level
        that has drifted.
    held_out_as_printed : float
        VAF (%) of the held-out part with the mean left in, thesis eq (3-1).
    """

    training: float
    held_out: float
    held_out_any_offset: float
    held_out_as_printed: float


def judge_held_out(measured: np.ndarray, predicted: np.ndarray, training: int) -> HeldOutVaf:
    """VAF (%) of a prediction before and after the end of the fitted part.

    Parameters
    ----------
    measured, predicted : ndarray, shape (n,)
        Signals in the same unit.
    training : int
        Number of samples, from the first on, that were fitted (samples).

    Returns
    -------
    HeldOutVaf
        The measures (%).
    """
    level = measured[:training].mean()
    test, guess = measured[training:], predicted[training:]
    return HeldOutVaf(
        training=vaf(measured[:training] - level, predicted[:training] - level),
        held_out=vaf(test - level, guess - level),
        held_out_any_offset=vaf(test - test.mean(), guess - guess.mean()),
        held_out_as_printed=vaf(test, guess),
    )


def bootstrap_blocks(
    regressors: np.ndarray,
    y: np.ndarray,
    block: int,
    draws: int,
    rng: np.random.Generator,
    penalty: np.ndarray | float = 0.0,
) -> np.ndarray:
    """Least-squares solutions for blocks drawn with replacement, from the blocks' normal equations.

    Parameters
    ----------
    regressors : ndarray, shape (n, p)
        Regressors, one column per parameter (any units).
    y : ndarray, shape (n,)
        Signal to explain (any unit).
    block, draws : int
        Length of a block (samples) and number of draws (-).
    rng : numpy.random.Generator
        Draws the blocks.
    penalty : ndarray, shape (p, p), or 0
        Added to the normal equations of all samples (unit of the regressors, squared).

    Returns
    -------
    ndarray, shape (draws, p)
        Solutions (units of y over units of the columns).
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
