"""Fit I, B, K to a spectral estimate of the joint's admittance (thesis eqs 3-5 and 3-6, Table 3-2).

    e(f) = sqrt(Gamma(f) / f) |log( H_estimate(f) / H_model(f) )|,    minimise sum of e^2

log is the complex logarithm, so e weighs gain and phase alike. The thesis's text above the equation has
sqrt(1 / f) Gamma instead, which is the same for a squared coherence.
"""

from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
import scipy

from tepsipe.mechanics.impedance_model import admittance, smeared_admittance
from tepsipe.signals.response import FrequencyResponse
from tepsipe.statistics.least_squares import sems

# typical magnitude of I, B, K for the scaled solver (N·m·s²/rad, N·m·s/rad, N·m/rad)
TYPICAL = np.array([0.01, 0.1, 10.0])
# starting values, lower and upper bounds of I, B, K in the thesis (N·m·s²/rad, N·m·s/rad, N·m/rad)
TABLE_3_2 = ((0.001, 0.1, 10.0), (-10.0, 0.01, -20.0), (10.0, 10.0, 20.0))


@dataclass(frozen=True)
class Bounds:
    """Starting values and bounds of the fit (thesis Table 3-2)."""

    start: Annotated[np.ndarray, "(3,)"]
    lower: Annotated[np.ndarray, "(3,)"]
    upper: Annotated[np.ndarray, "(3,)"]
    """I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad)."""


@dataclass(frozen=True)
class AdmittanceFit:
    """Fitted I, B, K."""

    parameters: Annotated[np.ndarray, "(3,)"]
    start: Annotated[np.ndarray, "(3,)"]
    """Estimate and starting values: I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad)."""
    cost: float
    """Sum of e^2; the thesis calls it error."""
    sem: Annotated[np.ndarray, "(3, 3)"]
    """SEM of I, B, K, one row per reading of thesis eq (3-2) (`sems`)."""
    degrees_of_freedom: int
    """Number of residuals less three parameters."""
    converged: bool
    """Whether the solver met its tolerances."""
    at_bound: bool
    """Whether an estimate lies at one of its bounds."""

    @property
    def sem_as_printed(self) -> Annotated[np.ndarray, "(3,)"]:
        """Thesis eq (3-2) with the Euclidean norm."""
        return self.sem[0]

    @property
    def standard_error(self) -> Annotated[np.ndarray, "(3,)"]:
        """Standard error for white residuals (units of the parameters)."""
        return self.sem[2]


def starting_values(estimate: FrequencyResponse) -> Annotated[np.ndarray, "(3,)"]:
    """Starting values of I, B, K by linear least squares of 1/H = K - I w^2 + j B w.

    Every frequency is weighted by its coherence and by 1/H itself; I and B are kept positive.

    estimate: admittance H at the frequencies to fit.
    Returns: I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad).
    """
    omega, impedance = 2.0 * np.pi * estimate.frequency_hz, 1.0 / estimate.response
    weight = np.sqrt(estimate.coherence) / np.abs(impedance)
    columns = np.column_stack([-weight * omega**2, weight])
    inertia, stiffness = np.linalg.lstsq(columns, weight * impedance.real, rcond=None)[0]
    damping = np.sum(weight**2 * omega * impedance.imag) / np.sum((weight * omega) ** 2)
    return np.array([max(inertia, 1e-9), max(damping, 1e-9), stiffness])


def residuals(
    parameters: Annotated[np.ndarray, "(3,)"], estimate: FrequencyResponse
) -> Annotated[np.ndarray, "(2 n,)"]:
    """Weighted complex log ratio, real parts first, then imaginary parts.

    Its sum of squares is the sum of e^2 of thesis eq (3-6). Unlike the modulus it is differentiable where
    the model equals the estimate.

    estimate: the n frequencies to fit.
    """
    weight = np.sqrt(estimate.coherence / estimate.frequency_hz)
    ratio = np.log(estimate.response / admittance(parameters, estimate.frequency_hz))
    return np.concatenate([weight * ratio.real, weight * ratio.imag])


def residuals_as_printed(
    parameters: Annotated[np.ndarray, "(3,)"], estimate: FrequencyResponse
) -> np.ndarray:
    """e(f) of thesis eq (3-6): the modulus of the weighted complex log ratio.

    estimate: the n frequencies to fit.
    Returns: e, never negative.
    """
    weight = np.sqrt(estimate.coherence / estimate.frequency_hz)
    ratio = np.log(estimate.response / admittance(parameters, estimate.frequency_hz))
    return weight * np.abs(ratio)


def fit_as_printed(estimate: FrequencyResponse, bounds: Bounds) -> AdmittanceFit:
    """Fit with the modulus as residual, unscaled parameters and tolerances of 1e-6.

    These were the defaults of a common non-linear least-squares solver at the time of the thesis. With
    I = 0.001 and K = 10 in one unscaled vector, a significant step of I is far below the tolerance for K.

    estimate: frequencies to fit.
    """
    return _fit(residuals_as_printed, estimate, bounds, bounds.start, 1.0, 1e-6)


