"""Generalised least squares (Aitken 1935) of several records that share their parameters.

    y_j = X_j b + e_j,   cov(e_j) = C_j,     b = N^-1 sum_j X_j' C_j^-1 y_j,   N = sum_j X_j' C_j^-1 X_j

C_j weights each part of a record by its reliability. A part of the data that no model describes, for example
a torque of unknown shape that begins at t_r, enters as a term of C_j: a Gaussian process of large variance
takes the residual from there on and leaves what precedes it to the parameters. That is the same as fitting it
with a smoothing spline of known stiffness (Wahba 1978): the integrated Wiener process is the prior of the
cubic one.

Noise in the regressors attenuates the parameters (errors in variables; Fuller 1987). If the moments of the
noise are known, M_xx within the regressors and M_xy between regressors and target, they are subtracted:

    N = sum_j X_j' H_j X_j - tr(H_j M_xx),     b = N^-1 sum_j (X_j' H_j y_j - tr(H_j M_xy)),     H_j = C_j^-1

The estimate is then consistent. With much noise, however, N is a small difference of two large terms, and the
estimate has heavy tails. Instruments Z are signals that resemble the regressors and are free of their noise
(Reiersol 1945). The weighted projection on them

    H_j = C_j^-1 Z_j (Z_j' C_j^-1 Z_j)^-1 Z_j' C_j^-1

removes most of the noise before it is squared, and little remains to be subtracted: two-stage least squares
without its bias in finite samples.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np


def integrated_wiener(
    time: Annotated[np.ndarray, "(n,)", "s"], start_s: float
) -> Annotated[np.ndarray, "(n, n)"]:
    """Covariance of an integrated Wiener process that is 0 until it starts, of unit intensity.

        cov(x(s), x(t)) = a^3 / 3 + |s - t| a^2 / 2,     a = min(s, t) - start

    Returns: covariance (s^3); the standard deviation a time T after the start is sqrt(T^3 / 3).
    """
    since = np.maximum(time - start_s, 0.0)
    common = np.minimum.outer(since, since)
    return common**3 / 3.0 + np.abs(np.subtract.outer(since, since)) * common**2 / 2.0


def squared_exponential(time: np.ndarray, length_s: float) -> np.ndarray:
    """Correlation exp(-(s - t)^2 / 2 l^2) of a smooth error, shape (n, n); ``time`` and l in s."""
    return np.exp(-0.5 * (np.subtract.outer(time, time) / length_s) ** 2)


@dataclass(frozen=True)
class Record:
    """One record of the fit."""

    target: Annotated[np.ndarray, "(n,)"]
    """y."""
    regressors: Annotated[np.ndarray, "(n, p)"]
    """X (unit of the target over the parameter's unit)."""
    covariance: Annotated[np.ndarray, "(n, n)"]
    """C (unit of the target squared), positive definite."""
    instruments: Annotated[np.ndarray, "(n, m)"] | None = None
    """Z, m >= p (any units); without them H = C^-1."""
    noise: tuple[np.ndarray, np.ndarray] | None = None
    """Moments M_xx of the noise of the regressors at all pairs of instants, and M_xy of theirs with that of
    the target (products of their units); 0 if left out, shape (p, p, n, n)."""

    @property
    def weight(self) -> np.ndarray:
        """H, shape (n, n) (1 over the unit of the target squared)."""
        inverse = np.linalg.inv(self.covariance)
        if self.instruments is None:
            return inverse
        scaled = self.instruments / np.abs(self.instruments).max(axis=0)
        weighted = inverse @ scaled
        return weighted @ np.linalg.solve(scaled.T @ weighted, weighted.T)


@dataclass(frozen=True)
class GeneralisedFit:
    """Parameters, and the matrices of their sensitivity to the data."""

    parameters: Annotated[np.ndarray, "(p,)"]
    information: Annotated[np.ndarray, "(records, p, p)"]
    """X' H X of every record, less that of the noise (1 over the units of the parameters squared)."""
    moments: Annotated[np.ndarray, "(records, p)"]
    """X' H y of every record, less that of the noise (1 over the units of the parameters)."""
    weights: list[np.ndarray]
    """H of every record (1 over the unit of the target squared), shape (n, n)."""
    noise_information: Annotated[np.ndarray, "(records, p, p)"]
    noise_moments: Annotated[np.ndarray, "(records, p, p)"]
    """What was subtracted (units as above)."""

    @property
    def noise_share(self) -> float:
        """Largest share of noise in what the regressors seem to say of any combination of parameters (-)."""
        noise = self.noise_information.sum(axis=0)
        shares = np.linalg.eigvals(np.linalg.solve(self.information.sum(axis=0) + noise, noise))
        return float(shares.real.max())

    def without_each(self, groups: Sequence[Sequence[int]] | None = None) -> np.ndarray:
        """Parameters without one record after the other, or one group of them, shape (groups, p)."""
        chosen = [[k] for k in range(len(self.information))] if groups is None else groups
        left = (
            np.stack([x.sum(axis=0) - x[list(own)].sum(axis=0) for own in chosen])
            for x in (self.information, self.moments)
        )
        n, b = left
        return np.linalg.solve(n, b[..., None])[..., 0]


def generalised_least_squares(records: list[Record]) -> GeneralisedFit:
    """Fit records with common parameters.

    records: with the same number of parameters.
    """
    weights = [r.weight for r in records]
    weighted = [np.swapaxes(r.regressors, -1, -2) @ w for r, w in zip(records, weights, strict=True)]
    noise = [_of_noise(r, w) for r, w in zip(records, weights, strict=True)]
    information = [x @ r.regressors - n for x, r, (n, _) in zip(weighted, records, noise, strict=True)]
    moments = [
        (x @ r.target[..., None])[..., 0] - m for x, r, (_, m) in zip(weighted, records, noise, strict=True)
    ]
    left, right = np.stack(information), np.stack(moments)
    parameters = np.linalg.solve(left.sum(axis=0), right.sum(axis=0)[..., None])[..., 0]
    return GeneralisedFit(parameters, left, right, weights, *map(np.stack, zip(*noise, strict=True)))


def _of_noise(record: Record, weight: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """What the noise of a record adds to X' H X and X' H y."""
    if record.noise is None:
        p = record.regressors.shape[-1]
        return np.zeros((p, p)), np.zeros(p)
    of_regressors, with_target = record.noise
    return np.einsum("st,abst->ab", weight, of_regressors), np.einsum("st,ast->a", weight, with_target)


def sensitivity(
    fit: GeneralisedFit,
    records: list[Record],
    target_slopes: list[np.ndarray | None],
    regressor_slopes: list[np.ndarray | None] | None = None,
) -> Annotated[np.ndarray, "(..., p)"]:
    """Change of the parameters with the data, to first order, with the weights kept.

        db = N^-1 sum_j [ X_j' H_j (dy_j - dX_j b) + dX_j' H_j (y_j - X_j b) ]

    fit: fit of ``records``.
    target_slopes: dy of every record (unit of the target, per unit of what changes), None for a record that
    does not change; leading axes: changes.
    regressor_slopes: dX of every record that changes; 0 if left out.
    Returns: db (units of the parameters, per unit of what changes).
    """
    total: np.ndarray | float = 0.0
    for k, (record, weight) in enumerate(zip(records, fit.weights, strict=True)):
        dy = target_slopes[k]
        if dy is None:
            continue
        if regressor_slopes is not None:
            dx = regressor_slopes[k]
            residual = record.target - record.regressors @ fit.parameters
            total = total + (np.swapaxes(dx, -1, -2) @ (weight @ residual)[..., None])[..., 0]
            dy = dy - dx @ fit.parameters
        total = total + dy @ (weight @ record.regressors)
    return np.linalg.solve(fit.information.sum(axis=0), np.asarray(total)[..., None])[..., 0]
