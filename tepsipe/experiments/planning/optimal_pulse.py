"""Pulse with the most information on K within limits of the belt's motion, and a bound for all pulses.

The command is v(t) = sum_j c_j N_j(t), with cubic B-splines N_j on equal knots, 0 with its slope at both
ends. Through the drive, as long as its force is not at its limit, the belt's motion is linear in c, and so
are its limits: |l_i' c| <= 1 for velocity, displacement, acceleration and jerk at every instant. The
information of the likelihood of a linear joint is a sum over frequencies (`expected_fit`),

    F(c) = sum over f of F_f |Y_f(c)|^2,    Y_f(c) = sum_j c_j Y_fj

and the variance of K is at least [F^-1]_KK = 1 / min over w of w' F w, w_K = 1.

*The pulse.* [F^-1]_KK is lowered by steps towards the corner of the limits in which its linearisation is
lowest (Frank and Wolfe 1956), from several starts. The best of them is a local optimum.

*The bound.* For every w with w_K = 1, var K >= 1 / (w' F(c) w), and w' F(c) w = c' Q c with Q positive
semidefinite. For every d_i >= 0, M = sum_i d_i l_i l_i', and lambda the largest eigenvalue of Q against M,

    c' Q c <= lambda c' M c <= lambda sum_i d_i

(dual of Shor's relaxation). The right-hand side is lowered by descent over d; any d gives a valid bound, and
so does any w. This limits how much better than the pulse found the best pulse can be.
"""

from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
import scipy

from tepsipe.errors import InputError
from tepsipe.experiments.planning.design import Design, Protocol
from tepsipe.experiments.planning.plan import Plan, expected_likelihood, plan_experiment
from tepsipe.experiments.planning.pulses import STEP_S, Drive, Limits, Pulse, peaks_of
from tepsipe.identification.likelihood.likelihood import ExpectedFit
from tepsipe.signals.perturbations import SMALLEST_PEAK_M_PER_S

OPTIMAL = "optimal"
# distance of knots (s): frequencies above the likelihood's band are not shaped
KNOT_S = 0.006
# time after a pulse during which limits hold every `STEP_S`, then rarely (s), and their fraction in use
_AFTER_S, _RARELY_S, _MARGIN = 0.03, 0.008, 0.9999
_STEPS, _DESCENTS = 60, (2.0, 4.0, 8.0, 16.0, 32.0)


@dataclass(frozen=True)
class OptimalPulse:
    """The best pulse found."""

    pulse: Pulse
    """Its command (m/s)."""
    belt_velocity: Annotated[np.ndarray, "(k,)", "m/s"]
    """Response of the drive to it, every `STEP_S`."""
    peaks: Limits
    """Peaks of the belt's motion (m/s, m, m/s², m/s³)."""
    standard_error: Annotated[float, "N·m/rad"]
    """Cramer-Rao bound of K for this pulse."""
    least_standard_error: Annotated[float, "N·m/rad"]
    """Below it no pulse of this length and these limits can be."""


class _Problem:
    """Information of K and limits, as functions of the coefficients of the command."""

    def __init__(self, design: Design, expected: ExpectedFit, duration_s: float, limits: Limits):
        protocol, drive = design.protocol, design.rig.drive
        self.basis = spline_basis(duration_s)
        responses = [drive.follow(b, limited=False) for b in self.basis.T]
        longest = max(x.size for x in responses)
        self.moved = np.array([np.pad(x, (0, longest - x.size)) for x in responses]).T
        self.rows = _limit_rows(self.moved, self.basis.shape[0], _with_drive(limits, drive))
        names = expected.fit.point.names
        kept = [k for k, name in enumerate(names) if expected.by_foot[k].any()]
        self.of_k = kept.index(names.index("K"))
        self.kernel = expected.by_foot[np.ix_(kept, kept)]
        self.spectra = _spectra(self.moved, expected, protocol)

    def information(self, c: np.ndarray) -> np.ndarray:
        """Information matrix F(c)."""
        return self.kernel @ np.abs(self.spectra @ c) ** 2

    def weights(self, c: np.ndarray) -> tuple[np.ndarray, float]:
        """Weights w that minimise w' F w, and its minimum 1 / [F^-1]_KK."""
        information = self.information(c)
        scale = np.sqrt(np.diag(information))
        unit = np.zeros(len(scale))
        unit[self.of_k] = 1.0
        column = np.linalg.lstsq(information / np.outer(scale, scale), unit, rcond=1e-13)[0]
        column = column / scale
        variance = column[self.of_k] / scale[self.of_k]
        return column / column[self.of_k], 1.0 / variance

    def quadratic(self, w: np.ndarray) -> np.ndarray:
        """Matrix Q with c' Q c = w' F(c) w."""
        weight = np.einsum("a,abm,b->m", w, self.kernel, w)
        return (self.spectra.conj().T @ (weight[:, None] * self.spectra)).real

    def scaled(self, c: np.ndarray) -> np.ndarray:
        """Coefficients c scaled as far as the limits allow."""
        return c / np.abs(self.rows @ c).max()


