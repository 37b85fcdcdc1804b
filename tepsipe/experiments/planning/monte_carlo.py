"""Check of a plan: noise is drawn again and again, and the real estimators fit what was drawn."""

from typing import Annotated

import numpy as np

from tepsipe.experiments.planning.design import (
    FOOT,
    JOINT_LIKELIHOOD,
    LEG,
    Design,
    ExpectedMotion,
    exact_markers,
)
from tepsipe.experiments.planning.filtering import filtered, filtered_motion, late
from tepsipe.identification.likelihood_fit import fit_joint_likelihood
from tepsipe.identification.regression.windows import regress_torque
from tepsipe.mechanics.inverse_dynamics import foot_torque, leg_torque
from tepsipe.signals.differentiation import derivative


def draw_estimates(
    design: Design, motion: ExpectedMotion, rng: np.random.Generator, draws: int
) -> Annotated[np.ndarray, "(draws, 3)"]:
    """Estimates of I, B, K from trials that differ in their noise only.

    Returns: I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad).
    """
    positions, labels, fixed = exact_markers(design, motion)
    of_windows = design.protocol.pathway in (LEG, FOOT)
    estimates = np.empty((draws, 3))
    for k in range(draws):
        noisy = positions + design.rig.marker_noise_m * rng.standard_normal(positions.shape)
        if of_windows:
            estimates[k] = _by_windows(design, motion, noisy, labels, rng)
        else:
            estimates[k] = _by_likelihood(design, motion, noisy, labels, fixed, rng)
    return estimates


def _by_likelihood(design, motion, positions, labels, fixed, rng) -> np.ndarray:
    noise = design.rig.log_noise_of_sample_m_per_s
    log = motion.simulated.foot_y_d + noise * rng.standard_normal(motion.time.size)
    fit = fit_joint_likelihood(
        motion.time,
        positions,
        design.rig.leg_markers,
        design.leg,
        labels=labels,
        belt_fixed=fixed,
        perturbations=motion.perturbations,
        belt_velocity=log,
        rest=motion.at_rest,
        softening=design.protocol.pathway == JOINT_LIKELIHOOD,
    )
    return np.array([fit.I, fit.B, fit.K])


def _by_windows(design, motion, positions, labels, rng) -> np.ndarray:
    rig, lowpass, rate = design.rig, design.protocol.lowpass, design.rig.camera_rate_hz
    of_leg = filtered_motion(motion.time, positions, labels, rig.leg_markers, design.leg.com_m, lowpass)
    if design.protocol.pathway == LEG:
        torque = leg_torque(design.leg, of_leg.theta, of_leg.theta_dd, of_leg.y_dd, of_leg.z_dd)
    else:
        per_sample = np.sqrt(rate / rig.plate_rate_hz)

        def noisy(x: np.ndarray, noise: float) -> np.ndarray:
            return filtered(x + per_sample * noise * rng.standard_normal(x.size), lowpass, rate)

        simulated, ankle = motion.simulated, labels.index(rig.leg_markers.labels[0])
        y_a = filtered(positions[:, ankle, 0], lowpass, rate)
        torque = foot_torque(
            design.foot,
            noisy(simulated.f_y, rig.force_noise_N),
            noisy(simulated.f_z, rig.force_noise_N),
            noisy(simulated.m_x, rig.moment_noise_Nm),
            y_a,
            derivative(motion.time, derivative(motion.time, y_a)),
        )
    windows = late(motion.perturbations, lowpass, rate)
    return regress_torque(of_leg, torque, windows, motion.at_rest).mean
