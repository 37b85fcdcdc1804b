"""Intrinsic impedance of the ankle at one phase of stance, from strides minus their unperturbed behaviour.

With deviations (D) averaged over n perturbed strides, moment and angle positive in plantarflexion,

    -DM + d m_f Dx'' = I Dtheta'' + B Dtheta' + K Dtheta + e,     e ~ N(0, S)

for a foot of mass m_f whose centre of mass lies d below the ankle and moves with the belt. Rouse et al.
(2014) fit this by least squares to means over strides in the 100 ms after the onset. Here S weights the
samples (generalised least squares in time): the deviation between strides grows and stays after the onset,
and its covariance is known from unperturbed strides,

    S = cov(M + I theta'' + B theta' + K theta) (1/n + 1/m) + (0.02 y)^2 1 + s^2 R(t, t')

with m unperturbed strides, 2 % of the response for errors of the model, and a reflex moment of any shape from
t_r on, an integrated Wiener process R that reaches s at 20 ms after t_r. A changing impedance is averaged
over the window with the weights of K, so the estimate belongs to their centre of time (Lee, Krebs & Hogan
2016 and Shorter & Rouse 2018 on impedance that changes within stance).

Errors in variables: natural scatter remains in the mean Dtheta. Its covariances are known from unperturbed
strides and are subtracted from the normal equations (`tepsipe.identification.regression.generalised`).

References
----------
Rouse, Hargrove, Perreault & Kuiken (2014). IEEE Trans. Neural Syst. Rehabil. Eng. 22(4), 870-878.
Lee, Krebs & Hogan (2016). IEEE Trans. Neural Syst. Rehabil. Eng.
Shorter & Rouse (2018). IEEE Trans. Neural Syst. Rehabil. Eng. 26(1), 135-143.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np

from tepsipe.experiments.walking.deviations import (
    ACCELERATION,
    ANGLE,
    ANTERIOR,
    FOOT_ACCELERATION,
    MOMENT,
    MOMENT_RATE,
    RATE,
    VERTICAL,
    Deviations,
)
from tepsipe.experiments.walking.options import WalkingOptions
from tepsipe.identification.regression.generalised import (
    GeneralisedFit,
    Record,
    generalised_least_squares,
    integrated_wiener,
    sensitivity,
)
from tepsipe.statistics.uncertainty import Budget, Source

QUANTITIES = ("I", "B", "K")
REGRESSORS = (ACCELERATION, RATE, ANGLE)
DISCREPANCY = 0.02  # of the response, what the model lacks
MOST_SCATTER = 0.8  # share of the mean response that is natural scatter; beyond it, none is subtracted
LEAST_RESPONSE = 5.0  # of the angle, in standard deviations of its chance; below there is no interval


@dataclass(frozen=True)
class PhaseImpedance:
    """Impedance at one phase."""

    values: Annotated[np.ndarray, "(3,)"]
    """I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad)."""
    budget: Budget
    """Their uncertainty (the same units); infinite where the angle does not respond."""
    low: Annotated[np.ndarray, "(3,)"]
    high: Annotated[np.ndarray, "(3,)"]
    """Ends of the 95 % intervals (the same units)."""
    at_s: float
    """Time after the onset to which K belongs."""
    response: float
    """RMS response of the mean angle, in standard deviations of its chance."""
    perturbed: int
    unperturbed: int
    """Numbers of strides."""
    flags: str
    """``no-response`` if the angle does not respond, ``no-contact`` if the foot carries no load in the
    window; else empty."""


def estimate_impedance(
    deviations: Deviations,
    options: WalkingOptions,
    sources: Mapping[str, Source] | None,
    rising: tuple[float, float, float] = (0.0, 0.0, 0.0),
) -> PhaseImpedance:
    """I, B and K of one phase with combined 95 % intervals.

    A stiffness that rises by K' within the window would be mistaken for a lack of damping. Given K' from
    the other phases, K' (t - t_K) Dtheta is subtracted first, which leaves K at t_K.

    deviations: strides minus their unperturbed behaviour.
    sources: type B: joint_centre_anterior_m, joint_centre_vertical_m, foot_mass_kg, belt_load_kgm, sync_s,
    angle_gain, inertia_kgm2 (units in the names; the last counts where I is known).
    rising: k' and its standard uncertainty (N·m/rad/s), and t_K (s after the onset).
    """
    n, m = len(deviations.perturbed), len(deviations.unperturbed)
    factor = options.foot_mass_kg * options.foot_depth_m
    x, y = _response(deviations.perturbed, factor)
    ramp = (deviations.time - rising[2]) * x[:, 2]
    signals = ((x, y - rising[0] * ramp), _response(deviations.unperturbed, factor))
    free = slice(0, 3) if options.inertia_kgm2 is None else slice(1, 3)
    beta = np.array([options.inertia_kgm2 or 0.0, 0.0, 0.0])
    for _ in range(4):
        beta, weights = _step(signals, deviations.time, beta, free, options)
    influence = np.zeros((n, 3))
    scatter = np.zeros((m, 3))
    influence[:, free] = _remainder(*signals[0], beta) @ weights.T
    scatter[:, free] = _remainder(*signals[1], beta) @ weights.T
    type_a, freedom = _type_a(influence, scatter)
    response = _size(deviations)
    nothing = response < LEAST_RESPONSE
    if nothing:
        type_a[free], freedom = np.inf, 1.0
    contributions = _type_b(deviations, beta, weights, free, options, sources or {})
    contributions["model"] = _of_the_model(deviations, beta, weights, free)
    contributions["stiffness_rate"] = np.zeros((1, 3))
    contributions["stiffness_rate"][0, free] = -weights @ ramp.mean(axis=0) * rising[1]
    budget = Budget(type_a, freedom, contributions)
    low, high = budget.interval(beta)
    angle = signals[0][0][:, 2].mean(axis=0)
    at_s = float(weights[-1] @ (angle * deviations.time) / (weights[-1] @ angle))
    return PhaseImpedance(beta, budget, low, high, at_s, response, n, m, "no-response" if nothing else "")


def without_contact(fit: PhaseImpedance) -> PhaseImpedance:
    """The same without values, because a foot in the air has no moment from the belt."""
    nothing, endless = np.full(3, np.nan), np.full(3, np.inf)
    budget = Budget(endless, 1.0)
    return replace(fit, values=nothing, budget=budget, low=-endless, high=endless, flags="no-contact")


def predicted_uncertainty(
    deviations: Deviations,
    response: Annotated[np.ndarray, "(3, w)"],
    beta: Annotated[np.ndarray, "(3,)"],
    options: WalkingOptions,
) -> Annotated[float, "N·m/rad"]:
    """Standard uncertainty of K by one perturbed stride (N·m/rad), before it is recorded.

    response: expected acceleration, velocity and angle (rad/s2, rad/s, rad).
    beta: expected I, B, K (N·m·s²/rad, N·m·s/rad, N·m/rad).
    Returns: type A of the estimator, at known I if the options know it.
    """
    factor = options.foot_mass_kg * options.foot_depth_m
    e0 = _remainder(*_response(deviations.unperturbed, factor), beta)
    natural = e0.T @ e0 / len(e0)
    modelled = beta @ response
    weighing = natural / 50.0 + np.diag((DISCREPANCY * modelled) ** 2 + 1e-6)  # as of 50 strides
    weighing += options.reflex_Nm**2 * _reflex(deviations.time, options.reflex_from_s)
    record = Record(modelled, response[0 if options.inertia_kgm2 is None else 1 :].T, weighing)
    weights = _weights(generalised_least_squares([record]), record)
    return float(np.sqrt(weights[-1] @ natural @ weights[-1]))


def _response(signals: np.ndarray, factor: float) -> tuple[np.ndarray, np.ndarray]:
    """Regressors, shape (n, 3, w), and resisting moment, shape (n, w), of each stride."""
    return signals[:, REGRESSORS], -signals[:, MOMENT] + factor * signals[:, FOOT_ACCELERATION]


def _remainder(regressors: np.ndarray, moment: np.ndarray, beta: np.ndarray) -> np.ndarray:
    """Resisting moment of each stride that the parameters do not explain, shape (n, w)."""
    return moment - np.einsum("nqw,q->nw", regressors, beta)


def _step(signals, time: np.ndarray, beta: np.ndarray, free: slice, options: WalkingOptions):
    """One iteration: covariance at the present parameters, then generalised least squares; weights too."""
    (x, y), (x0, y0) = signals
    share = 1.0 / len(y) + 1.0 / len(y0)
    e0 = _remainder(x0, y0, beta)
    mean, moment = x.mean(axis=0), y.mean(axis=0) - x.mean(axis=0).T[:, : free.start] @ beta[: free.start]
    covariance = share * e0.T @ e0 / len(e0)
    modelled = mean.T @ beta if beta.any() else moment
    covariance += np.diag((DISCREPANCY * modelled) ** 2 + 1e-4 * np.trace(covariance) / len(time) + 1e-6)
    covariance += options.reflex_Nm**2 * _reflex(time, options.reflex_from_s)
    # natural scatter that is left in the mean: angles with themselves, and with the moment
    rest = y0 - np.einsum("nqw,q->nw", x0[:, : free.start], beta[: free.start])
    angles = np.einsum("nav,nbw->abvw", x0[:, free], x0[:, free]) * share / len(y0)
    with_moment = np.einsum("nav,nw->avw", x0[:, free], rest) * share / len(y0)
    record = Record(moment, mean[free].T, covariance, noise=(angles, with_moment))
    fit = generalised_least_squares([record])
    if fit.noise_share > MOST_SCATTER:
        fit = generalised_least_squares([replace(record, noise=None)])
    updated = beta.copy()
    updated[free] = fit.parameters
    return updated, _weights(fit, record)


def _weights(fit: GeneralisedFit, record: Record) -> np.ndarray:
    """Change of the parameters with each sample of the moment, shape (p, w)."""
    return sensitivity(fit, [record], [np.eye(len(record.target))]).T


def _reflex(time: np.ndarray, start_s: float) -> np.ndarray:
    """Covariance of an integrated Wiener process from ``start_s`` on, 1 after 20 ms."""
    return integrated_wiener(time, start_s) * (3.0 / 0.02**3)


def _type_a(influence: np.ndarray, scatter: np.ndarray) -> tuple[np.ndarray, float]:
    """Standard uncertainty by the perturbed strides and by the unperturbed mean; degrees of freedom."""
    n, m = len(influence), len(scatter)
    perturbed = influence.var(axis=0, ddof=1) / n
    # strides perturbed at random: slow drift is common to both kinds, and no correlation needs to be added
    unperturbed = scatter.var(axis=0, ddof=1) / m
    freedom = (perturbed + unperturbed)[-1] ** 2 / (
        perturbed[-1] ** 2 / (n - 1) + unperturbed[-1] ** 2 / (m - 1)
    )
    return np.sqrt(perturbed + unperturbed), float(freedom)


def _size(deviations: Deviations) -> float:
    """RMS of the mean angle's response in standard deviations expected by chance."""
    n, m = len(deviations.perturbed), len(deviations.unperturbed)
    mean = deviations.perturbed[:, ANGLE].mean(axis=0)
    chance = deviations.unperturbed[:, ANGLE].var(axis=0) * (1.0 / n + 1.0 / m)
    return float(np.sqrt(np.mean(mean**2) / np.mean(chance)))


