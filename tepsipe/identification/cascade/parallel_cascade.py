"""Parallel-cascade model: intrinsic stiffness and stretch reflex of a joint under imposed movement.

The model of Kearney, Stein & Parameswaran (1997), with both pathways in one regression:

    tau(t)   = tau_I(t) + tau_S(t) + tau_R(t) + offset
    tau_I(t) = sum over k of h[k] theta(t - k T) + c (theta(t) - theta_0)^2,        |k T| <= lag
    tau_S(t) = sum over j of w[j] z_j(t),   dz_j = dtheta limited to |z_j| <= r_j,   w[j] >= 0
             + sum over j of v[j] x_j(t),   x_j' = theta' - x_j / T_j,               v[j] >= 0
    tau_R(t) = sum over k of (g[k] u(t') + m[k] u(t') (theta(t') - theta_0) + b[k] u_-(t')) T
    t'       = t - delay - k T,                                                     k >= 0
    u(t)     = theta'(t) beyond a threshold in the direction ``direction``, else 0;  u_- in the other one

T is the sampling period, theta_0 the mean angle of the fitted part, 2 c the angle-dependent stiffness (change
of K per angle). tau_S is short-range stiffness: elastic-plastic stop elements (Prandtl 1928) of fixed radii
r_j. K + sum of w is then the stiffness of small movements, and K the stiffness beyond yield; the stiffness of
human calf muscles falls steadily with amplitude (Loram, Maganaris & Lakie 2007). Elements of stiffness v
relax with fixed time constants T_j (Maxwell). g is the reflex response, and its integral the reflex gain G.
The integral of m is the change of G per angle; the integral of b is the gain of unloading, the delayed
response to the other direction. They are linear between knots and zero at both ends, or sums of Laguerre
functions t^k exp(-pole t), k >= 1. All signals and regressors are low-pass filtered identically, which
preserves their linear relation. The criterion

    |W (tau - tau_I - tau_S - tau_R - offset)|^2 + lambda N (|h[k], |k| > 1|^2 + |roughness of g, m, b|^2)

is minimised over the N samples of the fitted part, with every group of regressors scaled to unit size. W
whitens the slow voluntary torque (`tepsipe.identification.cascade.fit`): generalised least squares.
The offset is the mean of the residual without W. h[-1], h[0] and h[1] are not penalised: by central
differences they are I theta'' + B theta' + K theta. Roughness means second differences between knots, or the
size of the Laguerre coefficients; a large lambda reduces the model to I, B, K and stops. The structure is
selected by cross-validation (`tepsipe.identification.cascade.selection`).

Intervals: blocks are drawn with replacement. For each draw, kernel, threshold and terms are any of those that
folds drawn with replacement do not separate from the best, not only the simplest. The intervals thus average
over structures, but include neither the choice of the delay, which is assumed where the record does not
determine it, nor the bias of the penalty.
Percentiles of draws from n blocks are too narrow; they are expanded
(`tepsipe.statistics.bootstrap.expanded_tail`).
"""

from dataclasses import dataclass, replace

import numpy as np

from tepsipe.identification.cascade.fit import ParallelCascadeFit, Relaxing, ShortRange, SlowTorque, Structure
from tepsipe.identification.cascade.muscle import fit_muscle
from tepsipe.identification.cascade.normal_equations import block_sums, row_spans, solve_drawn
from tepsipe.identification.cascade.record import (
    REFLEX_GROUPS,
    CascadeRecord,
    Design,
    kernel_responses,
    make_design,
)
from tepsipe.identification.cascade.selection import (
    Selection,
    alike,
    assumptions,
    choose_rows,
    cross_validated,
    fit_once,
    scores,
    select_structure,
)
from tepsipe.signals.differentiation import derivative
from tepsipe.statistics.bootstrap import expanded_tail
from tepsipe.statistics.goodness_of_fit import evaluate_held_out

# fraction of the area of a response that counts as its duration
LASTING = 0.95


