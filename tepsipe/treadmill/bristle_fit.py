"""Fit of the frame with bristle friction to the mean pulses of the calibration trials.

Force and moment are fitted together, with a free zero per trial, because transducers drift and bristles hold
a force between the pulses. All combinations of the terms beyond the loaded frame are fitted, each from
several starts: the constants of the combinations with one term less, and the usual ones. The combination is
kept whose error of trials that are left out in turn is least, where every further term must bring a clear
gain: a treadmill without memory gets a model without bristles. A combination whose constants end at a bound
is kept only if all do. Where even the best leaves far more than noise, a response without physics is added
(`tepsipe.treadmill.remainder`), if it clearly reduces the left-out error.
"""

import itertools
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from tepsipe.errors import InputError
from tepsipe.treadmill.bristle_frame import AT, BristleFrame
from tepsipe.treadmill.bristle_search import (
    COMPONENTS,
    MOST,
    SCALE,
    SEARCHED,
    START,
    TERMS,
    Fit,
    Signals,
    centred,
    modelled_residuals,
    noise_weights,
    search,
)
from tepsipe.treadmill.pulse_windows import PulseWindows, pulse_windows
from tepsipe.treadmill.recording import BeltRecording
from tepsipe.treadmill.remainder import Remainder, fit_remainder

# smallest relative gain of the mean square error of left-out trials that another term must bring
GAIN = 0.1
# a response without physics is tried where the error of left-out trials exceeds this times the noise, and
# kept where it brings this relative gain of the mean square
UNEXPLAINED, REMAINDER_GAIN = 3.0, 0.5
# standard deviation of the constant `remainder_share`
SHARE_SD = 0.5
PLAIN = "loaded frame"  # the variant without further terms
REMAINDER = "remainder"  # the response without physics


@dataclass(frozen=True)
class Calibrated:
    """A fitted model with the draws of its errors.

    Attributes
    ----------
    models : dict of str to BristleFrame
        Component -> model.
    deviations : ndarray, shape (draws, 25)
        Draws of the errors of the constants.
    without_trial : ndarray, shape (trials, 25)
        Change of the constants if a trial is left out.
    left_out : dict of str to float
        Terms joined by ``+``, for every variant that was fitted -> root mean square error of left-out
        trials relative to the noise.
    without_remainder : tuple of dict of str to Remainder
        Component -> remainder of the model if a trial is left out; empty without remainder.
    """

    models: dict[str, BristleFrame]
    deviations: np.ndarray
    without_trial: np.ndarray
    left_out: dict[str, float]
    without_remainder: tuple[dict[str, Remainder], ...] = ()


def fit_bristle_frame(
    trials: list[dict[str, BeltRecording]],
    draws: int,
    rng: np.random.Generator,
    like: Calibrated | None = None,
) -> Calibrated:
    """Fit all trials together.

    Parameters
    ----------
    trials : list of dict of str to BeltRecording
        For each calibration trial component Fy or Mx -> recording (N, N·m), with two masses or more.
    draws : int
        Number of draws of the errors of the constants.
    rng : numpy.random.Generator
        Draws them.
    like : Calibrated, optional
        Fit of the same trials with another filter, whose terms are kept.

    Returns
    -------
    Calibrated
        Models of both components.

    Raises
    ------
    InputError
        If all trials carry the same mass, or their pulses cannot be used.
    """
    windows = pulse_windows(left_out_in_turn(trials))
    weights = noise_weights(windows)
    masses = sorted(set(windows.kg.tolist()))
    if len(masses) < 2:
        raise InputError(
            f"{windows.names[0]}: expected recordings with at least two different masses on the belt, "
            f"found only {masses[0]:g} kg: record the empty belt, a weight, and a weight near that of "
            "the subject, each with the subject's pulses"
        )
    if like is None:
        best, kept, scores = _chosen(windows, weights)
    else:
        known = like.models["Fy"]
        kept = tuple(term for term in known.terms if term != REMAINDER)
        best = search(Signals(windows), weights, kept, [known.constants[:SEARCHED]])
        scores = {"+".join(kept) or PLAIN: float(np.sqrt(best.left_out))}
    deviations = rng.standard_normal((draws, windows.kg.size)) @ best.spread
    found = _remainders(windows, weights, best) if np.sqrt(best.left_out) > UNEXPLAINED else None
    if found is not None:
        scores["+".join((*kept, REMAINDER))] = float(np.sqrt(found.left_out))
    rest: tuple[dict[str, Remainder], ...] = ()
    if found is not None and found.left_out < (1.0 - REMAINDER_GAIN) * best.left_out:
        rest = found.fits
        deviations[:, AT["remainder_share"]] = SHARE_SD * rng.standard_normal(draws)
    models = {
        component: BristleFrame(
            component,
            best.constants,
            (*kept, REMAINDER) if rest else kept,
            windows.rate_hz,
            float(masses[-1]),
            best.converged,
            rest[0][component] if rest else None,
        )
        for component in COMPONENTS
    }
    return Calibrated(models, deviations, best.without_trial, scores, rest[1:])


