"""TEP-SIPE on simulated data with measurement noise (thesis sections 2-1-3, 3-1-3 and 4-1-3).

Symbols: theta leg angle from its rest, positive towards +y (rad); tau torque of the joint (N·m); y_f belt
motion (m); F the low-pass filter, D the derivative. m, r, I_l, g as in `inverse_dynamics`; p = m r,
J = I_l + m r^2 + I, k_g = m g r.

    J theta'' + B theta' + (K - k_g) theta = -p y_f''                             linearised motion
    tau = a y_f'' + b theta'' + c theta' + d theta                                any torque equation
    I* = b - a J / p,  B* = c - a B / p,  K* = d - a (K - k_g) / p                apparent I, B, K of a fit

Noise n is white and Gaussian; its variance is the power of the signal over the SNR. The filter and the
derivative are linear, F(theta + n) = F theta + F n, so the signal is filtered once, and F, D F and D D F are
applied to the noise of each draw around the windows only. The rates of the noise-free signal come from the
simulation, without an error of differentiation. Signals are filtered once per trial, and noise is drawn once
per trial, target and SNR; all processings share both.

Noise in theta'', theta', theta biases least squares (errors in variables). The belt motion
Z = (y_f'', y_f', y_f) drives the leg and is independent of the noise, so E Z'n = 0, and the
instrumental-variable (IV) estimate

    (I, B, K) = (sum Z'X)^-1 sum Z'tau,     X = (theta'', theta', theta), summed over all perturbations

is consistent for noise on tau, on theta and on both. It needs one 3 x 3 system per draw and only the belt
motion, which the treadmill records.

Prediction of torque and angle from noisy estimates.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from itertools import chain, product
from typing import Annotated

import numpy as np
import scipy

from tepsipe.errors import InputError, listed, quoted
from tepsipe.experiments.noise.filtered_noise import (
    PROCESSINGS,
    ROWS,
    FilteredTrial,
    WindowedTrial,
    cell_generators,
    filtered_trial,
    noise_chunks,
    windowed_trial,
)
from tepsipe.experiments.noise.trial import TORQUES, SimulatedTrial, apparent_impedance
from tepsipe.identification.regression.batched import instrumental_variables, regress_windows
from tepsipe.mechanics.impedance_model import PARAMETERS, UNITS
from tepsipe.mechanics.inverse_dynamics import Leg
from tepsipe.statistics.least_squares import SEM_READINGS


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


ROWS |= {name: slice(6 + k, 7 + k) for k, name in enumerate(TORQUES)}


# ---- one cell ----------------------------------------------------------------------------------


@dataclass(frozen=True)
class NoiseCell:
    """Results of one condition, noise target, SNR and processing, draw by draw."""

    condition: str
    noise_on: str
    estimator: str
    """Trial, noise target, name of the processing."""
    snr_db: float
    """Signal power over noise power."""
    parameters: Annotated[np.ndarray, "(d, 3)"]
    """Mean over the perturbations of I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad)."""
    sem: Annotated[np.ndarray, "(d, 3, 3)"]
    """SEM of one perturbation, mean over the perturbations, by reading of thesis eq (3-2) and parameter."""
    vaf_perturbation: Annotated[np.ndarray, "(d,)", "%"]
    """VAF of the noise-free torque, predicted from the parameters and noisy motion of every perturbation,
    mean."""
    vaf_trial: Annotated[np.ndarray, "(d,)", "%"]
    """The same over the whole trial with the mean parameters, expected value over the noise."""
    vaf_cross_validated: Annotated[np.ndarray, "(d,)", "%"] | None
    """`cross_validated_vaf` of the other trials."""
    vaf_theta_perturbation: Annotated[np.ndarray, "(e,)"]
    vaf_theta_trial: Annotated[np.ndarray, "(e,)"]
    """VAF of the angle predicted from the belt with the parameters of the first e draws, in the windows and
    over the trial (%); NaN where the leg falls."""
    unstable_fraction: float
    """Fraction of all draws for which the leg falls."""
    truth: Annotated[np.ndarray, "(3,)"]
    without_noise: Annotated[np.ndarray, "(3,)"]
    apparent: Annotated[np.ndarray, "(3,)"]
    """I, B, K (units as ``parameters``) of the joint; by the same processing without noise; apparent values
    by the printed equation of the foot without processing (`apparent_impedance`)."""

    @property
    def mean(self) -> np.ndarray:
        """Mean over draws of I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad), shape (3,)."""
        return self.parameters.mean(axis=0)

    @property
    def sd(self) -> np.ndarray:
        """Standard deviation over draws (units of I, B, K), shape (3,); 0 for a single draw."""
        return self.parameters.std(axis=0, ddof=1) if self.n_draws > 1 else np.zeros(3)

    @property
    def bias(self) -> np.ndarray:
        """Mean minus truth (units of I, B, K), shape (3,)."""
        return self.mean - self.truth

    @property
    def n_draws(self) -> int:
        """Number of draws."""
        return self.parameters.shape[0]

    def rows(self) -> list[dict]:
        """Tidy rows: condition, noise_on, snr_db, estimator, quantity, unit, mean, sd, bias, n_draws.

        VAFs of the angle are 0 % where they are negative or the leg falls, as in the thesis.
        """
        head = {
            "condition": self.condition,
            "noise_on": self.noise_on,
            "snr_db": self.snr_db,
            "estimator": self.estimator,
        }
        columns = [
            (q, UNITS[q], self.parameters[:, k], float(self.bias[k])) for k, q in enumerate(PARAMETERS)
        ]
        columns += [
            (f"SEM_{reading}_{q}", "-" if reading == "norm" else UNITS[q], self.sem[:, r, k], None)
            for r, reading in enumerate(SEM_READINGS)
            for k, q in enumerate(PARAMETERS)
        ]
        columns += [
            ("VAF_perturbation", "%", self.vaf_perturbation, None),
            ("VAF_trial", "%", self.vaf_trial, None),
            ("VAF_theta_perturbation", "%", clipped(self.vaf_theta_perturbation), None),
            ("VAF_theta_trial", "%", clipped(self.vaf_theta_trial), None),
            ("unstable_fraction", "-", np.array([self.unstable_fraction]), None),
        ]
        if self.vaf_cross_validated is not None:
            columns.append(("VAF_cross_validated", "%", self.vaf_cross_validated, None))
        return [
            head
            | {
                "quantity": quantity,
                "unit": unit,
                "mean": float(values.mean()),
                "sd": float(values.std(ddof=1)) if values.size > 1 else 0.0,
                "bias": bias,
                "n_draws": self.n_draws,
            }
            for quantity, unit, values, bias in columns
        ]


def estimate_draws(
    windowed: Sequence[WindowedTrial], chunks: Iterable[dict[str, np.ndarray]]
) -> list[tuple[np.ndarray, ...]]:
    """Estimate the parameters of every draw of the noise, by every processing of a trial.

    windowed: one trial without noise, by every processing.
    chunks: draws of the noise, as from `noise_chunks`; [{}] is a single one without noise.
    Returns: for every processing: I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad), means over the perturbations,
    shape (draws, 3); SEM by the readings of thesis eq (3-2), means over the perturbations, shape
    (draws, 3, 3); the VAF of the torque without noise, mean over the perturbations (%), shape (draws,).
    """
    by_chunk = [[_estimate_chunk(one, chunk) for one in windowed] for chunk in chunks]
    return [tuple(map(np.concatenate, zip(*fits, strict=True))) for fits in zip(*by_chunk, strict=True)]


def _estimate_chunk(windowed: WindowedTrial, chunk: dict[str, np.ndarray]) -> tuple[np.ndarray, ...]:
    noise, regressors = np.zeros((1, 1, 1)), windowed.regressors
    if "tau" in chunk:
        noise = windowed.torque_noise(chunk["tau"])
    if "theta" in chunk:
        regressors = regressors + windowed.regressor_noise(chunk["theta"])
    if windowed.estimator == "instrumental-variables":
        fits = instrumental_variables(windowed.instruments, regressors, windowed.torque + noise)
        estimates = fits.parameters, fits.sem
    else:
        fits = regress_windows(regressors, windowed.torque + noise)
        estimates = fits.parameters.mean(axis=1), fits.sem.mean(axis=1)
    missed = fits.residuals - noise  # of the torque without noise
    unexplained = np.sum(missed**2, axis=-1) / np.sum(windowed.torque**2, axis=-1)
    return *estimates, 100.0 * (1.0 - unexplained).mean(axis=1)


def sweep(
    trial: FilteredTrial,
    noise_on: str,
    snr_db: float,
    draws: int,
    seed: int,
    estimators: Sequence[str],
    others: Sequence[FilteredTrial] = (),
    predicted_draws: int = 25,
) -> list[NoiseCell]:
    """Estimates from many draws of one noise by several processings, in batches over all perturbations.

    The noise depends only on the seed, the name of the trial, the noise target and the SNR. Cells may be
    computed in any order, and all processings have the same noise.

    noise_on: {"none", "tau", "theta", "both"}: Signals with noise; a single draw is taken for "none".
    snr_db: signal power over noise power (dB); ignored for the target "none".
    seed: seed of the study.
    estimators: names of `PROCESSINGS`.
    predicted_draws: number of draws for which the angle is also predicted.
    Returns: one for every estimator, draw by draw.
    """
    for name in estimators:
        if name not in PROCESSINGS:
            raise InputError(
                f"estimator: expected one of {listed(PROCESSINGS)}, found {quoted(name)}: correct it"
            )
    if draws < 1:
        raise InputError(f"noise: expected one draw or more, found {draws}: ask for more")
    simulated = trial.simulated
    windowed = [windowed_trial(trial, PROCESSINGS[name], noise_on, snr_db) for name in estimators]
    generators = cell_generators(seed, simulated.name, noise_on, f"{snr_db:g}")
    drawn = estimate_draws(windowed, noise_chunks(trial, noise_on, draws, generators))
    silent = estimate_draws(windowed, [{}])
    cells = []
    for k, name in enumerate(estimators):
        parameters, sem, vaf_perturbation = drawn[k]
        in_windows, in_trial = angle_vafs(simulated, parameters[:predicted_draws])
        validated = None
        if others:
            unseen = (windowed_trial(other, PROCESSINGS[name], noise_on, snr_db) for other in others)
            validated = cross_validated_vaf(parameters, unseen)
        cells.append(
            NoiseCell(
                condition=simulated.name,
                noise_on=noise_on,
                estimator=name,
                snr_db=float(snr_db),
                parameters=parameters,
                sem=sem,
                vaf_perturbation=vaf_perturbation,
                vaf_trial=torque_vaf(parameters, windowed[k].gram, windowed[k].noise_gram, False),
                vaf_cross_validated=validated,
                vaf_theta_perturbation=in_windows,
                vaf_theta_trial=in_trial,
                unstable_fraction=float(np.mean(~is_stable(simulated.leg, parameters))),
                truth=np.asarray(simulated.truth, dtype=float),
                without_noise=silent[k][0][0],
                apparent=apparent_impedance(simulated.leg, simulated.foot, simulated.truth),
            )
        )
    return cells


def sweep_trial(
    trial: SimulatedTrial,
    levels_db: dict[str, list[float]],
    draws: int,
    seed: int,
    others: Iterable[SimulatedTrial],
    predicted_draws: int,
    cutoff_hz: float = 20.0,
    order: int = 4,
) -> list[NoiseCell]:
    """All cells of one trial: every processing without noise and with every noise target and level.

    levels_db: name of one of `PROCESSINGS` -> signal power over noise power.
    draws, seed: as for `sweep`.
    predicted_draws: as for `sweep`.
    cutoff_hz: cutoff of the low-pass filter.
    order: order of the filter, both passes together.
    Returns: as `sweep` gives them, processing by processing.
    """
    wanted = {
        name: [("none", levels[0]), *product(("tau", "theta", "both"), levels)]
        for name, levels in levels_db.items()
    }
    filtered = filtered_trial(trial, cutoff_hz, order)
    filtered_others = [filtered_trial(other, cutoff_hz, order) for other in others]
    made = {}
    for noise in dict.fromkeys(chain(*wanted.values())):
        names = [name for name, noises in wanted.items() if noise in noises]
        for cell in sweep(filtered, *noise, draws, seed, names, filtered_others, predicted_draws):
            made[cell.estimator, noise] = cell
    return [made[name, noise] for name, noises in wanted.items() for noise in noises]
