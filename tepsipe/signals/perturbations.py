"""Detection of perturbations in the recorded belt motion, not in the command (thesis Figure 3-3)."""

from dataclasses import dataclass, replace
from typing import Annotated, Literal

import numpy as np

from tepsipe.arguments import checked, plausible_angle, refuse_constant, regular_rate, same_length, samples
from tepsipe.errors import InputError, quoted
from tepsipe.quantities import InnerFraction, Pause, Positive, Thesis, Time
from tepsipe.signals.array_types import Samples

# smallest peak of a perturbation (m/s): less may be one step of a quantised velocity
SMALLEST_PEAK_M_PER_S = 0.01
# a larger fraction of the peak is not a valid threshold for the start of a perturbation
LARGEST_FRACTION = 0.25
# a belt travels above this speed (m/s); its constant speed may drift
TRAVELLING_M_PER_S = 0.05
# its running median, over this time, at instants this far apart (s)
MEDIAN_OVER_S, MEDIAN_EVERY_S = 4.0, 0.5
# blocks whose largest deviation is compared (s), and this deviation in standard deviations of white noise
BLOCK_S, BLOCK_MAXIMUM_SD = 0.5, 3.0
# a joint is at rest that does not move for this time; the next perturbation already moves it this long before
# its start, because filters spread it (s)
STILL_S = 0.1


@dataclass(frozen=True)
class Perturbation:
    """Position of one perturbation in a trial.

    Attributes
    ----------
    start, stop : int
        First sample in which the belt moves, and first sample after it stops, or after the joint is at rest
        again (samples).
    peak_m_per_s : float
        Peak belt speed between them (m/s).
    until : {"stop", "rest"}
        What ends it: the belt stops, or the joint is at rest again.
    """

    start: int
    stop: int
    peak_m_per_s: float
    until: Literal["stop", "rest"] = "stop"


def detect_perturbations(
    velocity: Annotated[np.ndarray, "(n,)", "m/s"],
    rate_hz: float,
    rest_before_s: float,
    rest_after_s: float,
    threshold_fraction: float,
    signal_to_noise: float,
    merge_s: float,
    what: str,
) -> list[Perturbation]:
    """Detect perturbations as runs of belt speed above a threshold.

    The threshold is a fraction of the perturbations' own peak speed, so the window covers the same part of
    a pulse at every amplitude. Noise is measured while the belt is at rest, and over the whole trial; see
    `belt_noise`. The constant speed of a belt that travels, which may drift, is subtracted.

    rest_before_s, rest_after_s: unperturbed time at the trial's start and end.
    threshold_fraction: threshold as a fraction of the median peak speed.
    signal_to_noise: smallest ratio of the threshold to the noise at rest.
    merge_s: runs closer than this belong to one perturbation (s): the belt reverses between its lobes.
    what: names the trial in messages.
    """
    at_rest = velocity[: round(rest_before_s * rate_hz)]
    speed = np.abs(velocity - _constant_speed(velocity, at_rest, rate_hz))
    noise = belt_noise(speed, at_rest.size, rate_hz)
    runs = _runs(speed > max(signal_to_noise * noise, 0.25 * speed.max()), round(merge_s * rate_hz))
    peak = float(np.median([speed[a:b].max() for a, b in runs])) if runs else 0.0
    threshold = threshold_fraction * peak
    if peak < SMALLEST_PEAK_M_PER_S or threshold < signal_to_noise * noise:
        needed = np.ceil(100.0 * signal_to_noise * noise / peak) / 100.0 if peak > 0.0 else np.inf
        standing_out = peak >= SMALLEST_PEAK_M_PER_S and needed <= LARGEST_FRACTION
        standing_out &= any(start >= at_rest.size for start, _ in runs)  # not only a belt that gathers speed
        raise InputError(
            f"{what}: expected perturbations whose {100 * threshold_fraction:g} % exceed "
            f"{signal_to_noise:g} times the noise at rest ({1e3 * noise:.2g} mm/s), found "
            + (
                f"peaks of {1e3 * peak:.3g} mm/s: set threshold_fraction to at least {needed:g}"
                if standing_out
                else f"no perturbation above the noise (peak belt speed {1e3 * speed.max():.2g} mm/s): check "
                "that the belt was perturbed"
            )
        )
    perturbations = []
    for a, b in runs:
        if speed[a:b].max() < 0.5 * peak:
            continue
        start, stop = a, b
        margin = max(1, round(merge_s * rate_hz))
        while start > 0 and (speed[max(0, start - margin) : start] > threshold).any():
            start -= 1
        while stop < speed.size and (speed[stop : stop + margin] > threshold).any():
            stop += 1
        perturbations.append(Perturbation(int(start), int(stop), float(speed[start:stop].max())))
    last_rest = velocity.size - round(rest_after_s * rate_hz)
    for place, side, length_s, starts in (
        ("first", "before", rest_before_s, [p.start for p in perturbations if p.start < at_rest.size]),
        ("last", "after", rest_after_s, [p.start for p in perturbations if p.stop > last_rest]),
    ):
        if starts:
            raise InputError(
                f"{what}: expected the belt at rest during the {place} {length_s:g} s, found a "
                f"perturbation at {starts[0] / rate_hz:.3f} s: correct rest_{side}_s"
            )
    return perturbations


