"""Joint angles and ankle torque of a person standing on the treadmill (thesis section 3-2).

Symbols: y forward along the belt, z up; angles of segments from the vertical, positive when they tip
towards +y. The ankle angle is the angle of the shank minus that of the foot, the knee angle that of the thigh
minus that of the shank (extension positive). The trunk has no marker, so the hip angle is unknown. The torque
is that of both ankles.

Trials with steps, lifted feet or other support are refused.
"""

from dataclasses import dataclass

import numpy as np
import scipy

from tepsipe.errors import InputError, listed
from tepsipe.experiments.standing.options import BELTS, TORQUES, Person, StandingOptions, TorquePathway
from tepsipe.io.trial import Trial
from tepsipe.mechanics.inverse_dynamics import (
    PlateLoad,
    single_joint_torque,
    standing_torque,
    standing_torque_as_printed,
)
from tepsipe.mechanics.rigid_body_pose import fit_rigid_segment
from tepsipe.signals.differentiation import derivative
from tepsipe.signals.onsets import ramp_onset
from tepsipe.signals.perturbations import Perturbation, perturbations_of
from tepsipe.signals.resampling import runs_of
from tepsipe.signals.time_alignment import advanced, marker_delay
from tepsipe.treadmill.compensation import compensated_loads
from tepsipe.treadmill.registry import FittedModel, pick
from tepsipe.treadmill.trial_recordings import COMPONENTS, filtered_load, recordings_of_loads


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


@dataclass(frozen=True)
class StandingTrial:
    """Signals of a trial after the thesis's post-processing.

    Attributes
    ----------
    time : ndarray, shape (n,)
        Instants (s).
    onsets_s, ends_s : ndarray, shape (perturbations,)
        Instants at which the belt starts and stops moving (s).
    unperturbed : ndarray of bool, shape (n,)
        Samples far from any perturbation (-).
    belt_velocity, f_y, y_cop : ndarray, shape (n,)
        Belt (m/s), fore-aft force as measured (N), centre of pressure, eq (3-13) (m).
    ankle, ankle_d, ankle_dd : ndarray, shape (n,)
        Angle of the ankle (rad) and its derivatives (rad/s, rad/s²).
    shank, thigh, knee : ndarray, shape (n,)
        Angles (rad).
    stretch_velocity : dict of str to ndarray, shape (n,)
        Velocity of ankle and knee with the filter for stretches (rad/s).
    torque : dict of str to ndarray, shape (n,)
        Pathway -> torque of both ankles (N·m).
    labels : tuple of str
        Names of the markers.
    hidden : ndarray of bool, shape (n, markers)
        True where a marker was hidden (-).
    delay_s : float
        Delay of the markers relative to the belt, which is corrected (s).
    fault : str or None
        Reason for omitting the whole trial, one sentence; None if the person stood still.
    """

    time: np.ndarray
    onsets_s: np.ndarray
    ends_s: np.ndarray
    unperturbed: np.ndarray
    belt_velocity: np.ndarray
    f_y: np.ndarray
    y_cop: np.ndarray
    ankle: np.ndarray
    ankle_d: np.ndarray
    ankle_dd: np.ndarray
    shank: np.ndarray
    thigh: np.ndarray
    knee: np.ndarray
    stretch_velocity: dict[str, np.ndarray]
    torque: dict[str, np.ndarray]
    labels: tuple[str, ...]
    hidden: np.ndarray
    delay_s: float
    fault: str | None