def left_out_in_turn(trials: list[dict[str, BeltRecording]]) -> list[dict[str, BeltRecording]]:
    """Trials that can be left out of a fit (N, N·m): the only one of a mass is split, pulse by pulse, in two.

    Parameters
    ----------
    trials : list of dict of str to BeltRecording
        For each trial component Fy or Mx -> recording (N, N·m).

    Returns
    -------
    list of dict of str to BeltRecording
        In the same order.
    """
    masses = [trial["Fy"].carried_kg for trial in trials]
    parts_of_trials = []
    for trial, kg in zip(trials, masses, strict=True):
        if masses.count(kg) > 1 or len(trial["Fy"].onsets) < 2:
            parts_of_trials.append(trial)
            continue
        for half in (0, 1):
            parts = {
                c: replace(r, name=f"{r.name}, half {half + 1}", onsets=r.onsets[half::2])
                for c, r in trial.items()
            }
            parts_of_trials.append(parts)
    return parts_of_trials


def _combinations() -> list[tuple[str, ...]]:
    """Every combination of the terms in which each has the term that it needs, small ones first."""
    found = [c for size in range(len(TERMS) + 1) for c in itertools.combinations(TERMS, size)]
    return [c for c in found if all(TERMS[term][1] in (None, *c) for term in c)]


def _chosen(
    windows: PulseWindows, weights: dict[str, float]
) -> tuple[Fit, tuple[str, ...], dict[str, float]]:
    """The best variant, its terms, and the left-out error of every variant."""
    fits: dict[tuple[str, ...], Fit] = {}
    signals = Signals(windows)
    for terms in _combinations():
        smaller = [fits[c] for c in fits if len(c) + 1 == len(terms) and set(c) < set(terms)]
        starts = [[START * SCALE], [fit.constants[:SEARCHED] for fit in smaller]]
        found = [search(signals, weights, terms, some) for some in starts if some]
        fits[terms] = min(found, key=lambda fit: (fit.at_bound, fit.left_out))
    inside = [c for c in fits if not fits[c].at_bound] or list(fits)
    terms = min(inside, key=lambda c: fits[c].left_out / (1.0 - GAIN) ** len(c))
    scores = {"+".join(c) or PLAIN: float(np.sqrt(fit.left_out)) for c, fit in fits.items()}
    return search(signals, weights, terms, [fits[terms].constants[:SEARCHED]], MOST), terms, scores


class _Remainders(NamedTuple):
    """Mean square error of left-out trials relative to the noise, and the remainders: component -> remainder,
    fitted to all trials and without each trial in turn.
    """

    left_out: float
    fits: tuple[dict[str, Remainder], ...]


def _remainders(windows: PulseWindows, weights: dict[str, float], best: Fit) -> _Remainders:
    """Remainders of a fit, and what they leave of trials that neither they nor the fit have seen."""
    every = np.ones(windows.kg.size, dtype=bool)
    signals = Signals(windows)
    residual = modelled_residuals(signals, best.constants)
    fits = [{c: fit_remainder(windows, residual[c], every) for c in COMPONENTS}]
    total = 0.0
    for k, change in enumerate(best.without_trial):
        residual = modelled_residuals(signals, best.constants + change)
        fits.append({c: fit_remainder(windows, residual[c], np.arange(every.size) != k) for c in COMPONENTS})
        for c in COMPONENTS:
            left = residual[c] - fits[-1][c].in_windows(windows)
            mine = np.zeros_like(left)
            mine[k] = left[k]
            total += float(np.sum((centred(windows, mine) / weights[c]) ** 2))
    return _Remainders(total / (len(COMPONENTS) * int(windows.evaluated.sum())), tuple(fits))
