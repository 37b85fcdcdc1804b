"""Structure of a parallel-cascade model by cross-validation over blocks of the fitted part.

Direction, kernel and threshold of the reflex are chosen first, in this order, by the smallest cross-validated
error with all terms present. Without a threshold, the velocity is also rectified before the low-pass, because
a filtered velocity rings around a step, which passes for stretch; there is no threshold if the error without
one is within the tolerance of the terms. The terms follow: the simplest set whose error is within a tolerance
of the smallest. A reflex, and knots in place of Laguerre functions, must lower the error by more than
``SEPARATED`` standard errors of the difference over blocks. The terms of the reflex (gain_slope, unloading),
which do not change what K means, are then chosen again by a tolerance of the record itself. With e[s, f] the
error of block f with the set s, fitted to the other blocks, and E[s] its mean over blocks,

    s(t) = the simplest s with E[s] <= (1 + t) min E,    s_f(t) = the same without block f
    t    = the tolerance with the smallest mean over f of e[s_f(t), f]

This cross-validates the choice: terms that the other blocks choose by chance do not predict a block, terms
that exist do (Varma & Simon 2006). The delay is chosen last: among the delays that the record does not
separate, the one closest to the expected delay. All errors refer to the weighted signals.
"""

from dataclasses import dataclass, replace
from itertools import pairwise, product
from typing import Annotated

import numpy as np

from tepsipe.identification.cascade.fit import (
    Assumption,
    ModelScore,
    SlowModel,
    Structure,
    estimate_slow_model,
)
from tepsipe.identification.cascade.normal_equations import (
    BlockSums,
    block_sums,
    require_determined,
    solve_bounded,
    solve_drawn,
    solve_without_each,
)
from tepsipe.identification.cascade.options import ParallelCascadeOptions
from tepsipe.identification.cascade.record import CascadeRecord, Design, make_design

# standard errors by which a reflex must lower the cross-validated error
SEPARATED = 2.0
# relative tolerances that are tried for the terms of the reflex, the one of the fewest terms first
TOLERANCES = (0.03, 0.01, 0.003, 0.001, 0.0)
# terms that change what K means
OF_JOINT = ("stops", "relaxing", "stiffening")


@dataclass(frozen=True)
class Selection:
    """Structure selected by cross-validation, and the errors it was selected by."""

    record: CascadeRecord
    """The record, weighted against its slow torque."""
    structure: Structure
    """Selected structure."""
    full: Structure
    """All terms that were tried."""
    errors: dict[Structure, np.ndarray]
    """Error of every block (N²·m²) for the models that were compared, the simplest first, shape (folds,)."""
    variants: dict[Structure, np.ndarray]
    """The same for other kernels and thresholds of the reflex with all terms; empty without a reflex, shape
    (folds,)."""
    delays: dict[float, np.ndarray]
    """The same for every profiled delay (s) of the selected structure; empty without a reflex, shape
    (folds,)."""
    thresholds: dict[float, np.ndarray]
    """The same for every velocity threshold (rad/s), shape (folds,)."""