def process_standing(
    trial: Trial,
    name: str,
    options: StandingOptions,
    pathways: dict[str, TorquePathway],
    models: dict[str, dict[str, FittedModel]],
) -> StandingTrial:
    """Post-process a trial: joint angles, centre of pressure (eq 3-13), ankle torque by every pathway.

    Parameters
    ----------
    trial : Trial
        Forces (N), moments (N·m), markers (m) and belt velocity (m/s).
    name : str
        Names the trial in messages.
    options : StandingOptions
        Choices (units in their names).
    pathways : dict of str to TorquePathway
        Name -> pathway.
    models : dict of str to dict of str to FittedModel
        Component of the load, Fy or Mx -> name -> treadmill model; may be empty if no pathway needs one.

    Returns
    -------
    StandingTrial
        Signals (rad, N·m, m, s), and whether the person stood still.

    Raises
    ------
    InputError
        If no perturbation is found, a marker, belt or model is missing, markers do not move as rigid
        segments, the weight on the plate is not that of the person, or a pathway is unknown.
    """
    time, rate, person = trial.time, trial.rate_hz, options.person
    moving = options.lowpass(trial.values("belt_velocity"), rate)
    perturbations = perturbations_of(moving, rate, options.window, name)
    unperturbed = _unperturbed(time, rate, perturbations, options, name)
    loads = filtered_load(trial, name, options.belt, options.lowpass)
    carried_kg = _carried_mass(loads["Fz"], unperturbed, options, name)
    labels = _labels(trial, person, name)
    positions = trial.values("marker_position")[:, :, 1:].astype(float)
    coarse = options.lowpass(positions, rate)
    belt = moving - np.median(moving[unperturbed])
    riding = coarse[:, [labels.index(label) for label in person.foot.labels], 0].mean(axis=1)
    hidden = trial.values("marker_hidden")[:, [labels.index(label) for label in person.labels]]
    _refuse_loose_segments(coarse[~hidden.any(axis=1)], labels, person, name)
    poses = segment_poses(coarse, labels, person)
    fine = segment_poses(options.stretch_lowpass(positions, rate), labels, person)
    fault = stance_fault(trial, options, coarse, hidden, poses["shank"], belt, loads["Fz"])
    # after a step the foot is not belt-fixed: report the step, not a delay of the markers
    try:
        delay = marker_delay(time, riding, belt, name)
    except InputError:
        if fault is None:
            raise
        delay = 0.0
    poses, fine = ({key: advanced(time, x, delay) for key, x in p.items()} for p in (poses, fine))
    ankle = poses["shank"] - poses["foot"]
    ankle_d = derivative(time, ankle)
    recordings = recordings_of_loads(
        trial,
        name,
        name,
        options.lowpass,
        unperturbed,
        {key: loads[key] - loads[key][unperturbed].mean() for key in COMPONENTS},
        dict.fromkeys(COMPONENTS, np.zeros(time.size)),
        carried_kg,
        np.ones(time.size, dtype=bool),
        tuple(p.start for p in perturbations),
    )
    torque = {}
    for key, pathway in pathways.items():
        used = {c: loads[c] for c in COMPONENTS}
        if pathway.treadmill_model is not None:
            chosen = {c: pick(models.get(c, {}), pathway.treadmill_model) for c in COMPONENTS}
            found = compensated_loads(chosen, recordings)
            used = {c: found[c] + loads[c][unperturbed].mean() for c in COMPONENTS}
        plate = PlateLoad(f_y=used["Fy"], f_z=loads["Fz"], m_x=used["Mx"])
        torque[key] = _torque(pathway.torque, person, plate, poses, time)
    return StandingTrial(
        time=time,
        onsets_s=np.array([_onset(trial, p.start, p.stop) for p in perturbations]),
        ends_s=np.array([time[min(p.stop, time.size - 1)] for p in perturbations]),
        unperturbed=unperturbed,
        belt_velocity=belt,
        f_y=loads["Fy"],
        y_cop=loads["Mx"] / loads["Fz"],
        ankle=ankle,
        ankle_d=ankle_d,
        ankle_dd=derivative(time, ankle_d),
        shank=poses["shank"],
        thigh=poses["thigh"],
        knee=poses["thigh"] - poses["shank"],
        stretch_velocity={
            "ankle": derivative(time, fine["shank"] - fine["foot"]),
            "knee": derivative(time, fine["thigh"] - fine["shank"]),
        },
        torque=torque,
        labels=person.labels,
        hidden=hidden,
        delay_s=delay,
        fault=fault,
    )


def _unperturbed(
    time: np.ndarray, rate_hz: float, perturbations: list[Perturbation], options: StandingOptions, name: str
) -> np.ndarray:
    """Samples far from any perturbation, shape (n,)."""
    unperturbed = np.ones(time.size, dtype=bool)
    margin = round(options.window.rest_margin_s * rate_hz)
    for p in perturbations:
        unperturbed[max(0, p.start - margin) : p.stop + round(options.quiet_after_s * rate_hz)] = False
    if unperturbed.sum() < rate_hz:
        raise InputError(
            f"{name}: expected at least 1 s of unperturbed standing, found {unperturbed.sum() / rate_hz:.2g} "
            "s: shorten quiet_after_s in the configuration or perturb less often"
        )
    return unperturbed


def _carried_mass(f_z: np.ndarray, unperturbed: np.ndarray, options: StandingOptions, name: str) -> float:
    """Mass on the belt (kg), which must be about that of the person."""
    person = options.person
    mass = float(f_z[unperturbed].mean()) / person.body.gravity_m_per_s2
    if abs(mass - person.mass_kg) > 0.15 * person.mass_kg:
        raise InputError(
            f"{name}: expected about {person.mass_kg:g} kg on the {options.belt} belt, found {mass:.3g} "
            "kg: correct "
            "standing.person.mass_kg, plate_treadmill.belt, or the calibration matrix"
        )
    return mass


