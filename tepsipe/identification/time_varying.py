"""Impedance that changes: in sliding windows, after a trigger, or with a scheduled quantity.

In every segment of a record, short enough for the joint to be constant in it,

    tau(t) = I theta'' + B theta' + K theta + g tau_R + a + b t

is fitted by least squares. tau_R is the reflex torque of a fit to the whole record and g the reflex gain
relative to it; the level a and the trend b stand for voluntary torque and for the operating point.

- Windows: one segment of the record per window. Intervals come from a moving-block bootstrap of the residuals
  (Künsch 1989): blocks of the residuals of the whole record, scaled by their RMS in each window.
- Ensemble: all realisations of a movement that begins at triggers. The mean over the realisations is
  subtracted from angle and torque at every instant, so that movement and voluntary torque that are the same
  in all of them do not count (MacNeil, Kearney & Hunter 1992; Lortie & Kearney 2001). The short segments
  of all realisations around one instant are fitted together, each with its own level (Ludvig & Perreault
  2012). These authors estimate impulse responses; here the three parameters are estimated directly. Intervals
  come from a bootstrap over realisations.
- Schedule: all pieces of the record in which a scheduled quantity, such as the phase of gait or a target,
  lies in one bin are fitted together, each with its own level and trend; bootstrap over pieces.
"""

from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated

import numpy as np
import scipy

from tepsipe.errors import InputError
from tepsipe.identification.one_thread import one_thread
from tepsipe.signals.differentiation import derivative

NAMES = ("I", "B", "K", "reflex_gain_ratio")
# fewest realisations or pieces for a bootstrap over them
LEAST_PIECES = 8
# part of the motion that must differ between realisations: the rest is the same in all and is subtracted
LEAST_VARIATION = 0.02
# a window whose velocity has less than this part of the usual power was not perturbed
LEAST_POWER = 0.05
# a segment with fewer samples per parameter than this cannot be fitted
SAMPLES_PER_PARAMETER = 4
CHUNK = 50


@dataclass(frozen=True)
class MovedJoint:
    """Low-pass filtered record of a joint whose impedance changes."""

    angle: np.ndarray
    torque: np.ndarray
    """Angle (rad) and torque (N·m)."""
    rate_hz: float
    reflex_torque: Annotated[np.ndarray, "(n,)", "N·m"] | None = None
    """Torque of the reflex by a fit to the whole record."""

    def regressors(self) -> tuple[np.ndarray, tuple[str, ...]]:
        """Acceleration (rad/s²), velocity (rad/s), angle (rad) and a reflex torque (N·m), if it acts.

        Shape (n, 3 or 4), and the names of their parameters.
        """
        time = np.arange(self.angle.size) / self.rate_hz
        velocity = derivative(time, self.angle)
        columns = [derivative(time, velocity), velocity, self.angle - self.angle.mean()]
        if self.reflex_torque is not None and np.any(self.reflex_torque):
            columns.append(self.reflex_torque)
        return np.column_stack(columns), NAMES[: len(columns)]


@dataclass(frozen=True)
class VaryingImpedance:
    """Impedance at m places: instants of a record, instants after the trigger, or values of a schedule."""

    over: str
    """{"time", "time after the trigger", "schedule"}: Meaning of ``at``."""
    at: Annotated[np.ndarray, "(m,)"]
    """Centres of the segments (s, or unit of the schedule)."""
    names: tuple[str, ...]
    """I, B, K and, if a reflex torque was given, reflex_gain_ratio, the gain relative to that torque."""
    values: Annotated[np.ndarray, "(m, parameters)", "N·m·s²/rad"]
    standard_error: Annotated[np.ndarray, "(m, parameters)", "N·m·s/rad"]
    low: Annotated[np.ndarray, "(m, parameters)", "N·m/rad"]
    high: Annotated[np.ndarray, "(m, parameters)"]
    """Parameters, standard errors and ends of the 95 % intervals."""
    angle: Annotated[np.ndarray, "(m,)"]
    torque: Annotated[np.ndarray, "(m,)"]
    """Mean angle (rad) and torque (N·m): the operating point."""
    pieces: Annotated[np.ndarray, "(m,)"]
    """Number of realisations or pieces; 1 for windows."""
    vaf: Annotated[np.ndarray, "(m,)"]
    """VAF (%) of the torque of the segments about their levels, trends and ensemble mean."""