def select_structure(record: CascadeRecord) -> Selection:
    """Select terms, kernel, threshold, delay and penalty; weight the record against its slow torque."""
    options = record.options
    full = Structure(1, True, options.expected_delay_s, 0.0, stops=bool(record.radii), gain_slope=True)
    full = replace(full, pole_per_s=_middle(options.reflex_poles_per_s))
    first = replace(full, direction=0, gain_slope=False, delay_s=0.0, pole_per_s=0.0)
    starts = [replace(full, direction=sign) for sign in (1, -1) if _stretched(record, sign)] or [first]
    start, _ = _best(record, starts)
    record = record.weighted(_slow_model(record, start))
    variants = {}
    if start.direction:
        # without a threshold, both directions are interchangeable once unloading is a term
        start = replace(_best(record, starts)[0], unloading=True)
        kernels = dict(_errors(record, replace(start, pole_per_s=p)) for p in _poles(options))
        start = _kernel(kernels)
        thresholds = [replace(start, threshold_rad_per_s=v) for v in options.reflex_thresholds_rad_per_s]
        thresholds += [replace(s, unfiltered=True) for s in thresholds if not s.threshold_rad_per_s]
        variants = dict(_errors(record, structure) for structure in thresholds)
        start = _with_threshold(variants, options.term_tolerance)
        if start.pole_per_s:
            # relative errors of the other kernels as at the first threshold
            ratio = variants[start] / kernels[_at_kernel(kernels, start)]
            variants |= {
                replace(s, threshold_rad_per_s=start.threshold_rad_per_s, unfiltered=start.unfiltered): error
                * ratio
                for s, error in kernels.items()
                if s.pole_per_s not in (0.0, start.pole_per_s)
            }
    start = replace(start, relaxing=bool(options.relaxation_times_s))
    errors = _errors_of_terms(record, start)
    structure = choose(errors, options.term_tolerance)
    if not structure.direction:
        return Selection(record, structure, start, errors, {}, {}, {})
    delays = _profile(record, structure, "delay_s", _delays(record))
    structure = replace(structure, delay_s=_delay(delays, options))
    structure, _ = _best(record, [structure])
    thresholds = _profile(record, structure, "threshold_rad_per_s", options.reflex_thresholds_rad_per_s)
    return Selection(record, structure, start, errors, variants, delays, thresholds)


def alike(profile: dict[float, np.ndarray], tolerance: float) -> list[float]:
    """Values whose mean error exceeds the smallest by no more than a relative tolerance.

    tolerance: relative difference.
    Returns: the values (their unit).
    """
    smallest = min(error.mean() for error in profile.values())
    return [value for value, error in profile.items() if error.mean() <= (1.0 + tolerance) * smallest]


def choose(errors: dict[Structure, np.ndarray], tolerance: float) -> Structure:
    """The structure that `choose_rows` selects, with terms of the reflex by their own tolerance.

    errors: errors (N²·m²) of every structure, the simplest first.
    tolerance: relative difference of the error below which a simpler structure is taken.
    Returns: the one that is chosen.
    """
    table = np.array(list(errors.values()))
    reflex = np.array([s.direction != 0 for s in errors])
    structures = list(errors)
    chosen = structures[int(choose_rows(table[None], reflex, tolerance)[0])]
    if not chosen.direction:
        return chosen
    rows = [k for k, s in enumerate(structures) if s.direction and _of_joint(s) == _of_joint(chosen)]
    mean, own = table[rows].mean(axis=1), cross_validated_tolerance(table[rows])
    return structures[rows[int(np.argmax(mean <= (1.0 + own) * mean.min()))]]


def cross_validated_tolerance(table: Annotated[np.ndarray, "(structures, folds)"]) -> float:
    """Tolerance t whose choices s_f(t) predict the blocks best, see above; the largest of equal ones.

    table: errors of every structure, the simplest first.
    """
    others = table.sum(axis=1, keepdims=True) - table
    rows = [np.argmax(others <= (1.0 + tolerance) * others.min(axis=0), axis=0) for tolerance in TOLERANCES]
    return TOLERANCES[int(np.argmin(table[rows, np.arange(table.shape[1])].mean(axis=1)))]


def choose_rows(
    tables: Annotated[np.ndarray, "(k, structures, folds)"],
    reflex: Annotated[np.ndarray, "(structures,)"],
    tolerance: float,
    among: Annotated[np.ndarray, "(k,)"] | None = None,
) -> Annotated[np.ndarray, "(k,)"]:
    """Choose the rows of tables of errors.

    With and without a reflex, the simplest structure whose mean error exceeds the smallest by at most the
    tolerance is a candidate. The candidate with a reflex is chosen if its mean error is smaller by more than
    ``SEPARATED`` standard errors of the difference over blocks. To average over structures, any of those
    within the tolerance is a candidate.

    reflex: whether a structure has a reflex.
    tolerance: relative tolerance.
    among: place of the candidate among the structures within the tolerance, from 0 to below 1; the simplest
    if left out.
    """
    at = np.arange(tables.shape[0])
    chosen = []
    for kind in (~reflex, reflex):
        rows = np.flatnonzero(kind)
        if rows.size:
            mean = tables[:, rows].mean(axis=2)
            within = mean <= (1.0 + tolerance) * mean.min(axis=1, keepdims=True)
            place = 0 if among is None else np.floor(among * within.sum(axis=1)).astype(int)
            chosen.append(rows[np.argmax(np.cumsum(within, axis=1) > np.reshape(place, (-1, 1)), axis=1)])
    if len(chosen) == 1:
        return chosen[0]
    gain = tables[at, chosen[0]] - tables[at, chosen[1]]
    return np.where(_separated(gain), chosen[1], chosen[0])


