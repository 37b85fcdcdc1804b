"""Expected standard uncertainty of I, B, K for a design, and the number of perturbations it needs.

    u^2(n) = (u_A^2 - u_R^2) n_0 / n + u_R^2 + u_B^2

u_A is the estimator's uncertainty with the planned number n_0, from its own covariance (`expected_fit`,
`window_noise`); for the likelihood, the Cramer-Rao bound is given as well. u_R is the part of u_A due to the
reference at rest of windowed least squares: it falls with the duration of rest only. u_B comes from the
tolerances of the calibration, as in the budgets of the dummy.
"""

import math
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np

from tepsipe.errors import InputError
from tepsipe.experiments.dummy.foot_budget import FootKnowledge, foot_budget
from tepsipe.experiments.planning.design import (
    FOOT,
    JOINT_LIKELIHOOD,
    LEG,
    Design,
    ExpectedMotion,
    exact_markers,
    expected_motion,
)
from tepsipe.experiments.planning.filtering import filtered, filtered_motion, late
from tepsipe.experiments.planning.window_noise import window_noise
from tepsipe.identification.budgets.leg import (
    LegUncertainty,
    angle_contributions,
    compliance_contributions,
    driven_tilt_contributions,
    torque_contributions,
)
from tepsipe.identification.likelihood.channels import dummy_markers
from tepsipe.identification.likelihood.likelihood import ExpectedFit, expected_fit, maximise_likelihood
from tepsipe.identification.likelihood.result import working_covariance
from tepsipe.identification.likelihood_fit import fit_joint_likelihood
from tepsipe.identification.regression.windows import WindowedFits, regress_torque
from tepsipe.mechanics.impedance_model import PARAMETERS, UNITS
from tepsipe.mechanics.inverse_dynamics import Leg, foot_torque, leg_torque
from tepsipe.mechanics.segment_kinematics import SegmentMotion
from tepsipe.signals.differentiation import derivative
from tepsipe.statistics.uncertainty import Budget, Source

# two-sided 95 % of a normal distribution
COVERAGE = 1.959964


@dataclass(frozen=True)
class Plan:
    """Predicted precision of I, B, K for a design (N·m·s²/rad, N·m·s/rad, N·m/rad)."""

    design: Design
    """The experiment."""
    motion: ExpectedMotion
    """Its motion without noise (s, m, rad)."""
    covariance: Annotated[np.ndarray, "(3, 3)"]
    """Covariance of the estimator, Type A (units of the parameters)."""
    bound: Annotated[np.ndarray, "(3,)"] | None
    """Smallest standard uncertainty of Type A that any unbiased estimator from markers and log can have
    (units of the parameters); None for estimators of other signals or with less than all of them."""
    bias: Annotated[np.ndarray, "(3,)"]
    """Bias of the mean of the estimates due to noise in the regressors (units of the parameters)."""
    of_rest: Annotated[np.ndarray, "(3,)"]
    """u_R, part of Type A that does not fall with the number (units of the parameters)."""
    budget: Budget
    """Type A and one entry per tolerance (units of the parameters)."""

    @property
    def type_a(self) -> np.ndarray:
        """Standard uncertainty of Type A of I, B, K, shape (3,)."""
        return np.sqrt(np.diag(self.covariance))

    @property
    def type_b(self) -> np.ndarray:
        """Standard uncertainty of Type B of I, B, K, shape (3,)."""
        return self.budget.type_b

    @property
    def combined(self) -> np.ndarray:
        """Combined standard uncertainty of I, B, K, shape (3,)."""
        return np.hypot(self.type_a, self.type_b)

    def number_for(self, relative: float, quantity: str = "K") -> int | None:
        """Number of perturbations for bias and 95 % interval within +- ``relative`` of the value.

        None if no number is enough, because tolerances and bias alone exceed the limit, or if the value is 0.
        """
        k = PARAMETERS.index(quantity)
        allowed = relative * self.design.parameters[k] - abs(self.bias[k])
        wanted = (allowed / COVERAGE) ** 2 - self.type_b[k] ** 2 - self.of_rest[k] ** 2
        if not (allowed > 0.0 and wanted > 0.0):
            return None
        falling = self.type_a[k] ** 2 - self.of_rest[k] ** 2
        needed = self.design.protocol.number * falling / wanted
        return max(1, math.ceil(needed - 1e-9))

    def with_number(self, number: int) -> np.ndarray:
        """Combined standard uncertainty of I, B, K, shape (3,), after a number of perturbations."""
        return np.hypot(self.type_a_with(number), self.type_b)

    def type_a_with(self, number: int) -> np.ndarray:
        """Type A of I, B, K, shape (3,), after a number of perturbations."""
        falling = self.type_a**2 - self.of_rest**2
        return np.sqrt(falling * self.design.protocol.number / number + self.of_rest**2)

    def rows(self) -> list[dict]:
        """One row per quantity, for a table."""
        number = self.design.protocol.number
        return [
            quantity_row(
                self,
                name,
                number,
                cramer_rao=None if self.bound is None else float(self.bound[k]),
                bias=float(self.bias[k]),
            )
            for k, name in enumerate(PARAMETERS)
        ]