def fit_scaled(
    estimate: FrequencyResponse, bounds: Bounds, start: Annotated[np.ndarray, "(3,)"] | None = None
) -> AdmittanceFit:
    """Fit with smooth residuals, scaled parameters and tight tolerances.

    estimate: frequencies to fit.
    start: other starting values.
    """
    return _fit(residuals, estimate, bounds, bounds.start if start is None else start, TYPICAL, 1e-12)


def _fit(function, estimate, bounds, start, scale, tolerance) -> AdmittanceFit:
    solution = scipy.optimize.least_squares(
        function,
        start,
        bounds=(bounds.lower, bounds.upper),
        x_scale=scale,
        xtol=tolerance,
        ftol=tolerance,
        gtol=tolerance,
        max_nfev=400,
        args=(estimate,),
    )
    scaled = solution.jac * TYPICAL
    inverse = np.diag(np.linalg.pinv(scaled.T @ scaled)) * TYPICAL**2
    width = bounds.upper - bounds.lower
    distance = np.minimum(solution.x - bounds.lower, bounds.upper - solution.x)
    return AdmittanceFit(
        parameters=solution.x,
        start=np.array(start, dtype=float),
        cost=float(2.0 * solution.cost),
        sem=sems(float(np.linalg.norm(solution.fun)), solution.fun.size, inverse),
        degrees_of_freedom=solution.fun.size - solution.x.size,
        converged=bool(solution.success),
        at_bound=bool((distance < 1e-6 * np.where(np.isfinite(width), width, TYPICAL)).any()),
    )


def error_of_misfit(fit: AdmittanceFit, estimate: FrequencyResponse) -> tuple[np.ndarray, np.ndarray]:
    """Standard error of a fit with unequal residuals that include model errors.

    Every frequency has its own variance, from its own residual (White's estimator, HC3): noise and
    the distortions of a joint that is not linear differ between frequencies, and distortions repeat in every
    period. Few frequencies near the resonance may determine a parameter, so that its variance has few degrees
    of freedom (Satterthwaite; Bell and McCaffrey 2002).

    fit: result of `fit_scaled`.
    estimate: the n frequencies that were fitted.

    Returns:
        errors: standard errors of I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad). Shape (3,).
        freedom: degrees of freedom of their squares, at most ``fit.degrees_of_freedom``. Shape (3,).
    """
    steps = 1e-5 * np.diag(TYPICAL)
    jacobian = np.column_stack(
        [
            (residuals(fit.parameters + step, estimate) - residuals(fit.parameters - step, estimate)) / 2e-5
            for step in steps
        ]
    )
    inverse = np.linalg.pinv(jacobian.T @ jacobian, hermitian=True)
    leverage = np.einsum("ni,ij,nj->n", jacobian, inverse, jacobian)
    squares = (residuals(fit.parameters, estimate) / np.maximum(1.0 - leverage, 1e-6)) ** 2
    # gain and phase of a frequency have one variance
    squares = squares.reshape(2, -1).mean(axis=0)
    # terms of the three variances, shape (n, 3): a sum of n variances with two degrees of freedom each
    terms = squares[:, None] * ((jacobian @ inverse) ** 2).reshape(2, -1, 3).sum(axis=0)
    variance = terms.sum(axis=0)
    # the mean square of a variance estimated with two degrees of freedom is twice the square of the variance
    fourth = np.maximum(0.5 * (terms**2).sum(axis=0), np.finfo(float).tiny)
    freedom = np.clip(2.0 * (variance**2 - fourth) / fourth, 1.0, fit.degrees_of_freedom)
    return np.sqrt(variance) * TYPICAL, freedom


def change_by_smearing(
    fit: AdmittanceFit, estimate: FrequencyResponse, bounds: Bounds
) -> Annotated[np.ndarray, "(3,)"]:
    """Effect of averaging over neighbouring frequencies: the fitted joint, averaged and fitted again.

    The mean response of a band is not the response at its centre, above all near a resonance, where it looks
    like damping. The response is taken to be averaged evenly over `FrequencyResponse.resolution_hz`.

    fit: result of `fit_scaled`.
    estimate: the n frequencies that were fitted.
    Returns: changes of I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad).
    """
    smeared = replace(
        estimate, response=smeared_admittance(fit.parameters, estimate.frequency_hz, estimate.resolution_hz)
    )
    return fit_scaled(smeared, bounds, fit.parameters).parameters - fit.parameters