def _labels(trial: Trial, person: Person, name: str) -> list[str]:
    """Names of the trial's markers, which must include those of the person."""
    labels = trial.axes["marker"].tolist()
    for label in person.labels:
        if label not in labels:
            raise InputError(
                f"{name}: expected a marker named {label!r}, found {listed(labels)}: "
                "correct standing.files.marker_labels and the markers of standing.person"
            )
    return labels


def _torque(
    kind: str, person: Person, plate: PlateLoad, poses: dict[str, np.ndarray], time: np.ndarray
) -> np.ndarray:
    """Torque of both ankles from one free body (N·m), shape (n,)."""

    def acceleration(key: str) -> np.ndarray:
        return derivative(time, derivative(time, poses[key]))

    feet = (person.feet, person.body.gravity_m_per_s2, plate, poses["ankle_point"], poses["foot_com"])
    if kind == "ankle":
        return standing_torque(*feet, acceleration("foot_com"), acceleration("foot"))
    if kind == "ankle-thesis":
        return standing_torque_as_printed(*feet, acceleration("foot_com"))
    if kind == "single-joint":
        shank_dd, ankle_dd = acceleration("shank"), acceleration("ankle_point")
        return single_joint_torque(person.body, poses["shank"], shank_dd, ankle_dd)
    raise InputError(
        f"expected a torque of {', '.join(TORQUES)}, found {kind!r}: correct torque in standing.pathways"
    )


def _refuse_loose_segments(positions: np.ndarray, labels: list[str], person: Person, name: str) -> None:
    """Raise InputError if a segment's markers, y and z (m) where all are seen, are not those of one body."""
    if not positions.size:
        return  # the markers are never all visible: every perturbation will be omitted
    for segment in ("foot", "shank", "thigh"):
        markers = getattr(person, segment)
        columns = [labels.index(label) for label in markers.labels]
        pose = fit_rigid_segment(positions[:, columns], markers.layout_m, np.zeros(2))
        if pose.marker_residual_rms_m > 0.01:
            raise InputError(
                f"{name}: expected the markers of the {segment} to move as one rigid body, found them "
                f"{1e3 * pose.marker_residual_rms_m:.3g} mm from it on average: check their layout in the "
                "configuration"
            )


def segment_poses(
    positions: np.ndarray, labels: list[str], person: Person, centre_m: np.ndarray | None = None
) -> dict[str, np.ndarray]:
    """Angles of foot, shank and thigh (rad), and positions of the ankle and of the feet's mass (m).

    Parameters
    ----------
    positions : ndarray, shape (n, markers, 2)
        y, z (m).
    labels : list of str
        Names of the markers.
    person : Person
        Layout of the markers (m).
    centre_m : ndarray, shape (2,), optional
        Of the joint's centre from the assumed one, anterior and longitudinal in the shank (m).

    Returns
    -------
    dict of str to ndarray
        ``foot``, ``shank``, ``thigh``, shape (n,) (rad); ``ankle_point``, ``foot_com``, shape (n, 2) (m).
    """
    points = {
        "foot": (person.foot, np.array([person.foot_com_m, -0.5 * person.ankle_height_m])),
        "shank": (person.shank, np.zeros(2) if centre_m is None else centre_m),
        "thigh": (person.thigh, np.zeros(2)),
    }
    fitted = {}
    for segment, (markers, point) in points.items():
        columns = [labels.index(label) for label in markers.labels]
        fitted[segment] = fit_rigid_segment(positions[:, columns], markers.layout_m, point)
    return {
        **{segment: pose.angle for segment, pose in fitted.items()},
        "ankle_point": fitted["shank"].point,
        "foot_com": fitted["foot"].point,
    }


def _onset(trial: Trial, start: int, stop: int) -> float:
    """Instant at which the belt starts to move (s), to a fraction of a sample."""
    rate = trial.rate_hz
    # the first quarter of the perturbation contains its first rise
    before, after = round(0.2 * rate), max(3, (stop - start) // 4)
    window = slice(max(0, start - before), start + after)
    time, velocity = trial.time[window], trial.values("belt_velocity")[window]
    sign = np.sign(velocity[-1] - np.median(velocity))
    # the detected start precedes the motion by up to the width of the filter
    return float(ramp_onset(time, sign * velocity, trial.time[max(0, start - round(0.02 * rate))]))
