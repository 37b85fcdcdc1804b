"""Arguments of the public fits: windows, rest, and the bootstrap; refusal of what determines no joint."""

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Annotated

import numpy as np

from tepsipe.arguments import Range, checked, described, number, pair, several
from tepsipe.errors import InputError
from tepsipe.signals.perturbations import Perturbation

LEAST_REST_S = 0.25
REST_MARGIN_S = 0.1  # margin before the first perturbation


def as_perturbations(perturbations: Sequence, count: int) -> list[Perturbation]:
    """Perturbations, given as such or as pairs (start, stop), in order of time (samples).

    perturbations: first sample and the first after the window (samples).
    count: length of the record (samples).
    """
    given = several(perturbations)
    if given is None:
        raise InputError(
            f"perturbations: expected a list of windows, found {described(perturbations)}: give the result "
            "of tepsipe.find_perturbations"
        )
    windows = [_window(each) for each in given]
    if not windows:
        raise InputError("perturbations: expected at least one, found none: check find_perturbations")
    for window in windows:
        if not 0 <= window.start <= window.stop - 4 <= count - 4:
            raise InputError(
                f"perturbations: expected windows of 4 samples or more within the record's {count}, found "
                f"{window.start} to {window.stop}: give samples, not seconds"
            )
    windows.sort(key=lambda window: (window.start, window.stop))
    for earlier, later in pairwise(windows):
        if later.start < earlier.stop:
            what = (
                "the same window twice"
                if (later.start, later.stop) == (earlier.start, earlier.stop)
                else "windows that overlap"
            )
            raise InputError(
                f"perturbations: expected windows apart from each other, found {what}, {earlier.start} to "
                f"{earlier.stop} and {later.start} to {later.stop}: give each perturbation once, because "
                "intervals count every window as independent"
            )
    return windows


def _window(given: object) -> Perturbation:
    """One window as a `Perturbation` of whole samples."""
    known = isinstance(given, Perturbation)
    try:
        start, stop = (given.start, given.stop) if known else given
        ends = [number(end, "perturbations", Range(-math.inf, whole=True)) for end in (start, stop)]
    except (TypeError, ValueError) as error:
        raise InputError(
            f"perturbations: expected pairs of first sample and the first after it, found "
            f"{described(given)}: give samples, not seconds, such as the result of tepsipe.find_perturbations"
        ) from error
    return replace(given, start=ends[0], stop=ends[1]) if known else Perturbation(*ends, math.nan)


def samples_at_rest(
    time: Annotated[np.ndarray, "(n,)", "s"], windows: list[Perturbation], rest
) -> np.ndarray:
    """Samples at rest.

    rest: the samples, or unperturbed time at the trial's start and end (s), or None for the time before the
    first perturbation. Shape (n,).
    """
    if rest is None:
        at_rest = time < time[windows[0].start] - REST_MARGIN_S
    elif isinstance(rest, tuple | list | np.ndarray) and np.shape(rest)[:1] == (2,):
        before, after = pair(rest, "rest")
        at_rest = (time < time[0] + before) | (time > time[-1] - after)
    else:
        usable = hasattr(rest, "dtype") and not (np.ma.isMaskedArray(rest) and np.ma.getmaskarray(rest).any())
        at_rest = np.asarray(rest) if usable else np.empty(0)
        if at_rest.dtype != bool or at_rest.shape != time.shape:
            raise InputError(
                f"rest: expected an array of {time.size} booleans or two times in s, found "
                f"{described(rest)}: give rest=(before_s, after_s)"
            )
    advice = "say with rest=(before_s, after_s) when the joint rests"
    if any(at_rest[w.start : w.stop].any() for w in windows):
        raise InputError(f"rest: expected the joint at rest, found a perturbation in it: {advice}")
    lasts_s = float(at_rest.sum() * (time[1] - time[0]))
    if lasts_s < LEAST_REST_S:
        raise InputError(f"rest: expected at least {LEAST_REST_S:g} s, found {lasts_s:.3g} s: {advice}")
    return at_rest


def refuse_still(angle: np.ndarray, windows: list[Perturbation]) -> None:
    """Refuse windows in which the angle (rad) does not move, shape (n,)."""
    least = 1e-6 * float(np.ptp(angle))
    for w in windows:
        if np.ptp(angle[w.start : w.stop]) < least:
            raise InputError(
                f"perturbations: expected movement in every window, found none from {w.start} to {w.stop}: "
                "leave it out"
            )


def shaded(time: np.ndarray, windows: list[Perturbation]) -> np.ndarray:
    """First and last instant of every window (s), shape (windows, 2)."""
    return np.array([[time[w.start], time[w.stop - 1]] for w in windows])


def bootstrap_generator(draws: int, confidence: float, seed: int) -> np.random.Generator:
    """Generator of a bootstrap of ``draws``, for intervals of a ``confidence``."""
    _, _, seed = checked(confidence=confidence, bootstrap_draws=draws, seed=seed)
    return np.random.default_rng(seed)
