"""Did the person stand still? Trials with steps, lifted feet or another support are refused as a whole."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
import scipy

from tepsipe.experiments.standing.options import OTHER_BELT, Person, StandingOptions
from tepsipe.signals.resampling import runs_of
from tepsipe.treadmill.prepared import PreparedTrial

# a marker bridges a gap: its position near the gap is not trusted either (s)
AROUND_GAP_S = 0.1
# a standing person presses on the belt between heel and toes, relative to the ankle (m)
HEEL_M, TOES_M = -0.06, 0.22
# largest distance of the centre of pressure from that of the posture; the trunk has no marker (m)
POSTURE_M = 0.04
# correlation of the centre of pressure with the lean, from which the moment is clearly reversed
REVERSED = -0.5
# largest change of the mean vertical force of unperturbed standing over a trial, as a fraction of the weight
WEIGHT_WITHIN, WEIGHT_PARTS = 0.1, 4
# a foot on the other belt takes this much of its load, or more, from the belt of the person
STEP_SHARE = 0.5
# a foot shifts if it moves within this time, because the logged velocity of the belt drifts (s)
SHIFT_WITHIN_S = 2.0


@dataclass(frozen=True)
class Stance:
    """Signals that show whether a person stands still."""

    positions: Annotated[np.ndarray, "(n, markers, 2)", "m"]
    """y, z of the filtered markers."""
    hidden: Annotated[np.ndarray, "(n, person's markers)"]
    """True where a marker was hidden: bridged positions are ignored."""
    shank: np.ndarray
    belt_velocity: np.ndarray
    f_z: np.ndarray
    """Angle of the shank (rad), belt (m/s) and vertical force on the feet's belt (N)."""


@dataclass(frozen=True)
class PlateBalance:
    """Signals that show whether the plate's moment balances the person."""

    pressure_m: np.ndarray
    """Centre of pressure, forward of the ankle."""
    shank: Annotated[np.ndarray, "(n,)", "rad"]
    thigh: Annotated[np.ndarray, "(n,)", "rad"]
    """Angles from the vertical."""


def pressure_fault(balance: PlateBalance, still: np.ndarray) -> str | None:
    """Reason why the plate cannot have measured a standing person.

    The centre of pressure lies outside the foot, or moves backward as the person leans forward.

    balance: centre of pressure and posture.
    still: samples of unperturbed standing.
    Returns: one sentence (cm), or None if the plate may be right.
    """
    pressure_m, shank = balance.pressure_m[still], balance.shank[still]
    mean_m = float(np.mean(pressure_m))
    if not HEEL_M <= mean_m <= TOES_M:
        return (
            f"the centre of pressure lies {100.0 * mean_m:.2g} cm forward of the ankle, outside the foot: "
            "check the origin of the force plate along the belt, and the sign and the unit of M_x"
        )
    together = float(np.corrcoef(pressure_m, shank)[0, 1]) if np.ptp(shank) and np.ptp(pressure_m) else 0.0
    if together < REVERSED:
        return (
            "the centre of pressure moves backward as the person leans forward (correlation "
            f"{together:.2f}): turn the sign of M_x in the calibration of the plate"
        )
    return None


def balance_flags(balance: PlateBalance, still: np.ndarray, person: Person) -> tuple[str, ...]:
    """``plate-origin`` where the centre of pressure is far from the body's centre of mass in quiet standing.

    balance: centre of pressure and posture.
    still: samples of unperturbed standing.
    person: height of the centre of mass of the body above the ankles.
    Returns: names, in `tepsipe.flags.FLAGS`.
    """
    lean = 0.5 * (np.mean(balance.shank[still]) + np.mean(balance.thigh[still]))
    expected_m = person.body.com_m * np.sin(lean)
    far = abs(float(np.mean(balance.pressure_m[still])) - expected_m) > POSTURE_M
    return ("plate-origin",) if far else ()


def stance_fault(prepared: PreparedTrial, stance: Stance, options: StandingOptions) -> str | None:
    """Reason why a trial is not quiet standing: a step, a stumble, or weight on another support.

    Returns: one sentence (times in s), or None if the person stood still.
    """
    return (
        _step(prepared, stance, options)
        or _other_support(prepared, stance.f_z, options)
        or _unloading(prepared, stance, options)
        or _other_weight(prepared, stance, options)
        or _lean(prepared, stance, options)
    )


def _step(prepared: PreparedTrial, stance: Stance, options: StandingOptions) -> str | None:
    time, rate, limits, person = prepared.time, prepared.rate_hz, options.limits, options.person
    travelled = scipy.interpolate.CubicSpline(time, stance.belt_velocity).antiderivative()(time)
    for label in person.foot.labels:
        y, z = stance.positions[:, prepared.markers.index(label)].T
        seen = _visible(stance.hidden[:, person.labels.index(label)], rate)
        slid = y - travelled
        shift = np.abs(slid - _median_before(slid, seen, round(SHIFT_WITHIN_S * rate)))
        lift = np.abs(z - np.median(z[seen])) if seen.any() else np.zeros(z.size)
        for what, amount, most in (
            ("moved on the belt", shift, limits.foot_shift_m),
            ("was lifted", lift, limits.foot_lift_m),
        ):
            beyond = np.flatnonzero(seen & (amount > most))
            if beyond.size:
                return (
                    f"the foot's marker {label!r} {what} by {100.0 * amount[seen].max():.2g} cm at "
                    f"{time[beyond[0]]:.1f} s, where standing allows {100.0 * most:g} cm: a step, repeat "
                    "the trial"
                )
    return None