def _of_the_model(deviations: Deviations, beta: np.ndarray, weights: np.ndarray, free: slice) -> np.ndarray:
    """Root of the covariance of an independent error of 2 % of the response per sample."""
    modelled = beta @ deviations.perturbed.mean(axis=0)[list(REGRESSORS)]
    root = np.zeros((len(modelled), 3))
    root[:, free] = (weights * DISCREPANCY * modelled).T
    return root


def _type_b(
    deviations: Deviations,
    beta: np.ndarray,
    weights: np.ndarray,
    free: slice,
    options: WalkingOptions,
    sources: Mapping[str, Source],
) -> dict[str, np.ndarray]:
    """Signed contributions: the weights applied to the moment due to one standard uncertainty."""
    mean = deviations.perturbed.mean(axis=0)
    modelled = beta[free] @ mean[list(REGRESSORS)][free]
    # resisting moment per unit of the source: M falls with a centre further forward, rises with a higher one
    made = {
        "joint_centre_anterior_m": mean[VERTICAL],
        "joint_centre_vertical_m": -mean[ANTERIOR],
        "foot_mass_kg": options.foot_depth_m * mean[FOOT_ACCELERATION],
        "belt_load_kgm": mean[FOOT_ACCELERATION],
        "sync_s": mean[MOMENT_RATE],
        "angle_gain": -modelled,
        "inertia_kgm2": -mean[ACCELERATION] if free.start else np.zeros_like(modelled),
    }
    contributions = {}
    for name, source in sources.items():
        contribution = np.zeros(3)
        contribution[free] = weights @ made[name] * source.standard_uncertainty
        if name == "inertia_kgm2" and free.start:
            contribution[0] = source.standard_uncertainty
        contributions[name] = contribution[None]
    return contributions
