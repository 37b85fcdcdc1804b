"""Covariance of a least-squares fit to clusters whose errors have an unknown covariance of their own."""

from typing import Annotated

import numpy as np
import scipy

from tepsipe.statistics.least_squares import column_lengths, spans

# smallest share of a combination of parameters that other clusters must determine
ALONE = 1e-6
# sets of borders between blocks
SHIFTS = 4


def bias_reduced_share(
    normal: Annotated[np.ndarray, "(p, p)"],
    information: Annotated[np.ndarray, "(..., p, p)"],
    moment: Annotated[np.ndarray, "(..., p)"],
) -> Annotated[np.ndarray, "(..., p)"]:
    """Shares of clusters in the error of a fit: bias-reduced linearisation (Bell & McCaffrey 2002).

        db_j = N^-1 X_j' (1 - H_j)^-1/2 e_j,     H_j = X_j N^-1 X_j',     cov(b) = sum_j db_j db_j'

    The residuals e_j of a cluster are smaller than its errors, because the cluster draws the fit towards
    itself; its share in its own prediction is H_j. With the correction the covariance is unbiased if errors
    are white. Without it the covariance is too small. The jackknife over clusters, which has the power -1,
    makes it too large, many times so for a parameter that hardly more than one cluster determines. As

        X_j' (1 - X_j N^-1 X_j')^-1/2 = L (1 - L^-1 X_j'X_j L^-T)^-1/2 L^-1 X_j',     N = L L',

    only matrices of the size of the parameters occur. Parameter combinations determined by a single cluster
    leave no residual in it; they get no share.

    normal: N, the sum of X_j'X_j over all clusters, with weak priors (1 over the units of the parameters).
    Returns: db_j (units of the parameters).
    """
    inverse = scipy.linalg.solve_triangular(np.linalg.cholesky(normal), np.eye(len(normal)), lower=True)
    share, axes = np.linalg.eigh(inverse @ information @ inverse.T)
    others = 1.0 - share
    scale = np.where(others > ALONE, 1.0 / np.sqrt(np.maximum(others, ALONE)), 0.0)
    along = np.swapaxes(axes, -1, -2) @ (moment @ inverse.T)[..., None]
    return (axes @ (scale[..., None] * along))[..., 0] @ inverse


def leave_out(
    slopes: Annotated[np.ndarray, "(n, p)"],
    error: Annotated[np.ndarray, "(n,)"],
    cluster: Annotated[np.ndarray, "(n,)"],
    precision: Annotated[np.ndarray, "(p,)"],
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Squared errors of clusters that are left out of a fit in turn, by its linearisation.

    slopes: less the derivatives of the error by the parameters.
    cluster: number of the cluster of each error, from 0 on.
    precision: 1 over the variance of the parameters' priors.
    Returns: share of each cluster in the mean square error, shape (clusters,); change of the parameters
    without each cluster, and `bias_reduced_share` of each cluster, shape (clusters, p).
    """
    normal = slopes.T @ slopes + np.diag(precision)
    squares, changes, shares = [], [], []
    for k in range(int(cluster.max()) + 1):
        rows, own = slopes[cluster == k], error[cluster == k]
        moment, information = rows.T @ own, rows.T @ rows
        change = np.linalg.solve(normal - information, -moment)
        changes.append(change)
        shares.append(bias_reduced_share(normal, information, moment))
        squares.append(np.sum((own - rows @ change) ** 2) / error.size)
    return np.array(squares), np.array(changes), np.array(shares)


def errors_over_blocks(
    regressors: Annotated[np.ndarray, "(n, p)"], residuals: np.ndarray, block: int
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Standard errors of least squares with blocks of time as clusters, and their degrees of freedom.

    Errors that are correlated across the borders of the blocks would be missed, so the variance is the mean
    over four sets of borders. Blocks that hardly move the solution hardly count: with v_j the variance that
    block j alone would add for white errors, the degrees of freedom are (sum v_j)^2 / sum v_j^2 - 1
    (Satterthwaite).

    residuals: residuals of the fit to all samples.
    block: length of a block (samples).

    Returns:
        errors, freedom: standard errors (unit of the residuals over units of the columns), and at least 1
        degree of freedom. Shape (p,).
        shares: shares of the blocks in the error (units of ``errors``), for the last set of borders. Shape
        (blocks, p).
    """
    scale = column_lengths(regressors)
    scaled = (regressors[part] / scale for part in spans(slice(0, residuals.size)))
    normal = sum(x.T @ x for x in scaled)
    inverse = np.linalg.inv(normal)
    squares, freedoms = [], []
    for first in np.round(block * np.arange(1, SHIFTS + 1) / SHIFTS).astype(int):
        borders = np.arange(first, residuals.size, block)
        parts = zip(np.split(regressors, borders), np.split(residuals, borders), strict=True)
        scaled = ((x / scale, rest) for x, rest in parts if len(rest))
        clusters = [(x.T @ x, x.T @ rest) for x, rest in scaled]
        information, moments = (np.array(x) for x in zip(*clusters, strict=True))
        shares = bias_reduced_share(normal, information, moments)
        squares.append(np.sum(np.square(shares), axis=0))
        added = np.einsum("ij,bjk,ki->bi", inverse, information, inverse)
        freedoms.append(added.sum(axis=0) ** 2 / np.sum(added**2, axis=0) - 1.0)
    errors, freedom = np.sqrt(np.mean(squares, axis=0)) / scale, np.maximum(np.mean(freedoms, axis=0), 1.0)
    return errors, freedom, shares / scale