@one_thread()
def impedance_in_windows(
    joint: MovedJoint, *, window_s: float, step_s: float, block_s: float, draws: int, rng: np.random.Generator
) -> VaryingImpedance:
    """Impedance in sliding windows of a record with random perturbations.

    window_s, step_s: length of a window, and distance of windows.
    block_s: length of the blocks of residuals (s), longer than the residuals are correlated.
    Returns: parameters over time from the start of the record, without windows in which the joint was not
    perturbed.
    """
    angle, torque, rate_hz = joint.angle, joint.torque, joint.rate_hz
    columns, names = joint.regressors()
    window, step = round(window_s * rate_hz), max(1, round(step_s * rate_hz))
    starts = _perturbed(np.arange(0, angle.size - window + 1, step), window, columns[:, 1])
    block = max(1, round(block_s * rate_hz))
    _refuse_short(window, len(names) + 2, rate_hz, "windows")
    if starts.size < 2 or angle.size < 4 * block:
        raise InputError(
            f"expected at least two perturbed windows of {window_s:g} s and four blocks of {block_s:g} s, "
            f"found {starts.size} windows in {angle.size / rate_hz:.3g} s: shorten windows and blocks, or "
            "perturb longer"
        )
    nuisance = _level_and_trend(window)
    solvers, spans, values, vafs = [], [], [], []
    squared, times = np.zeros(angle.size), np.zeros(angle.size)
    sums = np.zeros(angle.size)
    for start in starts:
        part = slice(start, start + window)
        x, y = _without(nuisance, columns[part]), _without(nuisance, torque[part])
        solver = _solver(x, f"the window from {start / rate_hz:.3g} s")
        residual = y - x @ (solver @ y)
        sums[part] += residual
        times[part] += 1.0
        squared[part] += np.mean(residual**2)
        solvers.append(solver)
        spans.append(np.linalg.qr(np.hstack([x / np.linalg.norm(x, axis=0), nuisance]))[0])
        values.append(solver @ y)
        vafs.append(_vaf(y, residual))
    often = np.maximum(times, 1.0)
    level = np.sqrt(squared / often)
    unit = (sums / often)[times > 0.0] / level[times > 0.0]
    deviations = _block_deviations(solvers, spans, starts, unit, level, block, draws, rng)
    centre = (starts + 0.5 * (window - 1)) / rate_hz
    means = np.array([[s[start : start + window].mean() for start in starts] for s in (angle, torque)])
    return _result("time", centre, names, np.array(values), deviations, means, np.ones(starts.size), vafs)


@one_thread()
def impedance_of_ensemble(
    joint: MovedJoint,
    starts: Annotated[np.ndarray, "(r,)"],
    *,
    length_s: float,
    segment_s: float,
    step_s: float,
    draws: int,
    rng: np.random.Generator,
) -> VaryingImpedance:
    """Impedance during a movement that is repeated, with different perturbations every time.

    starts: samples at which the realisations begin.
    length_s, segment_s, step_s: length of a realisation, of a short segment, and distance of segments.
    Returns: parameters over time after the trigger.
    """
    angle, torque, rate_hz = joint.angle, joint.torque, joint.rate_hz
    columns, names = joint.regressors()
    length, segment = round(length_s * rate_hz), round(segment_s * rate_hz)
    starts = np.asarray(starts)
    starts = starts[(starts >= 0) & (starts + length <= angle.size)]
    if starts.size < LEAST_PIECES:
        raise InputError(
            f"expected at least {LEAST_PIECES} whole realisations of {length_s:g} s after the trigger, found "
            f"{starts.size}: shorten the realisations, or record more of them"
        )
    if segment > length:
        raise InputError(
            f"expected segments shorter than the realisations of {length_s:g} s, found {segment_s:g} s: "
            "shorten the segments"
        )
    at = starts[:, None] + np.arange(length)
    motion, load = columns[at], torque[at]
    deviation_of_motion = motion - motion.mean(axis=0)
    if np.mean(deviation_of_motion[..., 1] ** 2) < LEAST_VARIATION * np.mean(motion[..., 1] ** 2):
        raise InputError(
            "expected perturbations that differ between the realisations, found the same velocity in all of "
            "them: perturb each realisation at random"
        )
    firsts = np.arange(0, length - segment + 1, max(1, round(step_s * rate_hz)))
    deviation = load - load.mean(axis=0)
    nuisance = np.ones((segment, 1))
    _refuse_short(segment * starts.size, len(names) + starts.size, rate_hz, "segments")
    times = _multiplicities(starts.size, draws, rng)
    fits = []
    for first in firsts:
        part = slice(first, first + segment)
        pieces = [
            (_without(nuisance, x), _without(nuisance, y))
            for x, y in zip(deviation_of_motion[:, part], deviation[:, part], strict=True)
        ]
        place = f"the segment {first / rate_hz:.3g} s after the trigger"
        fits.append(_pooled(pieces, times, place, lost=1))
    values, deviations, vafs = zip(*fits, strict=True)
    centre = (firsts + 0.5 * (segment - 1)) / rate_hz
    mean = [s[at].mean(axis=0) for s in (angle, torque)]
    means = np.array([[m[first : first + segment].mean() for first in firsts] for m in mean])
    count = np.full(firsts.size, starts.size)
    return _result(
        "time after the trigger", centre, names, np.array(values), np.array(deviations), means, count, vafs
    )