@dataclass(frozen=True)
class _Drawn:
    """Coefficients of a design (N·m over the column's unit), and bootstraps of them or of what follows."""

    design: Design
    solution: np.ndarray
    bootstrap: dict[str, np.ndarray]

    def mapped(self, name: str, matrix: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Linear combinations, rows of ``matrix``, of the coefficients of one group, and their bootstrap."""
        columns = self.design.groups[name]
        value = matrix @ self.solution[columns] if columns.stop > columns.start else np.zeros(matrix.shape[0])
        return value, self.bootstrap[name] @ matrix.T

    def torque(self, *names: str) -> np.ndarray:
        """Torque of groups of columns, all if left out, over the part that is used (N·m)."""
        return self.design.torque(self.solution, self.design.record.used.size, *names)


def identify_cascade(
    record: CascadeRecord, block: int, draws: int, rng: np.random.Generator
) -> ParallelCascadeFit:
    """Fit both pathways to the first part of a record and predict all of it from the angle.

    record: from `make_record`.
    block, draws: length of the bootstrapped blocks (samples), and number of draws.
    """
    selection = select_structure(record)
    record, structure, training = selection.record, selection.structure, record.training
    blocks = [slice(k * block, (k + 1) * block) for k in range(training // block)]
    drawn_blocks = rng.integers(0, len(blocks), (draws, len(blocks)))
    times = np.array([np.bincount(draw, minlength=len(blocks)) for draw in drawn_blocks], dtype=float)
    estimate = _draw(selection, blocks, times, rng)
    predicted = estimate.torque()
    motion = _motion_map(record)
    impedance, impedance_drawn = estimate.mapped("intrinsic", motion["intrinsic"])
    relaxing = _relaxing(record, estimate)
    quick, quick_drawn = (
        impedance[2] + relaxing.stiffness,
        impedance_drawn[:, 2] + relaxing.stiffness_bootstrap,
    )
    working, working_drawn = impedance[2], impedance_drawn[:, 2]
    for name in ("stops", "relaxing"):
        slope, slope_drawn = (x[..., 0] for x in estimate.mapped(name, motion[name][2:]))
        working, working_drawn = working + slope, working_drawn + slope_drawn
    stiffening, stiffening_drawn = (x[..., 0] for x in estimate.mapped("stiffening", np.array([[2.0]])))
    reflex_torque = estimate.torque(*REFLEX_GROUPS)
    spread = np.mean((record.used[:training] - record.used[:training].mean()) ** 2)
    lag, smooth = _shown_response(estimate.solution[estimate.design.groups["intrinsic"]], record)
    return ParallelCascadeFit(
        structure=structure,
        blocks=len(blocks),
        predicted=predicted,
        reflex_torque=reflex_torque,
        stop_torque=estimate.torque("stops", "relaxing"),
        vaf=evaluate_held_out(record.used, predicted, training),
        vaf_cross_validated=cross_validated(record, structure),
        impedance=impedance,
        impedance_bootstrap=impedance_drawn,
        working_stiffness=float(working),
        working_stiffness_bootstrap=working_drawn,
        short_range=_short_range(record, estimate, quick, quick_drawn),
        relaxing=relaxing,
        stiffening=float(stiffening),
        stiffening_bootstrap=stiffening_drawn,
        reflex_share=float(100.0 * np.var(reflex_torque[:training]) / spread),
        intrinsic_time=lag,
        intrinsic_response=smooth,
        delay_range_s=_delay_range(selection),
        slow=_slow_torque(record, predicted),
        assumptions=assumptions(selection),
        models=scores(selection),
        **_reflex(selection, estimate, blocks, times),
    )


def _draw(selection: Selection, blocks: list[slice], times: np.ndarray, rng) -> _Drawn:
    """Estimate of the selected structure; bootstrap of it and of those that folds do not separate from it."""
    record, structure = selection.record, selection.structure
    candidates = list(selection.errors)
    table = np.array(list(selection.errors.values()))
    folds = rng.integers(0, table.shape[1], (times.shape[0], table.shape[1]))
    reflex = np.array([candidate.direction != 0 for candidate in candidates])
    among = rng.random(times.shape[0])
    tables = np.swapaxes(table[:, folds], 0, 1)
    terms = choose_rows(tables, reflex, record.options.term_tolerance, among)
    shapes = list(selection.variants) or [selection.full]
    errors = np.array(list(selection.variants.values()) or [np.ones(table.shape[1])])
    variants = choose_rows(
        np.swapaxes(errors[:, folds], 0, 1),
        np.ones(len(shapes), dtype=bool),
        record.options.term_tolerance,
        rng.random(times.shape[0]),
    )
    variants[~reflex[terms]] = -1
    lags = record.regressors("intrinsic", structure, slice(0, 1)).shape[1]
    sizes = {"intrinsic": lags, "stops": len(record.radii), "stiffening": 1, "response": _samples(selection)}
    sizes["relaxing"] = len(record.options.relaxation_times_s)
    drawn = {name: np.zeros((times.shape[0], size)) for name, size in sizes.items()}
    drawn |= {name: np.zeros((times.shape[0], 1)) for name in REFLEX_GROUPS}
    for variant in np.unique(variants):
        shape = shapes[variant] if variant >= 0 else structure
        rows = np.unique(terms[variants == variant])
        used = {row: _at(candidates[row], structure, shape) for row in rows}
        design = make_design(record, _union(list(used.values())))
        sums = block_sums(design.white, record.white_torque, blocks)
        for row, each in used.items():
            taken = np.flatnonzero((variants == variant) & (terms == row))
            columns = design.of(each)
            penalty = each.penalty * design.penalty[np.ix_(columns, columns)]
            solutions = np.zeros((taken.size, design.scale.size))
            solutions[:, columns] = solve_drawn(
                sums.of(columns), times[taken], penalty, design.bounded[columns]
            )
            _keep(drawn, taken, design, solutions / design.scale, each, record)
    design = make_design(record, structure)
    return _Drawn(design, fit_once(record, design, structure), drawn)


def _keep(
    drawn: dict, taken: np.ndarray, design: Design, coefficients: np.ndarray, structure, record
) -> None:
    """Write coefficients, or quantities derived from them, to the selected draws."""
    for name in ("intrinsic", "stops", "relaxing", "stiffening"):
        columns = design.groups[name]
        if columns.stop > columns.start:
            drawn[name][taken] = coefficients[:, columns]
    kernels = kernel_responses(structure.pole_per_s, record.options, record.rate_hz)
    for name in REFLEX_GROUPS:
        columns = design.groups[name]
        if columns.stop > columns.start:
            drawn[name][taken] = coefficients[:, columns] @ kernels.sum(axis=0)[:, None] / record.rate_hz
    columns, size = design.groups["reflex"], drawn["response"].shape[1]
    if columns.stop > columns.start and size:
        taken_kernels = kernels[:size]
        drawn["response"][np.ix_(taken, np.arange(taken_kernels.shape[0]))] = (
            coefficients[:, columns] @ taken_kernels.T
        )


def _samples(selection: Selection) -> int:
    """Length of the reflex response (samples), 0 without a reflex."""
    if not selection.structure.direction:
        return 0
    record = selection.record
    return kernel_responses(selection.structure.pole_per_s, record.options, record.rate_hz).shape[0]


def _at(candidate: Structure, structure: Structure, shape: Structure) -> Structure:
    """Terms of a compared structure with the kernel and threshold of another, and the selected delay."""
    if not candidate.direction:
        return candidate
    return replace(
        candidate,
        delay_s=structure.delay_s if structure.direction else candidate.delay_s,
        pole_per_s=shape.pole_per_s,
        threshold_rad_per_s=shape.threshold_rad_per_s,
        unfiltered=shape.unfiltered,
    )


def _union(structures: list[Structure]) -> Structure:
    """A structure with all terms of several of the same reflex."""
    names = ("stops", "relaxing", "stiffening", "gain_slope", "unloading")
    return replace(structures[0], **{name: any(getattr(s, name) for s in structures) for name in names})


def _motion_map(record: CascadeRecord) -> dict[str, np.ndarray]:
    """Matrices that map h, w and v to I, B, K (N·m·s²/rad, N·m·s/rad, N·m/rad), shape (3, columns)."""
    time = np.arange(record.angle.size) / record.rate_hz
    # near the cutoff, cubic splines make the acceleration 0.3 % too small
    velocity = derivative(time, record.angle, degree=5)
    motion = np.column_stack(
        [derivative(time, velocity, degree=5), velocity, record.angle, np.ones_like(record.angle)]
    )[record.fitted]
    scale = np.linalg.norm(motion, axis=0)
    bare = Structure(0, False, 0.0, 0.0)
    sizes = {"intrinsic": 1, "stops": len(record.radii), "relaxing": len(record.options.relaxation_times_s)}
    basis, triangle = np.linalg.qr(motion / scale)
    mapped = dict.fromkeys(sizes, np.empty((3, 0)))
    for name in (name for name, size in sizes.items() if size):
        parts = row_spans(slice(0, record.training))
        along = sum(basis[part].T @ record.regressors(name, bare, part) for part in parts)
        mapped[name] = (np.linalg.lstsq(triangle, along, rcond=None)[0] / scale[:, None])[:3]
    return mapped


def _relaxing(record: CascadeRecord, estimate: _Drawn) -> Relaxing:
    """Part of the stiffness that relaxes, of the estimate and its bootstrap."""
    columns = estimate.design.groups["relaxing"]
    times = np.array(record.options.relaxation_times_s)
    weights, drawn = estimate.solution[columns], estimate.bootstrap["relaxing"]
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = weights @ times / weights.sum() if weights.size else np.nan
        mean_drawn = drawn @ times / drawn.sum(axis=1)
    return Relaxing(
        times_s=times[: weights.size],
        weights=weights,
        stiffness=float(weights.sum()),
        stiffness_bootstrap=drawn.sum(axis=1),
        time_s=float(mean),
        time_bootstrap=mean_drawn,
    )


def _short_range(record: CascadeRecord, estimate: _Drawn, stiffness, stiffness_drawn) -> ShortRange:
    """Short-range stiffness of the estimate and its bootstrap; no radii where the structure has none."""
    columns = estimate.design.groups["stops"]
    radii, weights, drawn = np.array(record.radii), estimate.solution[columns], estimate.bootstrap["stops"]
    with np.errstate(invalid="ignore", divide="ignore"):
        radius = weights @ radii[: weights.size] / weights.sum() if weights.size else np.nan
        radius_drawn = drawn @ radii / drawn.sum(axis=1)
    return ShortRange(
        radii_rad=radii[: weights.size],
        weights=weights,
        weights_bootstrap=drawn[:, : weights.size],
        stiffness=float(stiffness + weights.sum()),
        stiffness_bootstrap=stiffness_drawn + drawn.sum(axis=1),
        yield_angle_rad=float(radius),
        yield_angle_bootstrap=radius_drawn,
    )


def _reflex(selection: Selection, estimate: _Drawn, blocks: list[slice], times: np.ndarray) -> dict:
    """Fields of the result on the reflex pathway."""
    record, structure = selection.record, selection.structure
    rate = record.rate_hz
    response, gains = np.empty(0), dict.fromkeys(REFLEX_GROUPS, 0.0)
    if structure.direction:
        kernels = kernel_responses(structure.pole_per_s, record.options, rate)
        response = kernels @ estimate.solution[estimate.design.groups["reflex"]]
        for name in REFLEX_GROUPS:
            columns = estimate.design.groups[name]
            if columns.stop > columns.start:
                gains[name] = float(kernels.sum(axis=0) @ estimate.solution[columns] / rate)
    drawn = estimate.bootstrap["response"]
    tail = expanded_tail(0.95, len(blocks))
    low, high = np.percentile(drawn, [tail, 100.0 - tail], axis=0) if drawn.size else np.empty((2, 0))
    peak = duration = np.nan
    if np.any(response):
        area = np.cumsum(np.abs(response))
        peak = structure.delay_s + float(np.argmax(np.abs(response))) / rate
        duration = float(np.searchsorted(area, LASTING * area[-1])) / rate
    muscle = None
    if structure.direction:
        muscle = fit_muscle(record, structure, blocks, times, response.size)
    return {
        "gain": gains["reflex"],
        "gain_bootstrap": estimate.bootstrap["reflex"][:, 0],
        "gain_slope": gains["gain_slope"],
        "gain_slope_bootstrap": estimate.bootstrap["gain_slope"][:, 0],
        "unloading_gain": gains["unloading"],
        "unloading_gain_bootstrap": estimate.bootstrap["unloading"][:, 0],
        "reflex_time": structure.delay_s + np.arange(response.size) / rate,
        "reflex_response": response,
        "reflex_low": low,
        "reflex_high": high,
        "reflex_peak_s": peak,
        "reflex_duration_s": duration,
        "delays": np.array(list(selection.delays)),
        "delay_vaf": _weighted_vaf(record, selection.delays),
        "muscle": muscle,
    }


def _weighted_vaf(record: CascadeRecord, profile: dict[float, np.ndarray]) -> np.ndarray:
    """Cross-validated VAF (%) of the weighted torque for every value of a profile."""
    power = np.var(record.white_torque[: record.training])
    return np.array([100.0 * (1.0 - error.mean() / power) for error in profile.values()])


def _delay_range(selection: Selection) -> tuple[float, float]:
    """Ends of the profiled delays that the record does not separate (s); 0 and 0 without a reflex."""
    if not selection.delays:
        return (0.0, 0.0)
    within = alike(selection.delays, selection.record.options.delay_tolerance)
    return (min(within), max(within))


def _slow_torque(record: CascadeRecord, predicted: np.ndarray) -> SlowTorque:
    """Slow torque from past residuals, for every horizon (units of the result)."""
    residual, rate = record.used - predicted, record.rate_hz
    horizons = record.options.slow_horizons_s
    ahead = {h: record.slow.predict(residual, rate, max(1, round(h * rate))) for h in horizons}
    scored = {h: evaluate_held_out(record.used, predicted + b, record.training) for h, b in ahead.items()}
    ordered = sorted(horizons)
    return SlowTorque(
        model=record.slow,
        sd_Nm=float(np.std(record.slow.predict(residual, rate, 0)[: record.training])),
        horizon_s=horizons[0],
        predicted=ahead[horizons[0]],
        vaf=scored[horizons[0]],
        horizons_s=np.array(ordered),
        held_out_vaf=np.array([scored[h].held_out for h in ordered]),
    )


def _shown_response(h: np.ndarray, record: CascadeRecord) -> tuple[np.ndarray, np.ndarray]:
    """Lag (s) and low-pass filtered h / T (N·m/rad per s), over twice the range of lags."""
    rate_hz, half = record.rate_hz, h.size // 2
    room = round(0.25 * rate_hz)
    padded = np.concatenate([np.zeros(room), h * rate_hz, np.zeros(room)])
    span = slice(room - half, room + h.size + half)
    return np.arange(-2 * half, 2 * half + 1) / rate_hz, record.lowpass(padded)[span]