def cross_validated(record: CascadeRecord, structure: Structure) -> Annotated[float, "%"]:
    """VAF (%) of the blocks of the fitted part, each predicted from the others with their offset."""

    def vaf() -> float:
        design = make_design(record, structure)
        folds = fold_slices(record)
        sums = block_sums(design.white, record.white_torque, folds)
        solutions = solve_without_each(sums, structure.penalty * design.penalty, design.bounded)
        return _vaf_of_folds(block_sums(design.columns, _about_mean(record), folds), solutions)

    return record.once("VAF", structure, vaf)


def _about_mean(record: CascadeRecord) -> np.ndarray:
    """Torque of the part in use about the mean of the fitted part (N·m)."""
    return record.used - record.used[: record.training].mean()


def _vaf_of_folds(sums: BlockSums, solutions: np.ndarray) -> float:
    """VAF (%) of every block by the solution without it, with the offset of the other blocks."""
    return sums.vaf(sums.levelled(solutions, 1.0 - np.eye(sums.size.size)))


def fit_once(record: CascadeRecord, design: Design, structure: Structure) -> Annotated[np.ndarray, "(p,)"]:
    """Coefficients of the columns (N·m over their unit); the offset is the mean residual of the others."""
    size = record.training
    sums = block_sums(design.white, record.white_torque, [slice(0, size)])
    weight = structure.penalty * size * design.penalty
    require_determined(sums.normal[0] + weight, design.bounded)
    coefficients = solve_bounded(sums.normal + weight, sums.right, design.bounded)[0] / design.scale
    coefficients[-1] += np.mean(record.used[:size] - design.torque(coefficients, size))
    return coefficients


def assumptions(selection: Selection) -> tuple[Assumption, ...]:
    """Delay and threshold of the reflex, with the ranges that the record does not separate.

    Returns: ranges (s, rad/s); empty without a reflex.
    """
    if not selection.delays:
        return ()
    ranges = []
    for quantity, unit, field, profile in (
        ("reflex_delay", "s", "delay_s", selection.delays),
        ("reflex_threshold", "rad/s", "threshold_rad_per_s", selection.thresholds),
    ):
        within = alike(profile, selection.record.options.delay_tolerance)
        low, high = min(within), max(within)
        ends = [
            cross_validated(selection.record, replace(selection.structure, **{field: value}))
            for value in {low, high, getattr(selection.structure, field)}
        ]
        # the range is at most the value and its two neighbours
        ranges.append(
            Assumption(
                quantity,
                unit,
                float(getattr(selection.structure, field)),
                float(low),
                float(high),
                min(ends),
                max(ends),
                len(within) <= 3 and getattr(selection.structure, field) in within,
            )
        )
    return tuple(ranges)