@one_thread()
def impedance_by_schedule(
    joint: MovedJoint,
    schedule: np.ndarray,
    *,
    bins: int,
    piece_s: float,
    draws: int,
    rng: np.random.Generator,
) -> VaryingImpedance:
    """Impedance against a scheduled quantity that the record passes through several times.

    schedule: scheduled quantity, for example phase of gait or target.
    bins: number of equal bins between its smallest and largest value.
    piece_s: longest piece within a bin that has one level and one trend (s); pieces shorter than a quarter
    of it are left out.
    Returns: parameters over the schedule, for bins with enough pieces.
    """
    angle, torque, rate_hz = joint.angle, joint.torque, joint.rate_hz
    columns, names = joint.regressors()
    if not np.ptp(schedule) > 0.0:
        raise InputError(
            f"expected a schedule that changes, found {schedule[0]:g} throughout: name another column"
        )
    edges = np.linspace(schedule.min(), schedule.max(), bins + 1)
    place = np.clip(np.searchsorted(edges, schedule, side="right") - 1, 0, bins - 1)
    runs = _runs(place, round(piece_s * rate_hz), max(8, round(0.25 * piece_s * rate_hz)))
    centres, fits, means, count = [], [], [], []
    for b in range(bins):
        pieces_of_bin = [part for part in runs if place[part.start] == b]
        if len(pieces_of_bin) < LEAST_PIECES:
            continue
        inside = np.concatenate([np.arange(part.start, part.stop) for part in pieces_of_bin])
        pieces = []
        for part in pieces_of_bin:
            nuisance = _level_and_trend(part.stop - part.start)
            pieces.append((_without(nuisance, columns[part]), _without(nuisance, torque[part])))
        times = _multiplicities(len(pieces_of_bin), draws, rng)
        fits.append(_pooled(pieces, times, f"the schedule near {edges[b]:g}", lost=2))
        centres.append(schedule[inside].mean())
        means.append([angle[inside].mean(), torque[inside].mean()])
        count.append(len(pieces_of_bin))
    if not fits:
        raise InputError(
            f"expected at least {LEAST_PIECES} pieces of {0.25 * piece_s:g} s or longer in a bin of the "
            "schedule, found fewer in every bin: use fewer bins or shorter pieces, or record longer"
        )
    values, deviations, vafs = zip(*fits, strict=True)
    return _result(
        "schedule",
        np.array(centres),
        names,
        np.array(values),
        np.array(deviations),
        np.array(means).T,
        np.array(count),
        vafs,
    )


def _perturbed(starts: np.ndarray, window: int, velocity: np.ndarray) -> np.ndarray:
    """Starts of the windows in which the velocity has enough of its usual power (samples)."""
    power = np.array([np.mean(velocity[start : start + window] ** 2) for start in starts])
    return starts[power > LEAST_POWER * np.median(power)] if starts.size else starts


def _level_and_trend(size: int) -> np.ndarray:
    return np.column_stack([np.ones(size), np.linspace(-1.0, 1.0, size)])


def _without(nuisance: np.ndarray, x: np.ndarray) -> np.ndarray:
    """Residuals of the regression of ``x`` on the nuisance (unit of ``x``)."""
    return x - nuisance @ np.linalg.lstsq(nuisance, x, rcond=None)[0]


def _solver(x: np.ndarray, place: str) -> np.ndarray:
    """Matrix that maps a torque (N·m) to its parameters, shape (parameters, n)."""
    scale = np.linalg.norm(x, axis=0)
    if not (scale > 0.0).all() or np.linalg.cond(x / scale) > 1e8:
        raise InputError(
            f"expected a moving joint in {place}, found a motion that does not determine I, B, K: perturb "
            "throughout, or use longer segments"
        )
    return np.linalg.pinv(x / scale) / scale[:, None]