def belt_noise(
    speed: Annotated[np.ndarray, "(n,)", "m/s"], resting: int, rate_hz: float
) -> Annotated[float, "m/s"]:
    """Noise of a belt's speed as the standard deviation of normal noise: the largest of three estimates.

    The first is the median of the deviations at rest, which a perturbation during a wrongly configured rest
    does not affect. The second is the median, over blocks of the rest, of the largest deviation, which
    reveals the short dips of a belt that is walked on. The third, over the whole trial, reveals a rest
    that is quieter than what follows: the quantile below which half of the unperturbed samples lie if a
    fifth of all is perturbed.

    speed: deviation of the belt speed from its constant speed, never negative.
    """
    block = max(1, round(BLOCK_S * rate_hz))
    blocks = speed[: resting // block * block].reshape(-1, block)
    of_blocks = float(np.median(blocks.max(axis=1))) / BLOCK_MAXIMUM_SD if len(blocks) > 1 else 0.0
    at_rest, throughout = (
        1.4826 * float(np.quantile(part, q)) if part.size else 0.0
        for part, q in ((speed[:resting], 0.5), (speed, 0.4))
    )
    return max(at_rest, of_blocks, throughout)


def _constant_speed(velocity: np.ndarray, at_rest: np.ndarray, rate_hz: float) -> np.ndarray | float:
    """Speed from which perturbations deviate (m/s): the median at rest, a running one if the belt travels."""
    offset = float(np.median(at_rest))
    if abs(offset) < TRAVELLING_M_PER_S:
        return offset
    half, step = round(0.5 * MEDIAN_OVER_S * rate_hz), max(1, round(MEDIAN_EVERY_S * rate_hz))
    places = np.arange(0, velocity.size, step)
    medians = [np.median(velocity[max(0, k - half) : k + half + 1]) for k in places]
    return np.interp(np.arange(velocity.size), places, medians)


def _runs(active: np.ndarray, merge: int) -> list[tuple[int, int]]:
    """Start and stop of the runs of True, runs closer than ``merge`` samples joined."""
    edges = np.diff(np.concatenate([[0], active.astype(int), [0]]))
    starts, stops = np.flatnonzero(edges == 1), np.flatnonzero(edges == -1)
    runs: list[tuple[int, int]] = []
    for start, stop in zip(starts.tolist(), stops.tolist(), strict=True):
        if runs and start - runs[-1][1] < merge:
            runs[-1] = (runs[-1][0], stop)
        else:
            runs.append((start, stop))
    return runs


def extended_to_rest(
    rate: Annotated[np.ndarray, "(n,)", "rad/s"],
    rate_hz: float,
    perturbations: list[Perturbation],
    at_rest: Annotated[np.ndarray, "(n,)"],
    threshold_fraction: float = 0.05,
    signal_to_noise: float = 5.0,
) -> list[Perturbation]:
    """Windows that go on after the belt has stopped, until the joint is at rest again.

    The joint moves while |theta'| exceeds ``signal_to_noise`` times its noise at rest, and
    ``threshold_fraction`` of its peak after the belt has stopped (median over the perturbations). All windows
    have the median length, because a fit multiplies perturbations with each other, but none reaches the next
    perturbation.

    rate: theta', filtered.
    at_rest: samples at rest.
    """
    margin = round(STILL_S * rate_hz)
    speed = np.abs(rate - np.median(rate[at_rest]))
    noise = 1.4826 * float(np.median(speed[at_rest]))
    ends = [*(p.start for p in perturbations[1:]), max(perturbations[-1].stop, rate.size - margin)]
    after = [speed[p.stop : max(p.stop, end - margin)] for p, end in zip(perturbations, ends, strict=True)]
    peak = float(np.median([part.max(initial=0.0) for part in after]))
    threshold = max(signal_to_noise * noise, threshold_fraction * peak)
    lengths = []
    for p, end, part in zip(perturbations, ends, after, strict=True):
        moving = int(np.flatnonzero(part > threshold).max(initial=-1)) + 1
        lengths.append((p.stop + moving if moving + margin <= part.size else end) - p.start)
    length = int(np.median(lengths))
    return [
        replace(p, stop=max(p.stop, min(p.start + length, end)), until="rest")
        for p, end in zip(perturbations, ends, strict=True)
    ]


@dataclass(frozen=True)
class WindowOptions:
    """Options of the search for perturbations and rest."""

    rest_before_s: Annotated[Time, Thesis("2-1-2, 2-2")]
    """Unperturbed time at the start."""
    rest_after_s: Annotated[Time, Thesis("2-1-2 of the dummy")]
    """Unperturbed time at the end."""
    rest_margin_s: Pause
    """Part of it that is omitted, next to perturbations and ends."""
    threshold_fraction: InnerFraction
    """A perturbation begins and ends at this fraction of the median peak belt speed."""
    signal_to_noise: Positive
    """Smallest ratio of the threshold to the noise at rest."""
    merge_s: Time
    """Closer runs of belt motion are one perturbation."""


def rest_samples(time: np.ndarray, options: WindowOptions) -> np.ndarray:
    """True for the samples of the first and last rest, shape (n,), from instants in s."""
    margin = options.rest_margin_s
    first = (time >= time[0] + margin) & (time <= options.rest_before_s - margin)
    last = (time >= time[-1] - options.rest_after_s + margin) & (time <= time[-1] - margin)
    if not first.any() or not last.any():
        raise InputError(
            f"expected {options.rest_before_s:g} s of rest at the trial's start and "
            f"{options.rest_after_s:g} s at its end, found a trial of {time[-1] - time[0]:.3g} s: "
            "correct rest_before_s and rest_after_s"
        )
    return first | last


def unperturbed_samples(
    size: int,
    rate_hz: float,
    perturbations: list[Perturbation],
    margin_s: float,
    quiet_after_s: float,
    what: str,
) -> np.ndarray:
    """True for the samples far from any perturbation, shape (size,).

    size: length of the trial (samples).
    margin_s, quiet_after_s: time before a perturbation and after it that does not count.
    what: names the trial in messages.
    """
    unperturbed = np.ones(size, dtype=bool)
    before, after = round(margin_s * rate_hz), round(quiet_after_s * rate_hz)
    for p in perturbations:
        unperturbed[max(0, p.start - before) : p.stop + after] = False
    if unperturbed.sum() < rate_hz:
        raise InputError(
            f"{what}: expected at least 1 s of unperturbed standing, found {unperturbed.sum() / rate_hz:.2g} "
            "s: shorten quiet_after_s or perturb less often"
        )
    return unperturbed


def filtered_perturbations(
    belt_velocity: np.ndarray, rate_hz: float, options: WindowOptions, what: str
) -> list[Perturbation]:
    """Perturbations in the filtered belt velocity (m/s); see `detect_perturbations`, which also raises."""
    if options.rest_before_s <= options.rest_margin_s:
        raise InputError(
            f"{what}: expected rest_before_s above rest_margin_s ({options.rest_margin_s:g} s), which is "
            f"left out of it, found {options.rest_before_s:g} s: correct rest_before_s by the time of the "
            "first perturbation"
        )
    return detect_perturbations(
        belt_velocity,
        rate_hz,
        options.rest_before_s - options.rest_margin_s,
        options.rest_after_s - options.rest_margin_s,
        options.threshold_fraction,
        options.signal_to_noise,
        options.merge_s,
        what,
    )


def find_perturbations(
    time: "Samples",
    belt_velocity: "Samples",
    *,
    until: Literal["stop", "rest"] = "stop",
    angle: "Samples | None" = None,
    rest_before_s: float = 2.0,
    rest_after_s: float = 2.0,
    cutoff_hz: float = 20.0,
    order: int = 4,
    threshold_fraction: float = 0.05,
    signal_to_noise: float = 5.0,
    merge_s: float = 0.06,
) -> list[Perturbation]:
    """Perturbations of a trial, found in the recorded velocity of the belt.

    A perturbation begins and ends where the belt's speed passes ``threshold_fraction`` of the perturbations'
    peak speed (thesis Figure 3-3). See `detect_perturbations`.

    After the belt has stopped, a passive joint decays freely, which holds much of the information on K. With
    ``until="rest"``, a window ends when the joint is at rest again: the rate of the angle stays below
    ``signal_to_noise`` times its noise at rest, or below ``threshold_fraction`` of its peak after the belt
    has stopped. All windows have the median length, but none reaches the next perturbation
    (`extended_to_rest`). Keep the default for a joint with reflexes, voluntary torque or a stiffness that
    depends on the movement: these then act on the decay, too.

    Parameters
    ----------
    time : array_like or Signal, shape (n,)
        Instants (s), on a regular clock.
    belt_velocity : array_like or Signal, shape (n,)
        Velocity of the belt (m/s), not filtered.
    until : {"stop", "rest"}
        End of a window: the belt stops, or the joint is at rest again.
    angle : array_like or Signal, shape (n,), optional
        Angle of the joint (rad), not filtered; for ``until="rest"`` only, which needs it.
    rest_before_s, rest_after_s : float
        Unperturbed time at the trial's start and end (s).
    cutoff_hz : float
        Cutoff of the zero-lag Butterworth low-pass that velocity and angle pass first (Hz).
    order : int
        Its order, both passes together.
    threshold_fraction : float
        Threshold as a part of the perturbations' peak speed.
    signal_to_noise : float
        The threshold must exceed the noise at rest this many times.
    merge_s : float
        Runs closer than this are one perturbation (s).

    Returns
    -------
    list of Perturbation
        In order of time (samples, m/s).

    Raises
    ------
    InputError
        If the signals cannot be used, nothing exceeds the noise, the belt moves in the time of rest, or
        ``until`` and ``angle`` do not fit together.

    Examples
    --------
    >>> from tepsipe import find_perturbations, load_example
    >>> dummy = load_example("dummy")
    >>> pulses = find_perturbations(dummy.time, dummy.belt_velocity)
    >>> len(pulses)
    14
    >>> print(f"{pulses[0].start} to {pulses[0].stop}, {pulses[0].peak_m_per_s:.2f} m/s")
    686 to 718, 0.24 m/s
    >>> decays = find_perturbations(dummy.time, dummy.belt_velocity, until="rest", angle=dummy.angle)
    >>> print(f"{decays[0].start} to {decays[0].stop}")
    686 to 1465
    """
    from tepsipe.signals.differentiation import derivative
    from tepsipe.signals.filters import butterworth_lowpass

    if not isinstance(until, str) or until not in ("stop", "rest"):
        raise InputError(
            f"until: expected 'stop' or 'rest', found {quoted(until)}: say whether a window ends when the "
            "belt stops or when the joint is at rest again"
        )
    if (until == "rest") != (angle is not None):
        raise InputError(
            f"until, angle: expected an angle with until='rest' and only then, found until={quoted(until)} "
            f"{'without' if angle is None else 'with'} an angle: give both or neither"
        )
    time, rate_hz = regular_rate(time)
    velocity = samples(belt_velocity, "m/s", "belt_velocity")
    same_length(time, belt_velocity=velocity)
    rest_before_s, rest_after_s, cutoff_hz, order, threshold_fraction, signal_to_noise, merge_s = checked(
        rest_before_s=rest_before_s,
        rest_after_s=rest_after_s,
        cutoff_hz=cutoff_hz,
        order=order,
        threshold_fraction=threshold_fraction,
        signal_to_noise=signal_to_noise,
        merge_s=merge_s,
    )
    lasts_s = time.size / rate_hz
    if not rest_before_s + rest_after_s < lasts_s:
        raise InputError(
            f"rest_before_s, rest_after_s: expected less than the record of {lasts_s:.4g} s, found "
            f"{rest_before_s:g} s and {rest_after_s:g} s: shorten them"
        )
    fastest = float(np.abs(velocity - np.median(velocity)).max())
    if fastest > 20.0:
        raise InputError(
            f"belt_velocity: expected m/s, found changes of up to {fastest:.3g}, which looks like mm/s: give "
            'Signal(belt_velocity, "mm/s")'
        )
    found = detect_perturbations(
        butterworth_lowpass(velocity, rate_hz, cutoff_hz, order),
        rate_hz,
        rest_before_s,
        rest_after_s,
        threshold_fraction,
        signal_to_noise,
        merge_s,
        "belt_velocity",
    )
    if angle is None:
        return found
    angle = plausible_angle(samples(angle, "rad", "angle"))
    same_length(time, angle=angle)
    refuse_constant(angle=angle)
    rate = derivative(time, butterworth_lowpass(angle, rate_hz, cutoff_hz, order))
    at_rest = time - time[0] < rest_before_s
    return extended_to_rest(rate, rate_hz, found, at_rest, threshold_fraction, signal_to_noise)


def same_direction(pulses: Annotated[np.ndarray, "(pulses, n)", "m/s"]) -> Annotated[np.ndarray, "(pulses,)"]:
    """True for pulses that go the way of the first one, shape (pulses,).

    pulses: velocity of the belt in every pulse, from its onset.
    Returns: false for pulses that are like the first one with the opposite sign.
    """
    return pulses @ pulses[0] >= 0.0
