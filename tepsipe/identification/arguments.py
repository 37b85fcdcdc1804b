"""Arguments of the public fits: windows, rest, and the bootstrap; refusal of what determines no joint."""

from collections.abc import Sequence

import numpy as np

from tepsipe.errors import InputError, quoted
from tepsipe.signals.perturbations import Perturbation

LEAST_REST_S = 0.25
REST_MARGIN_S = 0.1  # margin before the first perturbation


def as_perturbations(perturbations: Sequence, count: int) -> list[Perturbation]:
    """Perturbations, given as such or as pairs (start, stop), in order of time (samples).

    Parameters
    ----------
    perturbations : sequence of Perturbation or of (int, int)
        First sample and the first after the window (samples).
    count : int
        Length of the record (samples).

    Returns
    -------
    list of Perturbation
        In order of time (samples).

    Raises
    ------
    InputError
        If there is none, or one exceeds the record or is shorter than 4 samples.
    """
    windows = []
    for pulse in perturbations:
        if isinstance(pulse, Perturbation):
            windows.append(pulse)
            continue
        try:
            start, stop = (int(sample) for sample in pulse)
        except (TypeError, ValueError) as error:
            raise InputError(
                f"perturbations: expected pairs of first sample and the first after it, found "
                f"{quoted(pulse)}: give the result of tepsipe.find_perturbations"
            ) from error
        windows.append(Perturbation(start, stop, float("nan")))
    if not windows:
        raise InputError("perturbations: expected at least one, found none: check find_perturbations")
    for window in windows:
        if not 0 <= window.start <= window.stop - 4 <= count - 4:
            raise InputError(
                f"perturbations: expected windows of 4 samples or more within the record's {count}, found "
                f"{window.start} to {window.stop}: give samples, not seconds"
            )
    return sorted(windows, key=lambda window: window.start)


def samples_at_rest(time: np.ndarray, windows: list[Perturbation], rest) -> np.ndarray:
    """Samples at rest.

    Parameters
    ----------
    time : ndarray, shape (n,)
        Instants (s).
    windows : list of Perturbation
        Perturbations (samples).
    rest : ndarray of bool, shape (n,), (float, float) or None
        The samples, or unperturbed time at the trial's start and end (s), or None for the time before the
        first perturbation.

    Returns
    -------
    ndarray of bool, shape (n,)
        Samples at rest.

    Raises
    ------
    InputError
        If a perturbation lies in the rest, or the rest is shorter than 0.25 s.
    """
    if rest is None:
        at_rest = time < time[windows[0].start] - REST_MARGIN_S
    elif np.shape(rest) == (2,) and np.asarray(rest).dtype != bool:
        before, after = (float(part) for part in rest)
        at_rest = (time < time[0] + before) | (time > time[-1] - after)
    else:
        at_rest = np.asarray(rest)
        if at_rest.dtype != bool or at_rest.shape != time.shape:
            raise InputError(
                f"rest: expected {time.size} booleans or two times in s, found {at_rest.dtype} of shape "
                f"{at_rest.shape}: give rest=(before_s, after_s)"
            )
    advice = "say with rest=(before_s, after_s) when the joint rests"
    if any(at_rest[w.start : w.stop].any() for w in windows):
        raise InputError(f"rest: expected the joint at rest, found a perturbation in it: {advice}")
    lasts_s = float(at_rest.sum() * (time[1] - time[0]))
    if lasts_s < LEAST_REST_S:
        raise InputError(f"rest: expected at least {LEAST_REST_S:g} s, found {lasts_s:.3g} s: {advice}")
    return at_rest


def shaded(time: np.ndarray, windows: list[Perturbation]) -> np.ndarray:
    """First and last instant of every window (s), shape (windows, 2)."""
    return np.array([[time[w.start], time[w.stop - 1]] for w in windows])


def bootstrap_generator(draws: int, confidence: float, seed: int) -> np.random.Generator:
    """Generator of a bootstrap of ``draws``, for intervals of a ``confidence``.

    Raises
    ------
    InputError
        If there are fewer than 100 draws, or the confidence is no probability.
    """
    check_probability(confidence)
    if draws < 100:
        raise InputError(f"bootstrap_draws: expected at least 100, found {draws}: draw more")
    return np.random.default_rng(seed)


def check_probability(confidence: float) -> None:
    """Refuse a confidence outside (0, 1).

    Raises
    ------
    InputError
        If it is below 0.5, or 1 or more.
    """
    if not 0.5 <= confidence < 1.0:
        raise InputError(
            f"confidence: expected a probability from 0.5 to below 1, found {confidence:g}: give 0.95 for "
            "95 %"
        )