def _other_support(prepared: PreparedTrial, f_z: np.ndarray, options: StandingOptions) -> str | None:
    # one foot on each belt: none is the other one
    other_belt, allowed = OTHER_BELT.get(options.belt), options.limits.other_belt
    belts = prepared.trial.axes["belt"].tolist()
    if other_belt not in belts:
        return None
    force = prepared.trial.values("force")[:, belts.index(other_belt), 2]
    aside = prepared.filtered(force.astype(float))
    beyond = np.abs(aside) > allowed * options.person.weight
    if not beyond.any():
        return None
    most, at = np.abs(aside).max() / options.person.weight, prepared.time[np.argmax(beyond)]
    found = (
        f"{most:.0%} of the weight was on the other belt at {at:.1f} s, where standing allows {allowed:.0%}"
    )
    carried = float(f_z[beyond].mean()) / options.person.weight
    shown = float(aside[beyond].mean()) / options.person.weight
    if shown < 0.0 or carried > 1.0 - STEP_SHARE * shown:
        return (
            f"{found}, while the belt of the person carried {carried:.0%} of it: no step, but cross-talk "
            "between the plates or a wrong zero, correct the calibration with a weight that rests on one belt"
        )
    return f"{found}: a step, repeat the trial"


def _unloading(prepared: PreparedTrial, stance: Stance, options: StandingOptions) -> str | None:
    f_z, rate, limits, weight = stance.f_z, prepared.rate_hz, options.limits, options.person.weight
    for start, stop in runs_of(f_z < (1.0 - limits.unloading) * weight):
        if stop - start > limits.unloading_s * rate:
            return (
                f"{1.0 - f_z[start:stop].min() / weight:.0%} of the weight left the plate at "
                f"{prepared.time[start]:.1f} s for {(stop - start) / rate:.2g} s, where standing allows "
                f"{limits.unloading:.0%}: a stumble into the harness, repeat the trial"
            )
    return None


def _other_weight(prepared: PreparedTrial, stance: Stance, options: StandingOptions) -> str | None:
    still = np.flatnonzero(prepared.at_rest)
    parts = [part for part in np.array_split(still, WEIGHT_PARTS) if part.size]
    masses = [float(stance.f_z[part].mean()) / options.person.body.gravity_m_per_s2 for part in parts]
    low, high = int(np.argmin(masses)), int(np.argmax(masses))
    if masses[high] - masses[low] <= WEIGHT_WITHIN * options.person.mass_kg:
        return None
    when = [prepared.time[parts[k][0]] for k in (low, high)]
    return (
        f"the plate carried {masses[low]:.3g} kg from {when[0]:.1f} s and {masses[high]:.3g} kg from "
        f"{when[1]:.1f} s, while the person stood still: check the range and the amplifier of the plate, and "
        "that the person held on to nothing"
    )


def _lean(prepared: PreparedTrial, stance: Stance, options: StandingOptions) -> str | None:
    lean, allowed = np.abs(stance.shank - np.median(stance.shank)), options.limits.lean_rad
    seen = _visible(stance.hidden.any(axis=1), prepared.rate_hz)
    beyond = np.flatnonzero(seen & (lean > allowed))
    if not beyond.size:
        return None
    return (
        f"the shank leaned {np.degrees(lean[seen].max()):.2g} degrees from upright at "
        f"{prepared.time[beyond[0]]:.1f} s, where standing allows {np.degrees(allowed):.2g}: a stumble, "
        "repeat the trial"
    )


def _visible(hidden: np.ndarray, rate_hz: float) -> np.ndarray:
    """False from shortly before to shortly after every run of hidden samples, shape (n,)."""
    seen, margin = ~hidden, round(AROUND_GAP_S * rate_hz)
    for start, stop in runs_of(hidden):
        seen[max(0, start - margin) : stop + margin] = False
    return seen


def _median_before(x: np.ndarray, seen: np.ndarray, samples: int) -> np.ndarray:
    """Median of the visible samples among the ``samples`` before each, shape (n,), about every 0.1 s.

    A centred median would follow a marker that moves to another place and stays there.
    """
    places = np.arange(0, x.size, max(1, samples // 20))
    medians = np.empty(places.size)
    # most stretches are whole and visible, and as long as each other
    visible_before = np.concatenate([[0], np.cumsum(seen)])
    start, stop = np.maximum(0, places - samples), places + 1
    whole = (stop - start == samples + 1) & (visible_before[stop] - visible_before[start] == samples + 1)
    if whole.any():
        stretches = np.lib.stride_tricks.sliding_window_view(x, samples + 1)
        medians[whole] = np.median(stretches[start[whole]], axis=1)
    for k in np.flatnonzero(~whole):
        part = slice(start[k], stop[k])
        medians[k] = np.median(x[part][seen[part]] if seen[part].any() else x[part])
    return np.interp(np.arange(x.size), places, medians)