def spline_basis(duration_s: float) -> np.ndarray:
    """Cubic B-splines that are 0 with their slope at both ends, every `STEP_S`, shape (n, k)."""
    count = round(duration_s / KNOT_S)
    if count < 5:
        raise InputError(
            f"pulse: expected a duration_s of at least {5 * KNOT_S:g} s to be shaped, found {duration_s:g}: "
            "lengthen it"
        )
    time = np.linspace(0.0, duration_s, round(duration_s / STEP_S) + 1)
    knots = np.concatenate([[0.0] * 3, np.linspace(0.0, duration_s, count + 1), [duration_s] * 3])
    splines = scipy.interpolate.BSpline(knots, np.eye(count + 3), 3)(time)
    return splines[:, 2:-2]


def _with_drive(limits: Limits, drive: Drive) -> Limits:
    most = min(limits.acceleration_m_per_s2, drive.acceleration_m_per_s2)
    return replace(limits, acceleration_m_per_s2=most)


def _limit_rows(motions: np.ndarray, samples: int, limits: Limits) -> np.ndarray:
    """Rows l_i of the limits of motions (n, coefficients) after commands of ``samples`` samples."""
    often = min(len(motions), samples + round(_AFTER_S / STEP_S))
    held = np.concatenate([np.arange(often), np.arange(often, len(motions), round(_RARELY_S / STEP_S))])
    padded = np.vstack([np.zeros(motions.shape[1]), motions, np.zeros(motions.shape[1])])
    acceleration = np.diff(padded, axis=0) / STEP_S
    displacement = STEP_S * np.cumsum(0.5 * (padded[1:] + padded[:-1]), axis=0)
    jerk = np.diff(acceleration, axis=0) / STEP_S
    scaled = []
    for x, limit in zip((padded, displacement, acceleration, jerk), vars(limits).values(), strict=True):
        if np.isfinite(limit):
            scaled.append(x[held] / (_MARGIN * limit))
    rows = np.vstack(scaled)
    return rows[np.abs(rows).max(axis=1) > 1e-6 * np.abs(rows).max()]


def _spectra(motions: np.ndarray, expected: ExpectedFit, protocol: Protocol) -> np.ndarray:
    """Spectra Y_fj of the foot's position over the trial, shape (m, k) (m times samples)."""
    model, rate = expected.fit.model, expected.fit.channels.rate_hz
    s = model.s
    time = STEP_S * np.arange(len(motions))
    pulse = np.exp(-s[:, None] * time) @ motions * STEP_S
    train = np.exp(-np.outer(s, protocol.onsets_s)) @ protocol.signs
    # position is the integral of the velocity; a sum over samples is the integral times the rate
    return pulse * (train * rate / s)[:, None]


def optimise_pulse(design: Design, expected: ExpectedFit, limits: Limits) -> OptimalPulse:
    """Shape a pulse of the planned length for the smallest standard error of K.

    design: the experiment, with any pulse of the length that is wanted; one-way pulses alternate, so a
    pulse may leave the belt displaced if ``design.protocol.pulse.one_way``.
    expected: likelihood of the planned trial.
    limits: limits of the belt's motion.
    Returns: command, belt, and standard error with its bound.
    """
    problem = _Problem(design, expected, design.protocol.pulse.duration_s, limits)
    starts = _starts(problem)
    if not design.protocol.pulse.one_way:
        problem, starts = _returning(problem, starts)
    best = max((_gauss_newton(problem, c) for c in starts), key=lambda c: problem.weights(c)[1])
    w, value = problem.weights(best)
    bound = min(_bound(problem, w), _bound(problem, problem.weights(problem.scaled(starts[0]))[0]))
    command = problem.basis @ best
    sign = 1.0 if command[np.argmax(np.abs(command))] > 0.0 else -1.0
    belt = sign * (problem.moved @ best)
    pulse = Pulse(OPTIMAL, sign * command, design.protocol.pulse.one_way)
    # limits themselves, without the margin
    most = max(bound / _MARGIN**2, value)
    return OptimalPulse(pulse, belt, peaks_of(belt), value**-0.5, most**-0.5)


