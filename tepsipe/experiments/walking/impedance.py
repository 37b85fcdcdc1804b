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
strides and are subtracted from the normal equations.

References
----------
Rouse, Hargrove, Perreault & Kuiken (2014). IEEE Trans. Neural Syst. Rehabil. Eng. 22(4), 870-878.
Lee, Krebs & Hogan (2016). IEEE Trans. Neural Syst. Rehabil. Eng.
Shorter & Rouse (2018). IEEE Trans. Neural Syst. Rehabil. Eng. 26(1), 135-143.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
from annotated_types import Ge, Le, MultipleOf

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
from tepsipe.quantities import Frequency, Height, Inertia, NotNegative, Pause, Positive, Some, Time
from tepsipe.statistics.uncertainty import Budget, Source

QUANTITIES = ("I", "B", "K")
REGRESSORS = (ACCELERATION, RATE, ANGLE)
DISCREPANCY = 0.02  # of the response, what the model lacks
LEAST_RESPONSE = 5.0  # of the angle, in standard deviations of its chance; below there is no interval


@dataclass(frozen=True)
class WalkingOptions:
    """Choices of the analysis."""

    phases_percent: Some[Annotated[float, Ge(0), Le(100)]] = (20.0, 40.0, 60.0, 80.0)
    """Phases of stance at which pulses begin."""
    phase_tolerance_percent: Positive = 5.0
    """Largest distance of a pulse from its phase."""
    control_percent: Sequence[Annotated[float, Ge(100), Le(1000)]] = ()
    """Further onsets, in swing (above 100), that serve as a control."""
    lowpass_cutoff_hz: Frequency = 20.0
    """Zero-lag low-pass of all signals."""
    lowpass_order: Annotated[int, Ge(2), MultipleOf(2)] = 4
    """Order of both passes together."""
    window_s: Time = 0.1
    """Window after the onset."""
    reflex_from_s: Pause = 0.05
    """Earliest reflex moment."""
    reflex_Nm: NotNegative = 1.6
    """Its standard deviation 20 ms later."""
    matched_by: Sequence[str] | None = None
    """Signals from whose state unperturbed behaviour is predicted (null: all; `[]`: plain mean)."""
    ridge: Positive = 1.0
    """Penalty of the prediction, relative to the number of strides."""
    state_before_s: Pause = 0.04
    """The state is that so long before the onset."""
    inertia_kgm2: Inertia | None = 0.012
    """*I* as known; null to estimate it."""
    foot_mass_kg: Annotated[float, Ge(0), Le(50)] = 1.15
    """Mass of the foot."""
    foot_depth_m: Height = 0.06
    """Its centre of mass below the ankle."""
    fewest_strides: Annotated[int, Ge(3)] = 6
    """Fewest perturbed strides of a phase."""
    recovery_strides: Annotated[int, Ge(0)] = 1
    """Strides after a perturbed one that are not used."""

    @property
    def onsets_percent(self) -> tuple[float, ...]:
        """Phases and controls (% of stance)."""
        return (*self.phases_percent, *self.control_percent)


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
    inverse = np.linalg.inv(weighing)
    design = response[0 if options.inertia_kgm2 is None else 1 :].T
    weights = np.linalg.solve(design.T @ inverse @ design, design.T @ inverse)
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
    inverse = np.linalg.inv(covariance)
    design = mean[free].T
    gram = design.T @ inverse @ design
    # contribution of natural scatter to the normal equations: angles with themselves, and with the moment
    product = np.einsum("nav,vw,nbw->ab", x0[:, free], inverse, x0[:, free]) * share / len(y0)
    rest = y0 - np.einsum("nqw,q->nw", x0[:, : free.start], beta[: free.start])
    cross = np.einsum("nav,vw,nw->a", x0[:, free], inverse, rest) * share / len(y0)
    corrected = gram - product
    if np.linalg.eigvalsh(_scaled(corrected, gram))[0] < 0.2:  # no more signal than scatter: no correction
        corrected, cross = gram, 0.0 * cross
    updated = beta.copy()
    updated[free] = np.linalg.solve(corrected, design.T @ inverse @ moment - cross)
    return updated, np.linalg.solve(corrected, design.T @ inverse)


def _scaled(matrix: np.ndarray, scale: np.ndarray) -> np.ndarray:
    """Matrix in the metric of another one, so that equal matrices give the identity."""
    root = np.linalg.cholesky(scale)
    half = np.linalg.solve(root, matrix)
    return np.linalg.solve(root, half.T)


def _reflex(time: np.ndarray, start_s: float) -> np.ndarray:
    """Covariance of an integrated Wiener process from ``start_s`` on, 1 after 20 ms."""
    after = np.clip(time - start_s, 0.0, None)
    short, long = np.minimum.outer(after, after), np.maximum.outer(after, after)
    return short**2 * (3.0 * long - short) / (2.0 * 0.02**3)


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
