"""Least squares and instrumental variables for many noisy copies of a trial at once."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from tepsipe.errors import InputError
from tepsipe.mechanics.impedance_model import PARAMETERS
from tepsipe.statistics.least_squares import sems

RANK_TOLERANCE = 1e-14  # squared length of the residual of a regressor of unit length on the others

# ---- estimators --------------------------------------------------------------------------------


@dataclass(frozen=True)
class BatchedFits:
    """Fits to all perturbations of all draws."""

    parameters: Annotated[np.ndarray, "(..., 3)"]
    """I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad), per perturbation or over all of them."""
    residuals: Annotated[np.ndarray, "(..., w, s)", "N·m"]
    """tau - X p."""
    sem: Annotated[np.ndarray, "(..., 3, 3)"]
    """SEM of every fit, one row per reading of thesis eq (3-2) (`sems`), one column per parameter."""


def window_parameters(
    regressors: Annotated[np.ndarray, "(..., w, 3, s)"], torque: Annotated[np.ndarray, "(..., w, s)", "N·m"]
) -> tuple[np.ndarray, np.ndarray]:
    """Least squares over every window of every draw, by scaled normal equations solved all at once.

        G = S X'X S,   p = S G^-1 S X'tau,   S = diag(X'X)^(-1/2)

    With columns of unit length the three regressors are well conditioned, so the normal equations are
    nearly as accurate as an orthogonal factorisation. G has ones on its diagonal and a, b, c beside it;
    Gauss's elimination, y = S X'tau, runs over all windows at a time:

        d_2 = 1 - a^2,   e = c - a b,   d_3 = 1 - b^2 - e^2 / d_2
        q_3 = (y_3 - b y_1 - (y_2 - a y_1) e / d_2) / d_3
        q_2 = (y_2 - a y_1 - e q_3) / d_2,   q_1 = y_1 - a q_2 - b q_3,   p = S q
        diag(G^-1) = (1 - c^2, 1 - b^2, 1 - a^2) / (d_2 d_3)

    regressors: x' of every window (rad/s², rad/s, rad); without the axis of the draws if all draws share
    it.

    Returns:
        parameters: I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad). Shape (..., w, 3).
        inverse: diagonal of (X'X)^-1 (inverse squares of rad/s², rad/s and rad). Shape (..., w, 3).
    """
    columns = np.moveaxis(regressors, -2, 0)
    length = np.sqrt([np.vecdot(column, column) for column in columns])
    if not (length > 0.0).all():
        raise InputError(
            "perturbations: expected motion in every window, found none in one: check the windows"
        )
    a, b, c = (
        np.vecdot(columns[i], columns[j]) / (length[i] * length[j]) for i, j in ((0, 1), (0, 2), (1, 2))
    )
    d2, e = 1.0 - a * a, c - a * b
    with np.errstate(divide="ignore", invalid="ignore"):
        d3 = 1.0 - b * b - e * e / d2
    if not (d3 > RANK_TOLERANCE).all():
        raise InputError(
            f"perturbations: expected windows that determine {', '.join(PARAMETERS)}, found regressors that "
            "depend on each other: check the windows"
        )
    y1, y2, y3 = (
        y / norm for y, norm in zip(np.moveaxis(_moment(regressors, torque), -1, 0), length, strict=True)
    )
    y2 = y2 - a * y1
    q3 = (y3 - b * y1 - y2 * e / d2) / d3
    q2 = (y2 - e * q3) / d2
    q1 = y1 - a * q2 - b * q3
    inverse = np.stack([1.0 - c * c, 1.0 - b * b, d2]) / (d2 * d3 * length**2)
    return np.stack([q1, q2, q3], axis=-1) / np.moveaxis(length, 0, -1), np.moveaxis(inverse, 0, -1)


def _moment(regressors: np.ndarray, torque: np.ndarray) -> np.ndarray:
    """X'tau of every window, shape (..., w, 3); where draws share X, one product of matrices per window."""
    if regressors.ndim == torque.ndim + 1:
        return np.vecdot(regressors, torque[..., None, :])
    by_window = np.moveaxis(torque, -2, 0) @ np.swapaxes(regressors, -1, -2)
    return np.moveaxis(by_window, 0, -2)


def regress_windows(
    regressors: Annotated[np.ndarray, "(..., w, 3, s)"], torque: Annotated[np.ndarray, "(..., w, s)", "N·m"]
) -> BatchedFits:
    """`window_parameters` with residuals and SEM, whose N is the number of samples of the longest window.

    regressors: x' of every window (rad/s², rad/s, rad); without the axis of the draws if all draws share
    it.
    torque: tau.
    """
    parameters, inverse = window_parameters(regressors, torque)
    residuals = torque - (parameters[..., None, :] @ regressors)[..., 0, :]
    norm = np.linalg.norm(residuals, axis=-1)
    return BatchedFits(parameters, residuals, sems(norm, residuals.shape[-1], inverse))


def instrumental_variables(
    instruments: Annotated[np.ndarray, "(w, 3, s)"],
    regressors: Annotated[np.ndarray, "(..., w, 3, s)"],
    torque: Annotated[np.ndarray, "(..., w, s)", "N·m"],
) -> BatchedFits:
    """Instrumental-variable (IV) estimate per draw from all windows, with the belt motion as instrument.

        p = (sum Z'X)^-1 sum Z'tau

    The SEM uses (Z'X)^-1 Z'Z (X'Z)^-1 in place of (J'J)^-1.

    Returns: one fit per draw, residuals of every window.
    """
    scale = np.sqrt(np.sum(instruments**2, axis=(0, 2)))
    if not (scale > 0.0).all():
        raise InputError("belt: expected motion in the windows, found none: check the windows")
    z = instruments / scale[:, None]
    length = np.sqrt(np.sum(regressors**2, axis=(-3, -1)))
    cross = np.sum(z @ np.swapaxes(regressors, -1, -2), axis=-3) / length[..., None, :]
    moment = np.sum(z @ torque[..., None], axis=-3)
    inverse = np.linalg.inv(cross)
    parameters = (inverse @ moment)[..., 0] / length
    residuals = torque - (parameters[..., None, None, :] @ regressors)[..., 0, :]
    spread = inverse @ np.sum(z @ np.swapaxes(z, -1, -2), axis=0) @ np.swapaxes(inverse, -1, -2)
    norm = np.sqrt(np.sum(residuals**2, axis=(-2, -1)))
    count = residuals.shape[-1] * residuals.shape[-2]
    inverse = np.diagonal(spread, axis1=-2, axis2=-1) / length**2
    return BatchedFits(parameters, residuals, sems(norm, count, inverse))