def distance_to_other_criterion(
    fit: AdmittanceFit, estimate: FrequencyResponse
) -> Annotated[np.ndarray, "(3,)"]:
    """Effect of the criterion: the fit less one by least squares of the torque.

    The other criterion minimises S_uu |1 - H / H_model|^2; for a linear joint the two would agree.

    fit: result of `fit_scaled`.
    estimate: the n frequencies that were fitted, with the power of the torque.
    Returns: differences of I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad).
    """
    omega, response = 2.0 * np.pi * estimate.frequency_hz, estimate.response
    columns = np.column_stack([-(omega**2) * response, 1j * omega * response, response])
    unit = np.sqrt(estimate.input_power)
    weighted = columns * unit[:, None]
    by_least_squares = np.linalg.lstsq(
        np.vstack([weighted.real, weighted.imag]), np.concatenate([unit, 0.0 * unit]), rcond=None
    )[0]
    return fit.parameters - by_least_squares


def fit_from_many_starts(
    estimate: FrequencyResponse, bounds: Bounds, count: int, rng: np.random.Generator
) -> list[AdmittanceFit]:
    """Repeat `fit_scaled` from the printed and from random starting values.

    estimate: frequencies to fit.
    count: number of random starts: I and B log-uniform over 1e-4..1 and 0.01..10, K uniform between its
    bounds.
    """
    fits = [fit_scaled(estimate, bounds)]
    for _ in range(count):
        start = np.array(
            [
                10.0 ** rng.uniform(-4.0, 0.0),
                10.0 ** rng.uniform(-1.99, 0.99),
                rng.uniform(0.99 * bounds.lower[2], 0.99 * bounds.upper[2]),
            ]
        )
        fits.append(fit_scaled(estimate, bounds, start))
    return fits


def fit_within_random_bounds(
    estimate: FrequencyResponse, bounds: Bounds, count: int, rng: np.random.Generator
) -> list[AdmittanceFit]:
    """Repeat `fit_scaled` within random bounds, from the point between them that is nearest to the start.

    estimate: frequencies to fit.
    count: number of pairs of bounds: I and B log-uniform over 1e-4..1 and 0.01..10, K uniform between its
    bounds.
    """
    fits = []
    for _ in range(count):
        pair = np.stack(
            [
                10.0 ** rng.uniform(-4.0, 0.0, 2),
                10.0 ** rng.uniform(-2.0, 1.0, 2),
                rng.uniform(bounds.lower[2], bounds.upper[2], 2),
            ],
            axis=1,
        )
        lower, upper = np.sort(pair, axis=0)
        margin = 1e-3 * (upper - lower)
        start = np.clip(bounds.start, lower + margin, upper - margin)
        fits.append(fit_scaled(estimate, Bounds(start, lower, upper)))
    return fits


@dataclass(frozen=True)
class StiffnessProfile:
    """Cost as a function of K, with I and B refitted for each K."""

    stiffness: Annotated[np.ndarray, "(n,)", "N·m/rad"]
    cost: np.ndarray
    """Smallest sum of e^2."""
    limit: float
    """Cost at the border of the 95 % interval."""
    interval: tuple[float, float]
    """The 95 % interval (N·m/rad); an end outside the profile is infinite."""


def profile_stiffness(
    estimate: FrequencyResponse, bounds: Bounds, best: AdmittanceFit, stiffness: np.ndarray
) -> StiffnessProfile:
    """Profile likelihood of K, for white residuals of unknown variance.

    estimate: frequencies to fit.
    best: the fit with K free.
    stiffness: values of K to hold (N·m/rad), increasing.
    Returns: costs and the interval of K where cost <= cost_best (1 + F_95(1, N - 3) / (N - 3)), N twice the
    number of frequencies.
    """
    cost = np.empty(stiffness.size)
    centre = int(np.argmin(np.abs(stiffness - best.parameters[2])))
    for direction in (range(centre, stiffness.size), range(centre - 1, -1, -1)):
        start = np.clip(best.parameters[:2], bounds.lower[:2] + 1e-9, bounds.upper[:2] - 1e-9)
        for k in direction:
            solution = scipy.optimize.least_squares(
                lambda p, held: residuals(np.array([p[0], p[1], held]), estimate),
                start,
                bounds=(bounds.lower[:2], bounds.upper[:2]),
                x_scale=TYPICAL[:2],
                args=(stiffness[k],),
            )
            cost[k], start = 2.0 * solution.cost, solution.x
    freedom = 2 * estimate.frequency_hz.size - 3
    limit = best.cost * (1.0 + scipy.stats.f.ppf(0.95, 1, freedom) / freedom)
    return StiffnessProfile(stiffness, cost, float(limit), _interval(stiffness, cost, limit))


def _interval(x: np.ndarray, cost: np.ndarray, limit: float) -> tuple[float, float]:
    """Crossings of the limit by the profile on either side of its minimum."""
    lowest = int(np.argmin(cost))
    ends = [-np.inf, np.inf]
    for side, indices in enumerate((range(lowest, 0, -1), range(lowest, x.size - 1))):
        step = -1 if side == 0 else 1
        for k in indices:
            if cost[k + step] > limit >= cost[k]:
                part = (limit - cost[k]) / (cost[k + step] - cost[k])
                ends[side] = float(x[k] + part * (x[k + step] - x[k]))
                break
    return ends[0], ends[1]