def quantity_row(
    plan, quantity: str, number: int, cramer_rao: float | None = None, bias: float = 0.0
) -> dict[str, float | str | None]:
    """Row of a table for I, B or K of a plan of any experiment.

    quantity: {"I", "B", "K"}: Quantity of the row.
    number: planned perturbations.
    cramer_rao, bias: bound of Type A, if there is one, and bias (unit of the quantity).
    Returns: columns (unit of the quantity, in ``unit``).
    """
    k = PARAMETERS.index(quantity)
    value, combined = float(plan.design.parameters[k]), float(plan.combined[k])
    return {
        "quantity": quantity,
        "unit": UNITS[quantity],
        "value": value,
        "n_perturbations": number,
        "predicted_u": float(plan.type_a[k]),
        "u_type_b": float(plan.type_b[k]),
        "u_combined": combined,
        "cramer_rao": cramer_rao,
        "bias": bias,
        "half_width_percent": 100.0 * (COVERAGE * combined) / value if value else None,
        "n_for_5_percent": plan.number_for(0.05, quantity),
        "n_for_10_percent": plan.number_for(0.10, quantity),
        "n_for_20_percent": plan.number_for(0.20, quantity),
    }


def plan_experiment(design: Design) -> Plan:
    """Expected standard uncertainty of I, B, K.

    design: joint, leg, foot, rig, protocol and tolerances.
    Returns: type A, Type B, bias and the number that is needed.
    """
    motion = expected_motion(design)
    if design.protocol.pathway in (LEG, FOOT):
        return _of_windows(design, motion)
    expected = expected_likelihood(design, motion)
    windows = motion.perturbations
    covariance = working_covariance(expected.fit, windows, expected.fit.covariance)
    bound = np.sqrt(np.diag(working_covariance(expected.fit, windows, expected.bound)))
    values, sources = design.parameters, design.sources
    contributions = angle_contributions(values, design.leg, sources)
    contributions |= compliance_contributions(values, sources)
    budget = _budget(design, np.sqrt(np.diag(covariance)), contributions)
    return Plan(design, motion, covariance, bound, np.zeros(3), np.zeros(3), budget)


def expected_likelihood(design: Design, motion: ExpectedMotion) -> ExpectedFit:
    """Likelihood of the planned trial, as far as its signals determine it (units of `ExpectedFit`)."""
    rig = design.rig
    positions, labels, fixed = exact_markers(design, motion)
    markers = dummy_markers(positions, labels, rig.leg_markers, fixed)
    log = motion.simulated.foot_y_d
    exact = maximise_likelihood(motion.time, markers, log, design.leg, motion.at_rest, softening=False)
    softening = design.protocol.pathway == JOINT_LIKELIHOOD
    return expected_fit(exact, rig.marker_noise_m, rig.log_noise_of_sample_m_per_s, softening=softening)


def _budget(design: Design, type_a: np.ndarray, contributions: dict[str, np.ndarray]) -> Budget:
    freedom = {name: design.sources[name].freedom for name in contributions}
    return Budget(type_a, np.inf, contributions, freedom)


