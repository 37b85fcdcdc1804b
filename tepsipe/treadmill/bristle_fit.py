"""Fit of the frame with bristle friction to the mean pulses of the calibration trials.

Force and moment are fitted together, with a free zero per trial, because transducers drift and bristles hold
a force between the pulses. All combinations of the terms beyond the loaded frame are fitted, each from
several starts: the constants of the combinations with one term less, and the usual ones. The combination is
kept whose error of trials that are left out in turn is least, where every further term must bring a clear
gain: a treadmill without memory gets a model without bristles. A combination whose constants end at a bound
is kept only if all do. Where even the best leaves far more than noise, a response without physics takes its
place (`tepsipe.treadmill.mass_response`), if it halves the left-out error.
"""

import itertools
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np

from tepsipe.errors import InputError
from tepsipe.treadmill.bristle_frame import AT, CONSTANTS, IDLE, BristleFrame
from tepsipe.treadmill.bristle_search import (
    BRIEF,
    COMPONENTS,
    MOST,
    SCALE,
    SEARCHED,
    START,
    TERMS,
    Fit,
    Signals,
    centred,
    noise_weights,
    search,
)
from tepsipe.treadmill.mass_response import MassResponse, fit_mass_response
from tepsipe.treadmill.pulse_windows import PulseWindows, by_direction, pulse_windows
from tepsipe.treadmill.recording import BeltRecording

# smallest relative gain of the mean square error of left-out trials that another term must bring
GAIN = 0.1
# a response without physics is tried where the error of left-out trials exceeds this times the noise, and
# kept where it brings this relative gain of the mean square
UNEXPLAINED, WITHOUT_GAIN = 3.0, 0.5
# standard deviation of the constant `response_share`
SHARE_SD = 0.5
PLAIN = "loaded frame"  # the variant without further terms
WITHOUT = "without-physics"  # a response of every mass


@dataclass(frozen=True)
class Calibrated:
    """A fitted model with the draws of its errors."""

    models: dict[str, BristleFrame]
    """Component -> model."""
    deviations: Annotated[np.ndarray, "(draws, 25)"]
    """Draws of the errors of the constants."""
    without_trial: Annotated[np.ndarray, "(trials, 25)"]
    """Change of the constants if a trial is left out."""
    left_out: dict[str, float]
    """Terms joined by ``+``, for every variant that was fitted -> root mean square error of left-out trials
    relative to the noise."""
    by_mass: tuple[dict[str, MassResponse], ...] = ()
    """Of a model without physics: component -> its response if a trial is left out, trial by trial."""


def fit_bristle_frame(
    trials: list[dict[str, BeltRecording]],
    draws: int,
    rng: np.random.Generator,
    like: Calibrated | None = None,
) -> Calibrated:
    """Fit all trials together.

    trials: for each calibration trial component Fy or Mx -> recording, with two masses or more.
    draws: number of draws of the errors of the constants.
    like: fit of the same trials with another filter, whose terms are kept.
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
    elif like.by_mass:
        best, kept, scores = None, (), {}
    else:
        known = like.models["Fy"]
        kept = known.terms
        best = search(Signals(windows), weights, kept, [known.constants[:SEARCHED]])
        scores = {"+".join(kept) or PLAIN: float(np.sqrt(best.left_out))}
    if best is None or np.sqrt(best.left_out) > UNEXPLAINED:
        left_out, responses = _without_physics(windows, weights)
        scores[WITHOUT] = float(np.sqrt(left_out))
        if best is None or left_out < (1.0 - WITHOUT_GAIN) * best.left_out:
            deviations = np.zeros((draws, len(CONSTANTS)))
            deviations[:, AT["response_share"]] = SHARE_SD * rng.standard_normal(draws)
            idle = IDLE._replace(response_share=0.0)
            models = {
                c: BristleFrame(
                    c, np.array(idle), (WITHOUT,), windows.rate_hz, float(masses[-1]), True, responses[0][c]
                )
                for c in COMPONENTS
            }
            without = np.zeros((windows.kg.size, len(CONSTANTS)))
            return Calibrated(models, deviations, without, scores, responses[1:])
    deviations = rng.standard_normal((draws, windows.kg.size)) @ best.spread
    models = {
        c: BristleFrame(c, best.constants, kept, windows.rate_hz, float(masses[-1]), best.converged)
        for c in COMPONENTS
    }
    return Calibrated(models, deviations, best.without_trial, scores)


def left_out_in_turn(trials: list[dict[str, BeltRecording]]) -> list[dict[str, BeltRecording]]:
    """Trials that can be left out of a fit (N, N·m).

    Pulses of opposite directions are trials of their own; the only one of a mass is split, pulse by pulse, in
    two.

    trials: for each trial component Fy or Mx -> recording.
    Returns: in the same order.
    """
    trials = by_direction(trials)
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
        usual, known = [START * SCALE], [fit.constants[:SEARCHED] for fit in smaller]
        found = [search(signals, weights, terms, known or usual)]
        other = search(signals, weights, terms, usual, BRIEF)
        if other.cost < found[0].cost:
            found.append(search(signals, weights, terms, [other.constants[:SEARCHED]]))
        fits[terms] = min(found, key=lambda fit: (fit.at_bound, fit.left_out))
    inside = [c for c in fits if not fits[c].at_bound] or list(fits)
    terms = min(inside, key=lambda c: fits[c].left_out / (1.0 - GAIN) ** len(c))
    scores = {"+".join(c) or PLAIN: float(np.sqrt(fit.left_out)) for c, fit in fits.items()}
    return search(signals, weights, terms, [fits[terms].constants[:SEARCHED]], MOST), terms, scores


def _without_physics(
    windows: PulseWindows, weights: dict[str, float]
) -> tuple[float, tuple[dict[str, MassResponse], ...]]:
    """Mean square error of left-out trials relative to the noise, and component -> response, fitted to all
    trials and without each trial in turn.
    """
    every = np.arange(windows.kg.size)
    fits = [
        {c: fit_mass_response(windows, windows.load[c], every != k) for c in COMPONENTS} for k in (-1, *every)
    ]
    total = 0.0
    for k, fit in enumerate(fits[1:]):
        for c, response in fit.items():
            left = (windows.load[c] - response.in_windows(windows)) * (every == k)[:, None]
            total += float(np.sum((centred(windows, left) / weights[c]) ** 2))
    return total / (len(COMPONENTS) * int(windows.evaluated.sum())), tuple(fits)