def scores(selection: Selection) -> tuple[ModelScore, ...]:
    """Errors and VAFs of the models that were compared, the simplest first.

    Returns: relative errors and VAFs (%).
    """
    record, folds = selection.record, fold_slices(selection.record)
    best = min(selection.errors.values(), key=np.mean)
    design = make_design(record, selection.full)
    sums = block_sums(design.white, record.white_torque, folds)
    torque = _about_mean(record)
    fitted = block_sums(design.columns, torque, folds)
    held_out = block_sums(design.columns, torque, [slice(record.training, torque.size)])
    models = []
    for structure, error in selection.errors.items():
        columns = design.of(structure)
        fold_sums, bounded = sums.of(columns), design.bounded[columns]
        penalty = structure.penalty * design.penalty[np.ix_(columns, columns)]
        without = solve_without_each(fold_sums, penalty, bounded)
        each_once = np.ones((1, len(folds)))
        every = solve_drawn(fold_sums, each_once, penalty, bounded)
        every = fitted.of(columns).levelled(every, each_once)
        more = 100.0 * (error - best) / best.mean()
        models.append(
            ModelScore(
                structure,
                float(more.mean()),
                float(more.std(ddof=1) / np.sqrt(more.size)),
                _vaf_of_folds(fitted.of(columns), without),
                held_out.of(columns).vaf(every),
                len(columns),
            )
        )
    return tuple(models)


def fold_slices(record: CascadeRecord) -> list[slice]:
    """Blocks of the fitted part (samples): at least two, otherwise none shorter than the reflex."""
    options = record.options
    memory = (options.reflex_length_s + options.reflex_delays_s[1]) * record.rate_hz
    count = max(2, min(options.folds, int(record.training / memory)))
    ends = np.linspace(0, record.training, count + 1).round().astype(int)
    return [slice(int(a), int(b)) for a, b in pairwise(ends)]


# ---- parts ---------------------------------------------------------------------------------------


def _stretched(record: CascadeRecord, direction: int) -> bool:
    """Test for motion of the angle in a direction within the fitted part."""
    return bool(np.any(record.reflex_input("reflex", Structure(direction, False, 0.0, 0.0))[record.fitted]))


def _of_joint(structure: Structure) -> list[bool]:
    """Presence of every term that changes what K means."""
    return [getattr(structure, name) for name in OF_JOINT]