def _refuse_short(samples: int, parameters: int, rate_hz: float, what: str) -> None:
    if samples < SAMPLES_PER_PARAMETER * parameters:
        raise InputError(
            f"expected {what} of at least {SAMPLES_PER_PARAMETER * parameters / rate_hz:.3g} s, found "
            f"{samples / rate_hz:.3g} s: lengthen them"
        )


def _vaf(y: np.ndarray, residual: np.ndarray) -> float:
    return float(100.0 * (1.0 - np.sum(residual**2) / np.sum(y**2)))


def _block_deviations(solvers, spans, starts, unit, level, block, draws, rng) -> np.ndarray:
    """Errors of the parameters for residuals drawn in blocks, shape (windows, draws, parameters).

    ``unit`` holds the residuals of all windows over their RMS, ``level`` the RMS over time (N·m) and
    ``spans`` orthonormal bases of the regressors fitted in each window. Residuals of least squares are
    smaller than the errors, much smaller for slow torque in a short window. The errors are therefore enlarged
    by the share that a fit removes from drawn residuals.
    """
    block = min(block, unit.size)
    blocks = -(-level.size // block)
    window = solvers[0].shape[1]
    deviations = np.empty((len(starts), draws, solvers[0].shape[0]))
    taken, power = np.zeros((2, len(starts)))
    for first in range(0, draws, CHUNK):
        count = min(CHUNK, draws - first)
        begin = rng.integers(0, unit.size - block + 1, (count, blocks))
        drawn = unit[(begin[..., None] + np.arange(block)).reshape(count, -1)[:, : level.size]] * level
        for w, (solver, span, start) in enumerate(zip(solvers, spans, starts, strict=True)):
            part = drawn[:, start : start + window]
            deviations[w, first : first + count] = part @ solver.T
            taken[w] += np.sum((part @ span) ** 2)
            power[w] += np.sum(part**2)
    return deviations / np.sqrt(1.0 - taken / power)[:, None, None]


def _multiplicities(pieces: int, draws: int, rng: np.random.Generator) -> np.ndarray:
    """Number of times each piece is drawn, shape (draws, pieces)."""
    drawn = rng.integers(0, pieces, (draws, pieces))
    return np.array([np.bincount(draw, minlength=pieces) for draw in drawn], dtype=float)


def _pooled(pieces, times: np.ndarray, place: str, lost: int) -> tuple[np.ndarray, np.ndarray, float]:
    """Fit all pieces together: parameters, errors over drawn pieces (draws, parameters), VAF (%).

    ``lost`` is the number of levels and trends removed from each piece.
    """
    x, y = np.concatenate([p[0] for p in pieces]), np.concatenate([p[1] for p in pieces])
    value = _solver(x, place) @ y
    scale = np.linalg.norm(x, axis=0)
    normal = np.array([(a / scale).T @ (a / scale) for a, _ in pieces])
    right = np.array([(a / scale).T @ b for a, b in pieces])
    drawn = np.linalg.solve(np.tensordot(times, normal, 1), (times @ right)[..., None])[..., 0] / scale
    n = len(pieces)
    # few pieces: their spread is too small by sqrt(n / (n - 1)), and known from n - 1 of them
    growth = np.sqrt(n / (n - 1.0)) * scipy.special.stdtrit(n - 1, 0.975) / scipy.special.ndtri(0.975)
    return value, growth * (drawn - value), _vaf(y, y - x @ value)


def _runs(place: np.ndarray, longest: int, shortest: int) -> list[slice]:
    """Pieces of consecutive samples at one place, split into equal parts of at most ``longest`` samples."""
    ends = np.flatnonzero(np.diff(place)) + 1
    pieces = []
    for start, stop in pairwise([0, *ends, place.size]):
        parts = -(-(stop - start) // longest)
        cuts = np.linspace(start, stop, parts + 1).astype(int)
        pieces += [slice(a, b) for a, b in pairwise(cuts) if b - a >= shortest]
    return pieces


def _result(over, at, names, values, deviations, means, pieces, vafs) -> VaryingImpedance:
    low, high = np.percentile(deviations, [2.5, 97.5], axis=1)
    return VaryingImpedance(
        over=over,
        at=at,
        names=names,
        values=values,
        standard_error=deviations.std(axis=1),
        low=values + low,
        high=values + high,
        angle=means[0],
        torque=means[1],
        pieces=np.asarray(pieces, dtype=int),
        vaf=np.array(vafs),
    )
