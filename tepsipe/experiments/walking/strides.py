"""Strides of one leg between its heel strikes, and pulses in their stance.

A pulse belongs to the stride in which it starts. The phase of its onset is the time after the heel strike
divided by the mean duration of stance of the unperturbed strides, because the stance that a pulse disturbs
has no undisturbed duration of its own.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from tepsipe.errors import InputError
from tepsipe.experiments.walking.recording import CONTACT_N, WalkingRecording

SHORTEST_CONTACT_S = 0.15
MARGIN_S = 0.05  # of the stance at both ends, which does not count as stance
ODD_STANCE = 0.25  # largest difference from the median stance, relative


@dataclass(frozen=True)
class Strides:
    """Usable strides of one leg.

    Attributes
    ----------
    start : ndarray, shape (n,)
        Heel strikes (s).
    stance : ndarray, shape (n,)
        Time from heel strike to toe-off (s).
    end : ndarray, shape (n,)
        Next heel strikes of the same foot (s).
    dropped : tuple of str
        One sentence for every stride that is not among them.
    """

    start: np.ndarray
    stance: np.ndarray
    end: np.ndarray
    dropped: tuple[str, ...]

    def __len__(self) -> int:
        """Number of strides."""
        return len(self.start)

    def taken(self, which: np.ndarray) -> "Strides":
        """A selection of the strides."""
        return Strides(self.start[which], self.stance[which], self.end[which], self.dropped)

    def in_stance(self, time: np.ndarray) -> np.ndarray:
        """Test each instant (s) for the stance of a stride, away from its ends."""
        inside = np.zeros(time.size, dtype=bool)
        for start, stance in zip(self.start, self.stance, strict=True):
            inside |= (time > start + MARGIN_S) & (time < start + stance - MARGIN_S)
        return inside


@dataclass(frozen=True)
class Pulses:
    """Perturbed strides.

    Attributes
    ----------
    onset : ndarray, shape (p,)
        Onsets of the usable pulses (s).
    stride : ndarray of int, shape (p,)
        Index of the stride of each.
    dropped : tuple of str
        One sentence for every pulse that cannot be used.
    """

    onset: np.ndarray
    stride: np.ndarray
    dropped: tuple[str, ...]


def segment_strides(
    heel_strikes: Sequence[float],
    toe_offs: Sequence[float],
    *,
    name: str = "walking",
    from_s: float = 0.0,
) -> Strides:
    """Cut a trial into strides by the heel strikes of one foot.

    A stride is dropped, with a sentence, if it has no toe-off or several, or a stance that differs by more
    than a quarter from the median, which indicates a wrong event. Closer limits would select among
    the unperturbed strides and not among the perturbed ones, whose stance the pulse changes.

    Parameters
    ----------
    heel_strikes, toe_offs : sequence of float
        Events of one foot (s). NaN for a missing event.
    name : str
        Name of the trial, for messages.
    from_s : float
        Strides before this instant are left out, for example while the belt starts (s).

    Returns
    -------
    Strides
        Usable strides (s).

    Raises
    ------
    InputError
        If fewer than 3 heel strikes or no toe-off are given.
    """
    heel, toe = (np.sort(np.asarray(x, float)[np.isfinite(x)]) for x in (heel_strikes, toe_offs))
    heel = heel[heel >= from_s]
    if heel.size < 3 or not toe.size:
        raise InputError(
            f"{name}: expected heel strikes and toe-offs of the perturbed foot, found {heel.size} heel "
            f"strikes and {toe.size} toe-offs: detect the events first, for example from the vertical force"
        )
    median = np.median(np.diff(heel))
    kept, dropped = [], []
    for start, end in pairwise(heel):
        inside = toe[(toe > start) & (toe < end)]
        if inside.size != 1:
            dropped.append(
                f"{name}: expected one toe-off between the heel strikes at {start:.3f} and {end:.3f} s, "
                "found "
                f"{inside.size}: the stride is left out"
            )
        elif end - start > 1.5 * median:
            dropped.append(
                f"{name}: expected a heel strike about {median:.2f} s after that at {start:.3f} s, found the "
                f"next one after {end - start:.2f} s: the stride is left out"
            )
        else:
            kept.append((start, inside[0] - start, end))
    start, stance, end = np.array(kept).reshape(-1, 3).T
    odd = np.abs(stance - np.median(stance)) > ODD_STANCE * np.median(stance)
    dropped += [
        f"{name}: expected a stance of about {np.median(stance):.2f} s, found {stance[k]:.2f} s from the "
        "heel "
        f"strike at {start[k]:.3f} s: the stride is left out"
        for k in np.flatnonzero(odd)
    ]
    return Strides(start[~odd], stance[~odd], end[~odd], tuple(dropped))


def detect_events(recording: WalkingRecording) -> tuple[np.ndarray, np.ndarray]:
    """Heel strikes and toe-offs (s) by the vertical force: it rises above, and falls below, 30 N.

    A contact or a pause shorter than 0.15 s is ignored, for example if the foot scuffs the belt.
    """
    loaded = recording.vertical > CONTACT_N
    shortest = round(SHORTEST_CONTACT_S * recording.rate_hz)
    for state in (False, True):  # short pauses first, then short contacts
        edges = np.flatnonzero(np.diff(loaded.astype(int))) + 1
        for first, last in pairwise(edges):
            if last - first < shortest and loaded[first] == state:
                loaded[first:last] = not state
    change = np.diff(loaded.astype(int))
    return recording.time[np.flatnonzero(change > 0) + 1], recording.time[np.flatnonzero(change < 0) + 1]


def locate_pulses(
    strides: Strides, onsets: Sequence[float], window_s: float, name: str = "walking"
) -> Pulses:
    """Strides of pulses; those whose window meets a heel strike or no usable stride are left out.

    Parameters
    ----------
    strides : Strides
        Usable strides (s).
    onsets : sequence of float
        Onsets of pulses (s).
    window_s : float
        Length of the window after an onset (s).
    name : str
        Name of the trial, for messages.

    Returns
    -------
    Pulses
        Usable pulses (s), and a sentence for every other one.
    """
    kept, dropped = [], []
    for onset in np.asarray(onsets, float):
        index = int(np.searchsorted(strides.start, onset, side="right")) - 1
        if index < 0 or onset >= strides.end[index]:
            dropped.append(
                f"{name}: expected the pulse at {onset:.3f} s within a usable stride, found none: the "
                "pulse is left out"
            )
        elif onset + window_s > strides.end[index]:
            dropped.append(
                f"{name}: expected the window of the pulse at {onset:.3f} s to end before the next heel "
                "strike, "
                f"found one after {1e3 * (strides.end[index] - onset):.0f} ms: the pulse is left out"
            )
        else:
            kept.append((onset, index))
    located = np.array(kept).reshape(-1, 2)
    return Pulses(located[:, 0], located[:, 1].astype(int), tuple(dropped))


def random_onsets(strides: Strides, phases_percent: Sequence[float], rng: np.random.Generator) -> np.ndarray:
    """Onsets in half of the strides, chosen at random, in equal numbers at each phase (s).

    Parameters
    ----------
    strides : Strides
        Unperturbed strides (s).
    phases_percent : sequence of float
        Phases of stance (%).
    rng : numpy.random.Generator
        Chooses the strides.

    Returns
    -------
    ndarray
        Onsets in increasing order (s).
    """
    each = len(strides) // (2 * len(phases_percent))
    chosen = rng.permutation(len(strides))[: each * len(phases_percent)]
    phase = np.repeat(np.asarray(phases_percent, float), each) / 100.0
    return np.sort(strides.start[chosen] + phase * strides.stance.mean())


def refuse_swapped_belts(recording: WalkingRecording, strides: Strides) -> None:
    """Refuse a recording whose two belts carry each other's foot.

    In the swing of this foot its own belt must carry less than the other belt.

    Parameters
    ----------
    recording : WalkingRecording
        Forces of both belts (N).
    strides : Strides
        Strides of the recorded foot (s).

    Raises
    ------
    InputError
        If this foot's belt carries more than the other belt while the foot is in the air.
    """
    time = recording.time
    swing = np.zeros(time.size, dtype=bool)
    for start, stance, end in zip(strides.start, strides.stance, strides.end, strict=True):
        swing |= (time > start + stance + 0.05) & (time < end - 0.05)
    if not swing.any():
        return
    load, other_load = recording.vertical[swing].mean(), recording.other_vertical[swing].mean()
    if load > max(other_load, CONTACT_N):
        raise InputError(
            f"{recording.name}: expected the foot's own belt unloaded in its swing, found {load:.0f} N on "
            "it and "
            f"{other_load:.0f} N on the other: swap the belts, or the events of left and right"
        )
