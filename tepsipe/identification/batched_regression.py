"""Least squares and instrumental variables for many noisy copies of a trial at once."""

from dataclasses import dataclass

import numpy as np

from tepsipe.errors import InputError
from tepsipe.mechanics.impedance_model import PARAMETERS

# ---- estimators --------------------------------------------------------------------------------


@dataclass(frozen=True)
class BatchedFits:
    """Fits to all perturbations of all draws.

    Attributes
    ----------
    parameters : ndarray, shape (..., 3)
        I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad), per perturbation or over all of them.
    residuals : ndarray, shape (..., w, s)
        tau - X p (N·m).
    sem_as_printed : ndarray, shape (..., 3)
        Thesis eq (3-2) of every fit; its unit is that of the parameter over the square root of N·m.
    """

    parameters: np.ndarray
    residuals: np.ndarray
    sem_as_printed: np.ndarray


def window_parameters(regressors: np.ndarray, torque: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Least squares over every window of every draw, by scaled normal equations solved in one batch.

        G = S X'X S,   p = S G^-1 S X'tau,   S = diag(X'X)^(-1/2)

    With columns of unit length the three regressors are well conditioned, so the normal equations are
    nearly as accurate as an orthogonal factorisation.

    Parameters
    ----------
    regressors : ndarray, shape (..., w, 3, s)
        X' of every window (rad/s², rad/s, rad); without the axis of the draws if all draws share it.
    torque : ndarray, shape (..., w, s)
        tau (N·m).

    Returns
    -------
    parameters : ndarray, shape (..., w, 3)
        I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad).
    gram : ndarray, shape (..., w, 3, 3)
        X'X (products of rad/s², rad/s and rad).

    Raises
    ------
    InputError
        If a window does not determine the parameters.
    """
    # vecdot, because matmul takes a slow path for the product of a small matrix with its transpose
    gram = np.vecdot(regressors[..., :, None, :], regressors[..., None, :, :])
    moment = np.vecdot(regressors, torque[..., None, :])
    length = np.sqrt(np.diagonal(gram, axis1=-2, axis2=-1))
    if not (length > 0.0).all():
        raise InputError(
            "perturbations: expected motion in every window, found none in one: check the windows"
        )
    scaled = gram / (length[..., :, None] * length[..., None, :])
    try:
        return np.linalg.solve(scaled, (moment / length)[..., None])[..., 0] / length, gram
    except np.linalg.LinAlgError as error:
        raise InputError(
            f"perturbations: expected windows that determine {', '.join(PARAMETERS)}, found regressors that "
            "depend on each other: check the windows"
        ) from error


def regress_windows(regressors: np.ndarray, torque: np.ndarray) -> BatchedFits:
    """`window_parameters` with residuals and SEM.

    Parameters
    ----------
    regressors : ndarray, shape (..., w, 3, s)
        X' of every window (rad/s², rad/s, rad); without the axis of the draws if all draws share it.
    torque : ndarray, shape (..., w, s)
        tau (N·m).

    Returns
    -------
    BatchedFits
        One fit per window (units there).
    """
    parameters, gram = window_parameters(regressors, torque)
    residuals = torque - (parameters[..., None, :] @ regressors)[..., 0, :]
    norm = np.linalg.norm(residuals, axis=-1)[..., None]
    inverse = np.diagonal(np.linalg.inv(gram), axis1=-2, axis2=-1)
    return BatchedFits(parameters, residuals, np.sqrt(norm * inverse))


def instrumental_variables(
    instruments: np.ndarray, regressors: np.ndarray, torque: np.ndarray
) -> BatchedFits:
    """Instrumental-variable (IV) estimate per draw from all windows, with the belt motion as instrument.

        p = (sum Z'X)^-1 sum Z'tau

    The SEM uses (Z'X)^-1 Z'Z (X'Z)^-1 in place of (J'J)^-1.

    Parameters
    ----------
    instruments : ndarray, shape (w, 3, s)
        Z' of every window (m/s², m/s, m).
    regressors : ndarray, shape (..., w, 3, s)
        X' of every window (rad/s², rad/s, rad).
    torque : ndarray, shape (..., w, s)
        tau (N·m).

    Returns
    -------
    BatchedFits
        One fit per draw (units there), residuals of every window.

    Raises
    ------
    InputError
        If the belt did not move.
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
    norm = np.sqrt(np.sum(residuals**2, axis=(-2, -1)))[..., None]
    sem = np.sqrt(norm * np.diagonal(spread, axis1=-2, axis2=-1)) / length
    return BatchedFits(parameters, residuals, sem)
