"""Generalised least squares (Aitken 1935) of several records that share their parameters.

    y_j = X_j b + e_j,   cov(e_j) = C_j,     b = N^-1 sum_j X_j' C_j^-1 y_j,   N = sum_j X_j' C_j^-1 X_j

C_j weights each part of a record by its reliability. A part of the data that no model describes, for example
a torque of unknown shape that begins at t_r, enters as a term of C_j: a Gaussian process of large variance
takes the residual from there on and leaves what precedes it to the parameters. That is the same as fitting it
with a smoothing spline of known stiffness (Wahba 1978): the integrated Wiener process is the prior of the
cubic one.
"""

from dataclasses import dataclass

import numpy as np


def integrated_wiener(time: np.ndarray, start_s: float) -> np.ndarray:
    """Covariance of an integrated Wiener process that is 0 until it starts, of unit intensity.

        cov(x(s), x(t)) = a^3 / 3 + |s - t| a^2 / 2,     a = min(s, t) - start

    Parameters
    ----------
    time : ndarray, shape (n,)
        Instants (s).
    start_s : float
        Start (s).

    Returns
    -------
    ndarray, shape (n, n)
        Covariance (s^3); the standard deviation a time T after the start is sqrt(T^3 / 3).
    """
    since = np.maximum(time - start_s, 0.0)
    common = np.minimum.outer(since, since)
    return common**3 / 3.0 + np.abs(np.subtract.outer(since, since)) * common**2 / 2.0


def squared_exponential(time: np.ndarray, length_s: float) -> np.ndarray:
    """Correlation exp(-(s - t)^2 / 2 l^2) of a smooth error, shape (n, n); ``time`` and l in s."""
    return np.exp(-0.5 * (np.subtract.outer(time, time) / length_s) ** 2)


@dataclass(frozen=True)
class Record:
    """One record of the fit.

    Attributes
    ----------
    target : ndarray, shape (..., n)
        y; leading axes are resampled versions of the record.
    regressors : ndarray, shape (..., n, p)
        X (unit of the target over the parameter's unit).
    covariance : ndarray, shape (n, n)
        C (unit of the target squared), positive definite.
    """

    target: np.ndarray
    regressors: np.ndarray
    covariance: np.ndarray


@dataclass(frozen=True)
class GeneralisedFit:
    """Parameters, and the matrices of their sensitivity to the data.

    Attributes
    ----------
    parameters : ndarray, shape (..., p)
        b.
    information : ndarray, shape (records, ..., p, p)
        X' C^-1 X of every record (1 over the units of the parameters squared).
    moments : ndarray, shape (records, ..., p)
        X' C^-1 y of every record (1 over the units of the parameters).
    weights : list of ndarray, shape (n, n)
        C^-1 of every record (1 over the unit of the target squared).
    """

    parameters: np.ndarray
    information: np.ndarray
    moments: np.ndarray
    weights: list[np.ndarray]

    def without_each(self) -> np.ndarray:
        """Parameters without one record after the other, shape (records, ..., p)."""
        n, b = self.information.sum(axis=0), self.moments.sum(axis=0)
        return np.linalg.solve(n - self.information, (b - self.moments)[..., None])[..., 0]


def generalised_least_squares(records: list[Record]) -> GeneralisedFit:
    """Fit records with common parameters.

    Parameters
    ----------
    records : list of Record
        With the same leading axes and number of parameters.

    Returns
    -------
    GeneralisedFit
        Parameters (units as the records imply).

    Raises
    ------
    numpy.linalg.LinAlgError
        If the records do not determine the parameters, or a covariance is singular.
    """
    weights = [np.linalg.inv(r.covariance) for r in records]
    weighted = [np.swapaxes(r.regressors, -1, -2) @ w for r, w in zip(records, weights, strict=True)]
    information = np.stack([x @ r.regressors for x, r in zip(weighted, records, strict=True)])
    moments = np.stack([(x @ r.target[..., None])[..., 0] for x, r in zip(weighted, records, strict=True)])
    parameters = np.linalg.solve(information.sum(axis=0), moments.sum(axis=0)[..., None])[..., 0]
    return GeneralisedFit(parameters, information, moments, weights)


def sensitivity(
    fit: GeneralisedFit,
    records: list[Record],
    target_slopes: list[np.ndarray],
    regressor_slopes: list[np.ndarray] | None = None,
) -> np.ndarray:
    """Change of the parameters with the data, to first order, with the weights kept.

        db = N^-1 sum_j [ X_j' C_j^-1 (dy_j - dX_j b) + dX_j' C_j^-1 (y_j - X_j b) ]

    Parameters
    ----------
    fit : GeneralisedFit
        Fit of ``records`` without leading axes.
    records : list of Record
        The records.
    target_slopes : list of ndarray, shape (..., n)
        dy of every record (unit of the target, per unit of what changes).
    regressor_slopes : list of ndarray, shape (..., n, p), optional
        dX of every record; 0 if left out.

    Returns
    -------
    ndarray, shape (..., p)
        db (units of the parameters, per unit of what changes).
    """
    total: np.ndarray | float = 0.0
    for k, (record, weight) in enumerate(zip(records, fit.weights, strict=True)):
        dy = target_slopes[k]
        if regressor_slopes is not None:
            dx = regressor_slopes[k]
            residual = record.target - record.regressors @ fit.parameters
            total = total + (np.swapaxes(dx, -1, -2) @ (weight @ residual)[..., None])[..., 0]
            dy = dy - dx @ fit.parameters
        total = total + dy @ (weight @ record.regressors)
    return np.linalg.solve(fit.information.sum(axis=0), np.asarray(total)[..., None])[..., 0]
