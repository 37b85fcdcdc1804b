"""Prediction of torque and angle from noisy estimates."""

from collections.abc import Iterable
from typing import Annotated

import numpy as np
import scipy

from tepsipe.errors import InputError
from tepsipe.experiments.noise.filtered_noise import WindowedTrial
from tepsipe.experiments.noise.trial import SimulatedTrial
from tepsipe.mechanics.inverse_dynamics import Leg

# ---- predictions -------------------------------------------------------------------------------


def is_stable(leg: Leg, parameters: Annotated[np.ndarray, "(..., 3)"]) -> Annotated[np.ndarray, "(...)"]:
    """Test for a stable leg on the joint: J, B and K - k_g are all positive.

    Returns: true where stable.
    """
    p = leg.mass_kg * leg.com_m
    leg_terms = np.array([leg.inertia_kgm2 + p * leg.com_m, 0.0, -p * leg.gravity_m_per_s2])
    return (parameters + leg_terms > 0.0).all(axis=-1)


def predict_angle(
    leg: Leg,
    parameters: Annotated[np.ndarray, "(d, 3)"],
    belt_velocity: Annotated[np.ndarray, "(n,)", "m/s"],
    rate_hz: float,
) -> Annotated[np.ndarray, "(d, n)"]:
    """Angle of a leg that starts at rest, from the linearised motion driven by the belt.

    With w = J theta' + B theta + p y_f' the acceleration of the belt is not needed:

        theta' = (w - B theta - p y_f') / J,   w' = -(K - k_g) theta

    solved exactly for a belt velocity that is linear between its samples.

    Returns: theta (rad); NaN where the leg is not stable.
    """
    p = leg.mass_kg * leg.com_m
    inertia, damping, stiffness = np.asarray(parameters, dtype=float).T
    about_ankle = leg.inertia_kgm2 + p * leg.com_m + inertia
    stable = is_stable(leg, np.asarray(parameters))
    # states theta, w, input u and its change du over a sample: theta_k+1, w_k+1 = A x + b u + c du
    block = np.zeros((stable.size, 4, 4))
    with np.errstate(divide="ignore", invalid="ignore"):
        block[:, 0, :3] = np.stack([-damping, np.ones_like(damping), np.full_like(damping, -p)], axis=1)
        block[:, 0, :3] /= about_ankle[:, None]
    block[:, 1, 0] = p * leg.gravity_m_per_s2 - stiffness
    block[:, 2, 3] = rate_hz
    block[~stable] = 0.0
    step = scipy.linalg.expm(block / rate_hz)
    a, b, c = step[:, :2, :2], step[:, :2, 2], step[:, :2, 3]
    trace, determinant = a[:, 0, 0] + a[:, 1, 1], np.linalg.det(a)
    # the same as a recursion in theta alone: theta_k depends on u_k by c, on u_k-1 by b - c, through A
    shifted = (a @ c[..., None])[..., 0] + b - c
    numerator = np.stack(
        [c[:, 0], shifted[:, 0] - trace * c[:, 0], (a @ shifted[..., None])[:, 0, 0] - trace * shifted[:, 0]],
        axis=1,
    )
    numerator[:, 2] += determinant * c[:, 0]
    theta = np.full((stable.size, belt_velocity.size), np.nan)
    for k in np.flatnonzero(stable):
        theta[k] = scipy.signal.lfilter(numerator[k], [1.0, -trace[k], determinant[k]], belt_velocity)
    return theta


def torque_vaf(
    parameters: Annotated[np.ndarray, "(..., 3)"],
    gram: Annotated[np.ndarray, "(4, 4)"],
    noise_gram: Annotated[np.ndarray, "(4, 4)"],
    torque_noise: bool,
) -> Annotated[np.ndarray, "(...)", "%"]:
    """Expected VAF of the torque over a whole trial, from sums of products alone.

    gram, noise_gram: gram matrices of signals and noise (`WindowedTrial`), products of rad/s², rad/s, rad
    and N·m.
    torque_noise: whether the torque to be predicted includes noise.
    Returns: uncentred VAF.
    """
    weights = np.concatenate([-parameters, np.ones((*parameters.shape[:-1], 1))], axis=-1)
    total = gram + noise_gram
    if not torque_noise:
        total = total - np.diag([0.0, 0.0, 0.0, noise_gram[3, 3]])
    residual = np.einsum("...i,ij,...j->...", weights, total, weights)
    return 100.0 * (1.0 - residual / total[3, 3])


def cross_validated_vaf(
    parameters: Annotated[np.ndarray, "(..., 3)"], others: Iterable[WindowedTrial]
) -> Annotated[np.ndarray, "(...)", "%"]:
    """VAF of the noisy torque of other trials, predicted from given parameters and their noisy motion.

    parameters: I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad), for example of every draw.
    others: trials to predict, with the processing and noise of the parameters.
    Returns: mean over the trials of the expected VAF over the whole trial.
    """
    vafs = [torque_vaf(parameters, other.gram, other.noise_gram, True) for other in others]
    if not vafs:
        raise InputError("cross-validation: expected other trials, found none: simulate a second one")
    return np.mean(vafs, axis=0)


def clipped(vaf_percent: np.ndarray) -> np.ndarray:
    """VAF (%) with 0 in place of negative values and NaN, shape of ``vaf_percent``."""
    return np.maximum(np.nan_to_num(vaf_percent, nan=0.0), 0.0)


def angle_vafs(
    trial: SimulatedTrial, parameters: Annotated[np.ndarray, "(d, 3)"]
) -> tuple[np.ndarray, np.ndarray]:
    """VAF of the noise-free simulated angle, predicted from the belt with given parameters.

    Returns: mean over the perturbations, and over the whole trial (%); NaN where the leg falls.
    """
    missed = predict_angle(trial.leg, parameters, trial.y_foot_d, trial.rate_hz)
    missed -= trial.theta  # in place, as there are many samples
    missed **= 2
    power = trial.theta**2
    in_windows = [1.0 - missed[:, a:b].sum(axis=1) / power[a:b].sum() for a, b in trial.windows]
    return 100.0 * np.mean(in_windows, axis=0), 100.0 * (1.0 - missed.sum(axis=1) / power.sum())
