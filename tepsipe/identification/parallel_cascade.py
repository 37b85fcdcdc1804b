"""Parallel-cascade model: intrinsic stiffness and stretch reflex of a joint under imposed movement.

The model of Kearney, Stein & Parameswaran (1997), with both pathways in one regression:

    tau(t)   = tau_I(t) + tau_R(t) + offset
    tau_I(t) = sum over k of h[k] theta(t - k T) + c (theta(t) - theta_0)^2,    |k T| <= lag
    tau_R(t) = sum over k of g[k] u(t - delay - k T) T,                         0 <= k T <= length
    u(t)     = theta'(t) where theta' has the sign of ``direction``, else 0

T is the sampling period, theta_0 the mean angle of the fitted part, 2 c the angle-dependent stiffness (change
of K per angle). g is linear between its knots and zero at both ends; its integral is the reflex gain G. All
signals and regressors are low-pass filtered identically, which preserves their linear relation. The criterion

    |tau - tau_I - tau_R - offset|^2 + lambda N (|h[k], |k| > 1|^2 + |second differences of g|^2)

is minimised over the N samples of the fitted part, with every regressor scaled to unit size. h[-1], h[0] and
h[1] are not penalised: by central differences they are I theta'' + B theta' + K theta, so a large lambda
reduces the model to I, B, K without a reflex. The structure (presence and direction of the reflex, presence
of c, delay, lambda) is selected by cross-validation over blocks of the fitted part. Confidence intervals
hold for the selected structure: they include neither the selection nor the bias of the penalty.

The muscle model is a variant with three parameters in place of g:

    tau_R(s) = G w^2 / (s^2 + 2 zeta w s + w^2) u(s) exp(-s delay),   w = 2 pi frequency
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import scipy

from tepsipe.errors import InputError
from tepsipe.identification.cascade_fit import (
    MuscleFit,
    ParallelCascadeFit,
    ParallelCascadeOptions,
    Structure,
)
from tepsipe.identification.cascade_pathways import (
    delayed,
    knot_responses,
    lagged,
    muscle_response,
    rectified_velocity,
)
from tepsipe.signals.differentiation import derivative
from tepsipe.statistics.bootstrap import bootstrap_blocks
from tepsipe.statistics.goodness_of_fit import evaluate_held_out

# frequency (Hz) and damping ratio (-) of the muscle: starting values, bounds, and step of the logarithms for
# numerical derivatives
MUSCLE_START = (2.0, 1.0)
MUSCLE_BOUNDS = ((0.2, 20.0), (0.2, 5.0))
SLOPE = 1e-3


@dataclass(frozen=True)
class _Record:
    """Filtered signals over the whole record (N·m, rad, rad/s), and the part that is used (samples)."""

    torque: np.ndarray
    angle: np.ndarray
    squared: np.ndarray
    intrinsic: np.ndarray
    reflex: dict[int, np.ndarray]
    velocity: dict[int, np.ndarray]
    rate_hz: float
    kept: slice
    training: int


@dataclass(frozen=True)
class _Design:
    """Regressors over the part that is used: scaled columns, their scale, the penalty without lambda."""

    columns: np.ndarray
    scale: np.ndarray
    penalty: np.ndarray
    intrinsic: slice
    reflex: slice
    stiffening: slice


def identify_cascade(
    angle: np.ndarray,
    torque: np.ndarray,
    rate_hz: float,
    kept: slice,
    training: int,
    lowpass: Callable[[np.ndarray], np.ndarray],
    options: ParallelCascadeOptions,
    block: int,
    draws: int,
    rng: np.random.Generator,
) -> ParallelCascadeFit:
    """Fit both pathways to the first part of a record and predict all of it from the angle.

    Parameters
    ----------
    angle, torque : ndarray, shape (n,)
        Whole record, unfiltered (rad, N·m).
    rate_hz : float
        Sampling rate (Hz).
    kept : slice
        Samples that are used; the angle before them determines the reflex at their start.
    training : int
        Number of them, from the first on, that are fitted (samples).
    lowpass : function of ndarray to ndarray
        Zero-lag low-pass for signals and regressors, along axis 0.
    options : ParallelCascadeOptions
        Choices (units in their names).
    block, draws : int
        Length of the bootstrapped blocks (samples), and number of draws (-).
    rng : numpy.random.Generator
        Draws the blocks.

    Returns
    -------
    ParallelCascadeFit
        Structure, pathways, prediction (rad, N·m, s).

    Raises
    ------
    InputError
        If the joint does not move.
    """
    record = _record(angle, torque, rate_hz, kept, training, lowpass, options)
    y = record.torque[kept]
    folds = _folds(training, rate_hz, options)
    errors = {
        structure: _fold_errors(record, structure, y, folds, options)
        for structure in _candidates(record, options)
    }
    errors = {
        replace(structure, penalty=penalty): error[k]
        for structure, error in errors.items()
        for k, penalty in enumerate(options.penalties)
    }
    structure = _choose(errors)
    profile = {
        delay: float(error.mean())
        for delay, error in (
            (s.delay_s, e) for s, e in errors.items() if replace(s, delay_s=structure.delay_s) == structure
        )
    }
    alike = [d for d, e in profile.items() if e <= (1.0 + options.delay_tolerance) * min(profile.values())]
    if structure.direction:
        delay = min(alike, key=lambda d: abs(d - options.expected_delay_s))
        structure = replace(structure, delay_s=delay)

    design = _design(record, structure, options)
    fitted = design.columns[:training]
    penalty = structure.penalty * training * design.penalty
    solution = np.linalg.solve(fitted.T @ fitted + penalty, fitted.T @ y[:training])
    drawn = bootstrap_blocks(fitted, y[:training], block, draws, rng, penalty) / design.scale
    solution = solution / design.scale
    predicted = design.columns @ (design.scale * solution)

    def part(group: slice) -> np.ndarray:
        return design.columns[:, group] @ (design.scale[group] * solution[group])

    reflex_torque = part(design.reflex)
    impedance = _impedance_of_response(record)
    kernels = knot_responses(options.reflex_length_s, options.reflex_knot_s, rate_hz)
    response = drawn[:, design.reflex] @ kernels.T if structure.direction else np.empty((draws, 0))
    low, high = np.percentile(response, [2.5, 97.5], axis=0) if response.size else np.empty((2, 0))
    spread = np.mean((y[:training] - y[:training].mean()) ** 2)
    lag, smooth = _shown_response(solution[design.intrinsic], rate_hz, lowpass)
    return ParallelCascadeFit(
        structure=structure,
        predicted=predicted,
        reflex_torque=reflex_torque,
        vaf=evaluate_held_out(y, predicted, training),
        vaf_cross_validated=_percent(errors[structure].mean(), spread),
        impedance=impedance @ solution[design.intrinsic],
        impedance_bootstrap=drawn[:, design.intrinsic] @ impedance.T,
        stiffening=2.0 * float(solution[design.stiffening].sum()),
        stiffening_bootstrap=2.0 * drawn[:, design.stiffening].sum(axis=1),
        gain=float((kernels @ solution[design.reflex]).sum() / rate_hz) if structure.direction else 0.0,
        gain_bootstrap=response.sum(axis=1) / rate_hz,
        reflex_share=float(100.0 * np.var(reflex_torque[:training]) / spread),
        intrinsic_time=lag,
        intrinsic_response=smooth,
        reflex_time=structure.delay_s + np.arange(response.shape[1]) / rate_hz,
        reflex_response=kernels @ solution[design.reflex] if structure.direction else np.empty(0),
        reflex_low=low,
        reflex_high=high,
        delays=np.array(list(profile)) if structure.direction else np.empty(0),
        delay_vaf=_percent(np.array(list(profile.values())), spread) if structure.direction else np.empty(0),
        delay_range_s=(min(alike), max(alike)),
        muscle=_fit_muscle(record, structure, options, block, draws, rng) if structure.direction else None,
    )


def _percent(error, spread: float):
    """VAF (%) from a mean squared error and the variance of the signal."""
    return 100.0 * (1.0 - error / spread)


def _record(angle, torque, rate_hz, kept, training, lowpass, options) -> _Record:
    turned = angle - angle[kept][:training].mean()
    filtered = lowpass(turned)
    if not np.ptp(filtered[kept][:training]) > 0.0:
        raise InputError(
            "expected a moving joint, found an angle that stands still: check that the perturbation was "
            "applied"
        )
    reach = max(1, round(options.intrinsic_lag_s * rate_hz))
    kernels = knot_responses(options.reflex_length_s, options.reflex_knot_s, rate_hz)
    velocity = {s: lowpass(rectified_velocity(filtered, rate_hz, s)) for s in (1, -1)}
    return _Record(
        torque=lowpass(torque),
        angle=filtered,
        squared=lowpass(turned**2),
        intrinsic=lagged(filtered, np.arange(-reach, reach + 1)),
        reflex={
            s: scipy.signal.oaconvolve(u[:, None], kernels, axes=0)[: u.size] / rate_hz
            for s, u in velocity.items()
        },
        velocity=velocity,
        rate_hz=rate_hz,
        kept=kept,
        training=training,
    )


def _design(
    record: _Record,
    structure: Structure,
    options: ParallelCascadeOptions,
    reflex: np.ndarray | None = None,
) -> _Design:
    """Regressors of a structure; those of the reflex are computed, or given with shape (n, columns)."""
    lags = record.intrinsic.shape[1]
    groups = [record.intrinsic]
    if structure.direction:
        if reflex is None:
            reflex = delayed(record.reflex[structure.direction], structure.delay_s, record.rate_hz)
        groups.append(reflex)
    end = sum(group.shape[1] for group in groups)
    groups += [record.squared[:, None]] * structure.stiffening + [np.ones((record.angle.size, 1))]
    groups = [group[record.kept] for group in groups]
    # one scale for all columns of a pathway, so that the penalty does not distort its response
    scale = np.concatenate(
        [np.full(group.shape[1], np.sqrt(np.mean(group[: record.training] ** 2))) for group in groups]
    )
    penalty = np.zeros((scale.size, scale.size))
    penalty[:lags, :lags] = np.diag((np.abs(np.arange(lags) - lags // 2) > 1).astype(float))
    if end - lags > 1:
        bends = np.diff(np.eye(end - lags + 2), 2, axis=0)[:, 1:-1]
        penalty[lags:end, lags:end] = bends.T @ bends
    return _Design(
        columns=np.hstack(groups) / scale,
        scale=scale,
        penalty=penalty,
        intrinsic=slice(0, lags),
        reflex=slice(lags, end),
        stiffening=slice(end, scale.size - 1),
    )


def _candidates(record: _Record, options: ParallelCascadeOptions) -> list[Structure]:
    """Structures to try, without their penalty."""
    rate = record.rate_hz
    shortest, longest = options.reflex_delays_s
    first, last = int(np.ceil(shortest * rate - 1e-6)), int(np.floor(longest * rate + 1e-6))
    delays = np.arange(first, max(first, last) + 1) / rate
    fitted = slice(record.kept.start, record.kept.start + record.training)
    directions = [s for s, reflex in record.reflex.items() if np.any(reflex[fitted])]
    return [
        Structure(direction, stiffening, float(delay), 0.0)
        for stiffening in (False, True)
        for direction in (0, *directions)
        for delay in (delays if direction else [0.0])
    ]


def _folds(training: int, rate_hz: float, options: ParallelCascadeOptions) -> list[np.ndarray]:
    """Blocks of the fitted part (samples): at least two, otherwise none shorter than the reflex."""
    memory = (options.reflex_length_s + options.reflex_delays_s[1]) * rate_hz
    count = max(2, min(options.folds, int(training / memory)))
    return np.array_split(np.arange(training), count)


def _fold_errors(record, structure, y, folds, options) -> np.ndarray:
    """Mean squared error (N²·m²) of every block, fitted to the others, shape (penalties, folds)."""
    design = _design(record, structure, options)
    columns = [design.columns[fold] for fold in folds]
    normal = np.array([x.T @ x for x in columns])
    right = np.array([x.T @ y[fold] for x, fold in zip(columns, folds, strict=True)])
    power = np.array([y[fold] @ y[fold] for fold in folds])
    size = np.array([fold.size for fold in folds])
    others, left = normal.sum(axis=0) - normal, right.sum(axis=0) - right
    errors = []
    for penalty in options.penalties:
        weight = penalty * (record.training - size)
        p = np.linalg.solve(others + weight[:, None, None] * design.penalty, left[..., None])[..., 0]
        product = np.einsum("fi,fij,fj->f", p, normal, p) - 2.0 * np.einsum("fi,fi->f", p, right)
        errors.append((power + product) / size)
    return np.array(errors)


def _choose(errors: dict[Structure, np.ndarray]) -> Structure:
    """The simplest structure whose error is within one standard error of the smallest.

    The standard error is that of the difference over blocks. A structure without reflex is simpler than one
    with, and one without angle-dependent stiffness simpler than one with.
    """
    best: dict[tuple[int, bool], Structure] = {}
    for s in errors:
        kind = (s.direction, s.stiffening)
        if kind not in best or errors[s].mean() < errors[best[kind]].mean():
            best[kind] = s
    smallest = errors[min(best.values(), key=lambda s: errors[s].mean())]
    simplest_first = sorted(
        best.values(), key=lambda s: (abs(s.direction), s.stiffening, errors[s].mean(), -s.direction)
    )
    for s in simplest_first:
        more = errors[s] - smallest
        if more.mean() <= more.std(ddof=1) / np.sqrt(more.size):
            return s
    raise AssertionError("the best structure is within one standard error of itself")


def _impedance_of_response(record: _Record) -> np.ndarray:
    """Matrix that maps h to I, B, K (N·m·s²/rad, N·m·s/rad, N·m/rad), shape (3, lags)."""
    fitted = slice(record.kept.start, record.kept.start + record.training)
    time = np.arange(record.angle.size) / record.rate_hz
    velocity = derivative(time, record.angle)
    motion = np.column_stack(
        [derivative(time, velocity), velocity, record.angle, np.ones_like(record.angle)]
    )[fitted]
    scale = np.linalg.norm(motion, axis=0)
    mapped = np.linalg.lstsq(motion / scale, record.intrinsic[fitted], rcond=None)[0]
    return (mapped / scale[:, None])[:3]


def _shown_response(h: np.ndarray, rate_hz: float, lowpass) -> tuple[np.ndarray, np.ndarray]:
    """Lag (s) and low-pass filtered h / T (N·m/rad per s), over twice the range of lags."""
    reach = h.size // 2
    room = round(0.25 * rate_hz)
    padded = np.concatenate([np.zeros(room), h * rate_hz, np.zeros(room)])
    shown = slice(room - reach, room + h.size + reach)
    return np.arange(-2 * reach, 2 * reach + 1) / rate_hz, lowpass(padded)[shown]


def _fit_muscle(record, structure, options, block, draws, rng) -> MuscleFit:
    """Muscle model: frequency and damping by optimisation, the rest by regression, structure as selected."""
    kernels = knot_responses(options.reflex_length_s, options.reflex_knot_s, record.rate_hz).shape[0]
    u = delayed(record.velocity[structure.direction], structure.delay_s, record.rate_hz)
    y = record.torque[record.kept]
    training = record.training

    def design(constants: np.ndarray) -> _Design:
        through = muscle_response(u, record.rate_hz, *np.exp(constants))
        return _design(record, structure, options, through[:, None])

    def solve(made: _Design) -> np.ndarray:
        x = made.columns[:training]
        weight = structure.penalty * training * made.penalty
        return np.linalg.solve(x.T @ x + weight, x.T @ y[:training])

    def error(constants: np.ndarray) -> float:
        made = design(constants)
        left = y[:training] - made.columns[:training] @ solve(made)
        return float(left @ left)

    found = scipy.optimize.minimize(
        error,
        np.log(MUSCLE_START),
        method="Nelder-Mead",
        bounds=np.log(MUSCLE_BOUNDS),
        options={"xatol": 1e-3, "fatol": 1e-6 * float(y @ y), "maxfev": 120},
    )
    made = design(found.x)
    solution = solve(made)
    predicted = made.columns @ solution
    frequency, damping = np.exp(found.x)
    at = made.reflex.start
    gain = float(solution[at] / made.scale[at])
    # one Gauss-Newton step per draw: derivatives of the torque by both logarithms are regressors
    up, down = (
        np.column_stack(
            [
                muscle_response(u, record.rate_hz, *np.exp(found.x + shift))
                for shift in sign * SLOPE * np.eye(2)
            ]
        )[record.kept][:training]
        for sign in (1.0, -1.0)
    )
    slopes = gain * (up - down) / (2.0 * SLOPE)
    drawn = bootstrap_blocks(
        np.hstack([made.columns[:training], slopes]),
        y[:training],
        block,
        draws,
        rng,
        np.pad(structure.penalty * training * made.penalty, (0, 2)),
    )
    time = np.arange(kernels) / record.rate_hz
    w = 2.0 * np.pi * frequency
    muscle = ([w**2], [1.0, 2.0 * damping * w, w**2])
    return MuscleFit(
        constants=np.array([gain, frequency, damping]),
        bootstrap=np.column_stack(
            [drawn[:, at] / made.scale[at], frequency * np.exp(drawn[:, -2]), damping * np.exp(drawn[:, -1])]
        ),
        response=gain * scipy.signal.impulse(muscle, T=time)[1],
        predicted=predicted,
        vaf=evaluate_held_out(y, predicted, training),
    )