def _middle(values: tuple[float, ...]) -> float:
    return sorted(values)[len(values) // 2] if values else 0.0


def _separated(gain: np.ndarray) -> np.ndarray:
    """Test for a clearly positive difference of errors over blocks, the last axis."""
    return gain.mean(axis=-1) > SEPARATED * gain.std(axis=-1, ddof=1) / np.sqrt(gain.shape[-1])


def _poles(options: ParallelCascadeOptions) -> list[float]:
    """Poles that are tried (rad/s), 0 for knots."""
    return [0.0, *options.reflex_poles_per_s]


def _kernel(errors: dict[Structure, np.ndarray]) -> Structure:
    """Kernel of the reflex: knots only if their error is clearly smaller."""
    knots = next(s for s in errors if not s.pole_per_s)
    smooth = [s for s in errors if s.pole_per_s]
    if not smooth:
        return knots
    best = min(smooth, key=lambda s: errors[s].mean())
    return knots if _separated(errors[best] - errors[knots]) else best


def _with_threshold(errors: dict[Structure, np.ndarray], tolerance: float) -> Structure:
    """Structure of the smallest error; without a threshold if one is within a tolerance of it."""
    mean = {structure: error.mean() for structure, error in errors.items()}
    within = [s for s in mean if mean[s] <= (1.0 + tolerance) * min(mean.values())]
    return min([s for s in within if not s.threshold_rad_per_s] or within, key=lambda s: mean[s])


def _at_kernel(errors: dict[Structure, np.ndarray], structure: Structure) -> Structure:
    """Structure with the kernel of a given structure, out of several kernels."""
    return next(s for s in errors if s.pole_per_s == structure.pole_per_s)


def _slow_model(record: CascadeRecord, structure: Structure) -> SlowModel:
    """Slow torque in the residual of ordinary least squares with all terms."""
    design = make_design(record, structure)
    predicted = design.torque(fit_once(record, design, structure), record.training)
    return estimate_slow_model(record.used[: record.training] - predicted, record.rate_hz)


def _fold_errors(
    sums: BlockSums, design: Design, columns: np.ndarray, penalties: tuple[float, ...]
) -> np.ndarray:
    """Error of every block, fitted to the others, for every penalty, shape (penalties, folds) (N²·m²)."""
    fold_sums = sums.of(columns)
    penalty = np.array(penalties)[:, None, None] * design.penalty[np.ix_(columns, columns)]
    solutions = solve_without_each(fold_sums, penalty, design.bounded[columns])
    return np.array([fold_sums.errors(each) for each in solutions])


def _errors(record: CascadeRecord, structure: Structure) -> tuple[Structure, np.ndarray]:
    """The structure with its best penalty, and the errors of the blocks."""

    def errors() -> np.ndarray:
        design = make_design(record, structure)
        sums = block_sums(design.white, record.white_torque, fold_slices(record))
        return _fold_errors(sums, design, design.of(structure), record.options.penalties)

    return _with_penalty(record, structure, record.once("errors", replace(structure, penalty=0.0), errors))


def _with_penalty(record, structure: Structure, errors: np.ndarray) -> tuple[Structure, np.ndarray]:
    at = int(np.argmin(errors.mean(axis=1)))
    return replace(structure, penalty=record.options.penalties[at]), errors[at]


def _best(record: CascadeRecord, structures: list[Structure]) -> tuple[Structure, np.ndarray]:
    """The structure of the smallest error with its penalty, and the errors of its blocks."""
    return min((_errors(record, structure) for structure in structures), key=lambda x: x[1].mean())


def _errors_of_terms(record: CascadeRecord, full: Structure) -> dict[Structure, np.ndarray]:
    """Errors of all sets of terms within a full structure, the simplest first."""
    design = make_design(record, full)
    sums = block_sums(design.white, record.white_torque, fold_slices(record))
    candidates = []
    of_reflex = ("gain_slope", "unloading")
    for reflex, *present in product((False, True), repeat=1 + len(OF_JOINT + of_reflex)):
        terms = dict(zip(OF_JOINT + of_reflex, present, strict=True))
        if any(terms[name] and not getattr(full, name) for name in OF_JOINT):
            continue
        if (reflex and not full.direction) or (not reflex and any(terms[name] for name in of_reflex)):
            continue
        structure = replace(full, **terms)
        if not reflex:
            bare = Structure(0, False, 0.0, 0.0)
            of_input = ("direction", "delay_s", "threshold_rad_per_s", "unfiltered", "pole_per_s")
            structure = replace(structure, **{name: getattr(bare, name) for name in of_input})
        errors = _fold_errors(sums, design, design.of(structure), record.options.penalties)
        candidates.append(_with_penalty(record, structure, errors))
    # a reflex is the largest step; terms of the reflex are smaller steps than terms of the joint
    candidates.sort(key=lambda x: (abs(x[0].direction), x[0].terms, x[1].mean()))
    return dict(candidates)


def _delays(record: CascadeRecord) -> list[float]:
    """Delays that are profiled (s), whole samples."""
    options, rate = record.options, record.rate_hz
    shortest = min(options.profiled_delays_s[0], options.reflex_delays_s[0])
    longest = max(options.profiled_delays_s[1], options.reflex_delays_s[1])
    first, last = int(np.ceil(shortest * rate - 1e-6)), int(np.floor(longest * rate + 1e-6))
    at = range(first, max(first, last) + 1)
    tried = [options.reflex_delays_s[0] * rate - 1e-6, options.reflex_delays_s[1] * rate + 1e-6]
    # every sample where a delay can be chosen, every second one beyond
    return [float(k) / rate for k in at if tried[0] <= k <= tried[1] or (k - first) % 2 == 0]


def _delay(profile: dict[float, np.ndarray], options: ParallelCascadeOptions) -> float:
    """Delay closest to the expectation, out of those that are allowed and alike (s)."""
    shortest, longest = options.reflex_delays_s
    tried = {d: e for d, e in profile.items() if shortest - 1e-9 <= d <= longest + 1e-9} or profile
    return min(alike(tried, options.delay_tolerance), key=lambda d: abs(d - options.expected_delay_s))


def _profile(record: CascadeRecord, structure: Structure, field: str, values) -> dict[float, np.ndarray]:
    """Errors of the blocks with other values of one field."""
    return {float(value): _errors(record, replace(structure, **{field: float(value)}))[1] for value in values}