def _starts(problem: _Problem) -> list[np.ndarray]:
    """Starting commands: one-way, out and back, and the command favoured by the information at a corner."""
    passed = np.linspace(0.0, 1.0, len(problem.basis))
    shapes = (np.sin(np.pi * passed) ** 2, np.sin(2.0 * np.pi * passed), np.sin(3.0 * np.pi * passed))
    return [np.linalg.lstsq(problem.basis, shape, rcond=None)[0] for shape in shapes]


def _returning(problem: _Problem, starts: list[np.ndarray]) -> tuple[_Problem, list[np.ndarray]]:
    """The problem for commands without net displacement: coefficients in their subspace."""
    inner = scipy.linalg.null_space(problem.basis.sum(axis=0)[None])
    for name in ("basis", "moved", "rows", "spectra"):
        setattr(problem, name, getattr(problem, name) @ inner)
    return problem, [c for c in (inner.T @ start for start in starts) if np.linalg.norm(c) > 1e-6]


def _gauss_newton(problem: _Problem, start: np.ndarray) -> np.ndarray:
    """Frank-Wolfe steps with a search along each."""
    c = problem.scaled(start)
    value = problem.weights(c)[1]
    both = np.vstack([problem.rows, -problem.rows])
    for _ in range(_STEPS):
        slope = problem.quadratic(problem.weights(c)[0]) @ c
        corner = scipy.optimize.linprog(
            -slope / np.abs(slope).max(),
            A_ub=both,
            b_ub=np.ones(len(both)),
            bounds=(None, None),
            method="highs",
        ).x
        if corner is None:
            break
        tried = [problem.scaled(c + share * (corner - c)) for share in (1.0, 0.5, 0.25, 0.1, 0.03, 0.01)]
        values = [problem.weights(x)[1] for x in tried]
        best = int(np.argmax(values))
        if not values[best] > value * (1.0 + 1e-5):
            break
        c, value = tried[best], values[best]
    return c


def _bound(problem: _Problem, w: np.ndarray) -> float:
    """Upper bound of c' Q c within the limits, by descent over d."""
    q, rows = problem.quadratic(w), problem.rows
    shift = 1e-10 * np.trace(q) / len(q) * np.eye(len(q))

    def value(log_d: np.ndarray, power: float) -> tuple[float, np.ndarray]:
        d = np.exp(log_d - log_d.max())
        d = d / d.sum()
        metric = (rows.T * d) @ rows
        lengths, axes = scipy.linalg.eigh(q + shift, metric)
        top = lengths[-1]
        share = np.where(lengths > 0.0, lengths / top, 0.0) ** power
        smooth = np.log(top) + np.log(share.sum()) / power
        # axes are orthonormal in the metric: the slope by d_i is minus the weighted square of l_i' v
        slope = -((rows @ axes) ** 2 @ (share / share.sum()))
        return smooth, d * (slope - d @ slope)

    log_d = np.zeros(len(rows))
    best = np.inf
    for power in _DESCENTS:
        search = scipy.optimize.minimize(
            value, log_d, args=(power,), jac=True, method="L-BFGS-B", options={"maxiter": 150}
        )
        log_d = np.clip(search.x - search.x.max(), -25.0, 0.0)
        d = np.exp(log_d)
        d = d / d.sum()
        best = min(best, float(scipy.linalg.eigh(q, (rows.T * d) @ rows, eigvals_only=True)[-1]))
    return best


@dataclass(frozen=True)
class Optimised:
    """The best pulse, and the plan with it."""

    found: OptimalPulse
    plan: Plan


def best_of(plan: Plan, limits: Limits, one_way: bool) -> Optimised:
    """Best pulse within limits (m/s, m, m/s², m/s³), and the plan with it.

    ``plan`` has any pulse of the wanted length. With ``one_way`` the belt may stay where it was moved to,
    and go back with the next pulse.
    """
    design = plan.design
    pulse = replace(design.protocol.pulse, one_way=one_way)
    shaped = replace(design, protocol=replace(design.protocol, pulse=pulse))
    found = optimise_pulse(shaped, expected_likelihood(design, plan.motion), limits)
    if found.peaks.velocity_m_per_s < SMALLEST_PEAK_M_PER_S:
        raise InputError(
            f"limits: expected limits that allow a pulse of {SMALLEST_PEAK_M_PER_S:g} m/s, found that "
            "the best one "
            f"reaches {found.peaks.velocity_m_per_s:.2g} m/s: raise them or plan longer pulses"
        )
    best = replace(design, protocol=replace(design.protocol, pulse=found.pulse))
    return Optimised(found, plan_experiment(best))
