"""Strides of one leg between its heel strikes, and pulses in their stance.

A pulse belongs to the stride in which it starts. The phase of its onset is the time after the heel strike
divided by the mean duration of stance of the unperturbed strides, because the stance that a pulse disturbs
has no undisturbed duration of its own.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Annotated

import numpy as np

from tepsipe.errors import InputError
from tepsipe.experiments.walking.recording import CONTACT_N, WalkingRecording

SHORTEST_CONTACT_S = 0.15
MARGIN_S = 0.05  # of the stance at both ends, which does not count as stance
ODD_STANCE = 0.25  # largest difference from the median stance, relative


@dataclass(frozen=True)
class Strides:
    """Usable strides of one leg."""

    start: Annotated[np.ndarray, "(n,)", "s"]
    """Heel strikes."""
    stance: Annotated[np.ndarray, "(n,)", "s"]
    """Time from heel strike to toe-off."""
    end: Annotated[np.ndarray, "(n,)", "s"]
    """Next heel strikes of the same foot."""
    dropped: tuple[str, ...]
    """One sentence for every stride that is not among them."""

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
    """Perturbed strides."""

    onset: Annotated[np.ndarray, "(p,)", "s"]
    """Onsets of the usable pulses."""
    stride: Annotated[np.ndarray, "(p,)"]
    """Index of the stride of each."""
    dropped: tuple[str, ...]
    """One sentence for every pulse that cannot be used."""


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

    heel_strikes, toe_offs: events of one foot (s). NaN for a missing event.
    name: name of the trial, for messages.
    from_s: strides before this instant are left out, for example while the belt starts.
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

    onsets: onsets of pulses (s).
    window_s: length of the window after an onset.
    name: name of the trial, for messages.
    Returns: usable pulses, and a sentence for every other one.
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


def random_onsets(
    strides: Strides, phases_percent: Sequence[float], rng: np.random.Generator
) -> Annotated[np.ndarray, "s"]:
    """Onsets in half of the strides, chosen at random, in equal numbers at each phase (s).

    phases_percent: phases of stance.
    Returns: onsets in increasing order.
    """
    each = len(strides) // (2 * len(phases_percent))
    chosen = rng.permutation(len(strides))[: each * len(phases_percent)]
    phase = np.repeat(np.asarray(phases_percent, float), each) / 100.0
    return np.sort(strides.start[chosen] + phase * strides.stance.mean())


def refuse_swapped_belts(recording: WalkingRecording, strides: Strides) -> None:
    """Refuse a recording whose two belts carry each other's foot.

    In the swing of this foot its own belt must carry less than the other belt.

    strides: strides of the recorded foot.
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
