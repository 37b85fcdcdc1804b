"""When a trial is not one of standing: steps, lifted feet, other support."""

import numpy as np
import scipy

from tepsipe.experiments.standing.options import BELTS, StandingOptions
from tepsipe.io.trial import Trial
from tepsipe.signals.resampling import runs_of


def stance_fault(
    trial: Trial,
    options: StandingOptions,
    positions: np.ndarray,
    hidden: np.ndarray,
    shank: np.ndarray,
    belt_velocity: np.ndarray,
    f_z: np.ndarray,
) -> str | None:
    """Reason why a trial is not one of quiet standing: a step, a stumble, or weight on another support.

    Parameters
    ----------
    trial : Trial
        Forces of both belts (N).
    options : StandingOptions
        Person, belt and limits (units in their names).
    positions : ndarray, shape (n, markers, 2)
        y, z of the filtered markers (m).
    hidden : ndarray of bool, shape (n, person's markers)
        True where a marker was hidden (-): bridged positions are ignored.
    shank, belt_velocity, f_z : ndarray, shape (n,)
        Angle of the shank (rad), belt (m/s) and vertical force on the feet's belt (N).

    Returns
    -------
    str or None
        One sentence (times in s), or None if the person stood still.
    """
    time, rate, limits, person = trial.time, trial.rate_hz, options.limits, options.person
    labels = trial.axes["marker"].tolist()
    travelled = scipy.interpolate.CubicSpline(time, belt_velocity).antiderivative()(time)
    for label in person.foot.labels:
        y, z = positions[:, labels.index(label)].T
        seen = ~_widened(hidden[:, person.labels.index(label)], round(0.1 * rate))
        slid = y - travelled
        # the logged velocity of the belt drifts, and so does its integral: only a shift within 2 s counts
        shift = np.abs(slid - _median_before(slid, seen, round(2.0 * rate)))
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
    weight = person.mass_kg * person.body.gravity_m_per_s2
    other = (
        trial.axes["belt"].tolist().index(BELTS[options.belt])
        if BELTS[options.belt] in trial.axes["belt"]
        else None
    )
    if other is not None:
        aside = options.lowpass(trial.values("force")[:, other, 2].astype(float), rate)
        beyond = np.flatnonzero(np.abs(aside) > limits.other_belt * weight)
        if beyond.size:
            return (
                f"{np.abs(aside).max() / weight:.0%} of the weight was on the other belt at "
                f"{time[beyond[0]]:.1f} s, where standing allows {limits.other_belt:.0%}: a step, repeat "
                "the trial"
            )
    for start, stop in runs_of(f_z < (1.0 - limits.unloading) * weight):
        if stop - start > limits.unloading_s * rate:
            return (
                f"{1.0 - f_z[start:stop].min() / weight:.0%} of the weight left the plate at "
                f"{time[start]:.1f} s for {(stop - start) / rate:.2g} s, where standing allows "
                f"{limits.unloading:.0%}: a stumble into the harness, repeat the trial"
            )
    lean = np.abs(shank - np.median(shank))
    seen = ~_widened(hidden.any(axis=1), round(0.1 * rate))
    beyond = np.flatnonzero(seen & (lean > limits.lean_rad))
    if beyond.size:
        return (
            f"the shank leaned {np.degrees(lean[seen].max()):.2g} degrees from upright at "
            f"{time[beyond[0]]:.1f} s, where standing allows {np.degrees(limits.lean_rad):.2g}: a stumble, "
            "repeat the trial"
        )
    return None


def _widened(marked: np.ndarray, samples: int) -> np.ndarray:
    """Boolean array with every run of True extended by ``samples`` at both ends, shape (n,)."""
    wide = marked.copy()
    for start, stop in runs_of(marked):
        wide[max(0, start - samples) : stop + samples] = True
    return wide


def _median_before(x: np.ndarray, seen: np.ndarray, samples: int) -> np.ndarray:
    """Median of the visible samples among the ``samples`` before each, shape (n,), about every 0.1 s.

    A centred median would follow a marker that moves to another place and stays there (unit of ``x``).
    """
    places = np.arange(0, x.size, max(1, samples // 20))
    medians = np.empty(places.size)
    # most stretches are whole and visible, and as long as each other
    shown = np.concatenate([[0], np.cumsum(seen)])
    start, stop = np.maximum(0, places - samples), places + 1
    whole = (stop - start == samples + 1) & (shown[stop] - shown[start] == samples + 1)
    if whole.any():
        stretches = np.lib.stride_tricks.sliding_window_view(x, samples + 1)
        medians[whole] = np.median(stretches[start[whole]], axis=1)
    for k in np.flatnonzero(~whole):
        part = slice(start[k], stop[k])
        medians[k] = np.median(x[part][seen[part]] if seen[part].any() else x[part])
    return np.interp(np.arange(x.size), places, medians)
