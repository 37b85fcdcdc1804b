"""Strides of one leg between its heel strikes, and pulses in their stance.

A pulse belongs to the stride in which it starts. The phase of its onset is the time after the heel strike
divided by the mean duration of stance of the unperturbed strides, because the stance that a pulse disturbs
has no undisturbed duration of its own.

Signals of one leg in a walking trial, on one regular clock, and its moment at the ankle.

The moment of the ankle follows from the force of the foot's own belt and the centre of pressure, at the
bandwidth of the force:

    M = F_y (x_cop - x_ankle) + F_x y_ankle

with x forward and y upward, positive in plantarflexion. Gravity and inertia of the foot are left to
`tepsipe.experiments.walking.impedance`, as a deviation of the moment that is known up to the foot's mass.
Moments from gait software are often low-passed at 6 Hz. This removes the pulse, and the scatter of the
strides with it, so the results look better than they are (`bandwidth_hz`).
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Annotated

import numpy as np
import scipy

from tepsipe.errors import InputError
from tepsipe.signals.filters import butterworth_lowpass

# of every recording
SIGNALS = ("angle", "vertical", "anterior", "cop", "ankle_x", "ankle_y", "other_vertical")
SEGMENT_S = 5.0  # length of the segments of a spectral estimate
COMPARED_HZ = 6.0  # cutoff of the moments that are compared
CONTACT_N = 30.0  # below this force the centre of pressure is not defined


@dataclass(frozen=True)
class WalkingRecording:
    """One leg in a walking trial."""

    name: str
    """Name of the trial, for messages."""
    rate_hz: float
    """Rate of the regular clock."""
    time: Annotated[np.ndarray, "(n,)", "s"]
    """The clock."""
    angle: Annotated[np.ndarray, "(n,)", "rad"]
    """Angle of the ankle, positive in plantarflexion."""
    vertical: Annotated[np.ndarray, "(n,)", "N"]
    anterior: Annotated[np.ndarray, "(n,)", "N"]
    """Force of the belt on this foot, upward and forward."""
    cop: Annotated[np.ndarray, "(n,)", "m"]
    """Centre of pressure below this foot, forward."""
    ankle_x: Annotated[np.ndarray, "(n,)", "m"]
    ankle_y: Annotated[np.ndarray, "(n,)", "m"]
    """Ankle joint, forward and above the belt."""
    other_vertical: Annotated[np.ndarray, "(n,)", "N"]
    """Force of the belt on the other foot, upward."""
    state: dict[str, np.ndarray] = field(default_factory=dict)
    """Further signals that may foretell a stride, for example the angle of the knee."""
    supplied_moment: Annotated[np.ndarray, "(n,)", "N·m"] | None = None
    """Moment of the ankle as supplied with the recording, positive in plantarflexion."""


def ankle_moment(recording: WalkingRecording) -> np.ndarray:
    """Moment of the ankle from force and centre of pressure, shape (n,), plantarflexion positive (N·m).

    It is not filtered. Without contact (below 30 N) it is zero.
    """
    contact = recording.vertical > CONTACT_N
    lever = recording.cop - recording.ankle_x
    moment = recording.vertical * lever + recording.anterior * recording.ankle_y
    return np.where(contact, moment, 0.0)


def bandwidth_hz(
    moment: Annotated[np.ndarray, "(n,)", "N·m"],
    reference: Annotated[np.ndarray, "(n,)", "N·m"],
    rate_hz: float,
) -> float:
    """Frequency at which a supplied moment has lost half of the power of the reference (Hz).

    The gain is the open-loop spectral estimate from the reference, |S_ry / S_rr|, averaged over three
    lines. Half the rate is returned where the gain stays above 1/sqrt(2).

    reference: moment of full bandwidth, for example `ankle_moment`.
    """
    length = round(SEGMENT_S * rate_hz)
    if moment.size < 4 * length:
        raise InputError(
            f"moment: expected at least {4 * SEGMENT_S:g} s to estimate its bandwidth, found "
            f"{moment.size / rate_hz:.3g} s: record longer"
        )
    frequency, cross = scipy.signal.csd(reference, moment, rate_hz, nperseg=length)
    _, power = scipy.signal.welch(reference, rate_hz, nperseg=length)
    weight = np.ones(3)
    gain = np.abs(np.convolve(cross, weight, "same")) / np.convolve(power, weight, "same")
    beyond = np.flatnonzero((gain < np.sqrt(0.5)) & (frequency > 1.0))
    return float(frequency[beyond[0]]) if beyond.size else 0.5 * rate_hz


def agreement(recording: WalkingRecording, stance: np.ndarray) -> float:
    """RMS difference in stance between the supplied moment and the moment from force and CoP (N·m).

    Both are low-passed alike. A large difference means that this side's moment cannot be reconstructed, for
    example because its centre of pressure or its ankle does not belong to the foot. Do not use it then.

    stance: samples that are compared.
    """
    if recording.supplied_moment is None:
        raise InputError(
            f"{recording.name}: expected a supplied moment of the ankle to compare with, found none: "
            "compare nothing"
        )
    both = np.stack([recording.supplied_moment, ankle_moment(recording)], axis=1)
    filtered = butterworth_lowpass(both, recording.rate_hz, COMPARED_HZ)
    return float(np.sqrt(np.mean(np.diff(filtered[stance], axis=1) ** 2)))


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
    heel_strikes: Sequence[float], toe_offs: Sequence[float], *, name: str = "walking", from_s: float = 0.0
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