@dataclass(frozen=True)
class _Signals:
    """Filtered signals of a trial without noise."""

    motion: SegmentMotion
    torque: np.ndarray
    loads: dict[str, np.ndarray]
    y_a: np.ndarray
    y_a_dd: np.ndarray


def _signals(design: Design, motion: ExpectedMotion) -> _Signals:
    protocol, rate = design.protocol, design.rig.camera_rate_hz
    positions, labels, _ = exact_markers(design, motion)
    leg_motion = filtered_motion(
        motion.time, positions, labels, design.rig.leg_markers, design.leg.com_m, protocol.lowpass
    )

    def lowpass(x: np.ndarray) -> np.ndarray:
        return filtered(x, protocol.lowpass, rate)

    simulated = motion.simulated
    loads = {"Fy": lowpass(simulated.f_y), "Fz": lowpass(simulated.f_z), "Mx": lowpass(simulated.m_x)}
    y_a = lowpass(simulated.foot_y)
    y_a_dd = derivative(motion.time, derivative(motion.time, y_a))
    if protocol.pathway == LEG:
        torque = leg_torque(
            design.leg, leg_motion.theta, leg_motion.theta_dd, leg_motion.y_dd, leg_motion.z_dd
        )
    else:
        torque = foot_torque(design.foot, loads["Fy"], loads["Fz"], loads["Mx"], y_a, y_a_dd)
    return _Signals(leg_motion, torque, loads, y_a, y_a_dd)


def _of_windows(design: Design, motion: ExpectedMotion) -> Plan:
    """Plan of windowed least squares."""
    signals = _signals(design, motion)
    windows = late(motion.perturbations, design.protocol.lowpass, design.rig.camera_rate_hz)

    def fit(of_leg: SegmentMotion, torque: np.ndarray) -> WindowedFits:
        return regress_torque(of_leg, torque, windows, motion.at_rest)

    fitted = fit(signals.motion, signals.torque)
    noise = window_noise(design, fitted.regressors, windows, int(motion.at_rest.sum()))
    if not np.isfinite(noise.covariance).all() or not (np.diag(noise.covariance) > 0.0).all():
        raise InputError(
            "plan: expected windows that determine I, B, K, found regressors that depend on each other: plan "
            "other pulses"
        )
    contributions = _window_contributions(design, fitted, fit, signals)
    known = replace(design, sources=_with_jitter(design))
    budget = _budget(known, np.sqrt(np.diag(noise.covariance)), contributions)
    return Plan(design, motion, noise.covariance, None, noise.bias, noise.of_rest, budget)


def _with_jitter(design: Design) -> dict:
    """Tolerances, with the rig's synchronisation added where the torque comes from the plate."""
    sources = dict(design.sources)
    if design.protocol.pathway == FOOT and design.rig.sync_jitter_s > 0.0:
        sources["log_delay_s"] = Source("log_delay_s", design.rig.sync_jitter_s)
    return sources


def _window_contributions(design: Design, fitted: WindowedFits, fit, signals: _Signals) -> dict:
    """Contribution of every tolerance to I, B, K, rows of shape (3,)."""
    sources = _with_jitter(design)
    if not sources:
        return {}
    if design.protocol.pathway == FOOT:
        known = FootKnowledge(design.foot, signals.loads, signals.y_a, signals.y_a_dd, sources)
        reestimate = lambda of_leg, torque: fit(of_leg, torque).mean  # noqa: E731
        return foot_budget(fitted, reestimate, signals.motion, signals.torque, known).contributions

    def by_leg(of_leg: SegmentMotion, leg: Leg) -> np.ndarray:
        torque = leg_torque(leg, of_leg.theta, of_leg.theta_dd, of_leg.y_dd, of_leg.z_dd)
        return fit(of_leg, torque).mean

    known = LegUncertainty(design.leg, design.rig.leg_markers, sources, signals.motion)
    tilted = driven_tilt_contributions(fitted, design.leg, design.foot, sources)
    return torque_contributions(by_leg, known) | tilted


# ---- check of a plan: noise is drawn again and again, and the real estimators fit what was drawn ---------


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
