"""Joint angles and ankle torque of a person standing on the treadmill (thesis section 3-2).

Symbols: y forward along the belt, z up; angles of segments from the vertical, positive when they tip
towards +y. The ankle angle is the angle of the shank minus the angle of the foot; the knee angle is the angle
of the thigh minus the angle of the shank (extension positive). The trunk has no marker, so the hip angle is
unknown. The torque is the sum of both ankles.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Annotated

import numpy as np

from tepsipe.errors import InputError, listed
from tepsipe.experiments.standing.options import (
    AS_PRINTED,
    BOTH,
    TORQUES,
    VECTORS,
    Person,
    StandingOptions,
    TorquePathway,
)
from tepsipe.experiments.standing.stance import (
    PlateBalance,
    Stance,
    balance_flags,
    pressure_fault,
    stance_fault,
)
from tepsipe.io.trial import Trial, recorded_faults
from tepsipe.mechanics.inverse_dynamics import (
    PlateLoad,
    single_joint_torque,
    standing_torque,
    standing_torque_as_printed,
)
from tepsipe.mechanics.segment_kinematics import fit_rigid_segment, refuse_loose
from tepsipe.signals.differentiation import degree_at, derivative
from tepsipe.signals.onsets import ramp_onset
from tepsipe.signals.sample_faults import noise_floors
from tepsipe.signals.time_alignment import advanced, marker_delay
from tepsipe.treadmill.compensation import compensated_loads
from tepsipe.treadmill.plate_check import PlateCheck, calibration_fault, calibration_of
from tepsipe.treadmill.prepared import PreparedTrial, prepare_trial
from tepsipe.treadmill.recording import BeltRecording
from tepsipe.treadmill.registry import FittedModel, pick
from tepsipe.treadmill.trial_recordings import COMPONENTS, recordings_of_loads

# largest difference of the mass on the belt from the person's, as a fraction of it
MASS_WITHIN = 0.15


@dataclass(frozen=True)
class StandingTrial:
    """Signals of a trial after the thesis's post-processing."""

    prepared: PreparedTrial
    """The trial as ingested, with its perturbations; at rest where it is far from any of them."""
    onsets_s: Annotated[np.ndarray, "(perturbations,)"]
    ends_s: Annotated[np.ndarray, "(perturbations,)"]
    """Instants at which the belt starts and stops moving."""
    belt_velocity: np.ndarray
    f_y: np.ndarray
    y_cop: np.ndarray
    """Belt (m/s), fore-aft force as measured (N), centre of pressure, eq (3-13) (m)."""
    ankle: np.ndarray
    ankle_d: np.ndarray
    ankle_dd: np.ndarray
    """Angle of the ankle (rad) and its derivatives (rad/s, rad/s²)."""
    shank: Annotated[np.ndarray, "(n,)", "rad"]
    thigh: Annotated[np.ndarray, "(n,)", "rad"]
    knee: Annotated[np.ndarray, "(n,)", "rad"]
    """Angles."""
    stretch_velocity: dict[str, np.ndarray]
    """Velocity of ankle and knee with the filter for stretches (rad/s)."""
    torque: dict[str, np.ndarray]
    """Pathway -> torque of both ankles (N·m)."""
    labels: tuple[str, ...]
    hidden: Annotated[np.ndarray, "(n, markers)"]
    """True where a marker was hidden."""
    delay_s: float
    """Delay of the markers relative to the belt, which is corrected."""
    fault: str | None
    """Reason for omitting the whole trial, one sentence; None if the person stood still."""
    plate: PlateCheck = field(default_factory=PlateCheck)
    """Origin and scale of the force plate, which are corrected."""
    plate_flags: tuple[str, ...] = ()
    """Names of faults of the plate, in `tepsipe.flags.FLAGS`."""

    @property
    def trial(self) -> Trial:
        """The trial as ingested, with the units of its signals."""
        return self.prepared.trial

    @property
    def time(self) -> np.ndarray:
        """Instants (s), shape (n,)."""
        return self.prepared.time

    @property
    def unperturbed(self) -> np.ndarray:
        """True for the samples far from any perturbation, shape (n,)."""
        return self.prepared.at_rest


def process_standing(
    trial: Trial,
    name: str,
    options: StandingOptions,
    pathways: dict[str, TorquePathway],
    models: dict[str, dict[str, FittedModel]],
    plate: PlateCheck | None = None,
) -> StandingTrial:
    """Post-process a trial: joint angles, centre of pressure (eq 3-13), ankle torque by every pathway.

    trial: forces, moments, markers and belt velocity.
    name: names the trial in messages.
    pathways: name -> pathway.
    models: component of the load, Fy or Mx -> name -> treadmill model; may be empty if no pathway needs
    one. For a person with a foot on each belt: belt -> the same.
    plate: origin and scale of the force plate, to be corrected; of two plates that were corrected before,
    `PlateCheck.of_several`.
    Returns: signals, and whether the person stood still.
    """
    plate = plate or PlateCheck()
    differs = calibration_fault(plate.calibration, calibration_of(trial, options.belt))
    trial = plate.corrected(trial, options.belt)
    prepared = prepare_trial(trial, name, options.lowpass, options.window, options.quiet_after_s)
    time, still, person = prepared.time, prepared.at_rest, options.person
    belt = prepared.belt_velocity - np.median(prepared.belt_velocity[still])
    loads = prepared.load(options.belt)
    _refuse_other_mass(loads["Fz"][still], options, name)
    labels = _labels(trial, person, name)
    filtered = noise_floors(still, prepared.rate_hz, **prepared.as_recorded(options.belts, person.labels))
    faults = recorded_faults(trial) + differs + ("filtered-signal",) * bool(filtered)
    positions = trial.values("marker_position")[:, :, 1:].astype(float)
    hidden = trial.values("marker_hidden")[:, [labels.index(label) for label in person.labels]]
    filtered = prepared.filtered(positions)
    _refuse_loose_segments(filtered[~hidden.any(axis=1)], labels, person, name)
    poses = segment_poses(filtered, labels, person)
    stretch_lowpass = replace(options.lowpass, cutoff_hz=options.stretch_cutoff_hz).within(prepared.rate_hz)
    sharp = segment_poses(stretch_lowpass(positions, prepared.rate_hz), labels, person)
    fault = stance_fault(prepared, Stance(filtered, hidden, poses["shank"], belt, loads["Fz"]), options)
    riding = filtered[:, [labels.index(label) for label in person.foot.labels], 0].mean(axis=1)
    # after a step the foot is not belt-fixed: report the step, not a delay of the markers
    try:
        delay_s = marker_delay(time, riding, belt, name)
    except InputError:
        if fault is None:
            raise
        delay_s = 0.0
    poses, sharp = ({key: advanced(time, x, delay_s) for key, x in p.items()} for p in (poses, sharp))
    gravity = person.body.gravity_m_per_s2
    recordings = {
        belt: recordings_above_rest(prepared, loads if belt == options.belt else prepared.load(belt), gravity)
        for belt in options.belts
    }
    ankle = poses["shank"] - poses["foot"]
    degree = degree_at(prepared.rate_hz)
    ankle_d = derivative(time, ankle, degree)

    @cache  # several pathways ask for the same
    def acceleration(key: str) -> np.ndarray:
        return derivative(time, derivative(time, poses[key], degree), degree)

    balance = PlateBalance(
        loads["Mx"] / loads["Fz"] - poses["ankle_point"][:, 0], poses["shank"], poses["thigh"]
    )
    return StandingTrial(
        prepared=prepared,
        onsets_s=np.array([_onset(trial, p.start, p.stop) for p in prepared.perturbations]),
        ends_s=np.array([time[min(p.stop, time.size - 1)] for p in prepared.perturbations]),
        belt_velocity=belt,
        f_y=loads["Fy"],
        y_cop=loads["Mx"] / loads["Fz"],
        ankle=ankle,
        ankle_d=ankle_d,
        ankle_dd=derivative(time, ankle_d, degree),
        shank=poses["shank"],
        thigh=poses["thigh"],
        knee=poses["thigh"] - poses["shank"],
        stretch_velocity={
            "ankle": derivative(time, sharp["shank"] - sharp["foot"]),
            "knee": derivative(time, sharp["thigh"] - sharp["shank"]),
        },
        torque={
            key: _torque(
                pathway.torque,
                person,
                _plate(pathway, loads, still, recordings, by_belt(models, options)),
                poses,
                acceleration,
            )
            for key, pathway in pathways.items()
        },
        labels=person.labels,
        hidden=hidden,
        delay_s=delay_s,
        fault=fault or pressure_fault(balance, still),
        plate=plate,
        plate_flags=(*plate.flags, *plate.faults, *balance_flags(balance, still, person), *faults),
    )


def _refuse_other_mass(f_z: np.ndarray, options: StandingOptions, name: str) -> None:
    """Raise InputError if the unperturbed vertical force (N) is not close to the person's weight."""
    person = options.person
    mass = float(f_z.mean()) / person.body.gravity_m_per_s2
    if abs(mass - person.mass_kg) > MASS_WITHIN * person.mass_kg:
        where = "both belts" if options.belt == BOTH else f"the {options.belt} belt"
        raise InputError(
            f"{name}: expected about {person.mass_kg:g} kg on {where}, found {mass:.3g} "
            "kg: correct standing.person.mass_kg, plate_treadmill.belt, or the calibration matrix"
        )


def by_belt(models: dict, options: StandingOptions) -> dict[str, dict]:
    """Belt -> models of its plate, or nothing without models; see `process_standing`."""
    return models if options.belt == BOTH or not models else {options.belt: models}


def recordings_above_rest(
    prepared: PreparedTrial, load: dict[str, np.ndarray], gravity_m_per_s2: float
) -> dict[str, BeltRecording]:
    """Recordings of Fy (N) and Mx (N·m) above rest of one belt, from its `PreparedTrial.load`."""
    still = prepared.at_rest
    above_rest = {component: load[component] - load[component][still].mean() for component in COMPONENTS}
    return recordings_of_loads(prepared, above_rest, float(load["Fz"][still].mean()) / gravity_m_per_s2)


def _labels(trial: Trial, person: Person, name: str) -> list[str]:
    """Names of the trial's markers, which must include the person's."""
    labels = trial.axes["marker"].tolist()
    for label in person.labels:
        if label not in labels:
            raise InputError(
                f"{name}: expected a marker named {label!r}, found {listed(labels)}: "
                "correct standing.files.marker_labels and the markers of standing.person"
            )
    return labels


def _refuse_loose_segments(positions: np.ndarray, labels: list[str], person: Person, name: str) -> None:
    """Raise InputError if a segment's markers, y and z (m) where all are visible, do not move as one body."""
    if not positions.size:
        return  # the markers are never all visible: every perturbation will be omitted
    for segment in ("foot", "shank", "thigh"):
        markers = getattr(person, segment)
        columns = [labels.index(label) for label in markers.labels]
        pose = fit_rigid_segment(positions[:, columns], markers.layout_m, np.zeros(2))
        try:
            refuse_loose(pose, positions[:, columns], markers, segment)
        except InputError as error:
            raise InputError(f"{name}: {error}") from error


def segment_poses(
    positions: Annotated[np.ndarray, "(n, markers, 2)", "m"],
    labels: list[str],
    person: Person,
    centre_m: Annotated[np.ndarray, "(2,)"] | None = None,
) -> dict[str, np.ndarray]:
    """Angles of foot, shank and thigh (rad), and positions of the ankle and of the feet's mass (m).

    centre_m: offset of the joint's centre from the assumed one, anterior and longitudinal in the shank.
    Returns: ``foot``, ``shank``, ``thigh``, shape (n,) (rad); ``ankle_point``, ``foot_com``, shape (n, 2)
    (m).
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


def _plate(
    pathway: TorquePathway,
    loads: dict[str, np.ndarray],
    still: np.ndarray,
    recordings: dict[str, dict[str, BeltRecording]],
    models: dict[str, dict[str, dict[str, FittedModel]]],
) -> PlateLoad:
    """Load of the plates as measured, or less the load predicted by a treadmill model for each (N, N·m)."""
    used = {component: loads[component] for component in COMPONENTS}
    if pathway.treadmill_model is not None:
        compensated = []
        for belt, of_belt in recordings.items():
            known = models.get(belt, {})
            chosen = {c: pick(known.get(c, {}), pathway.treadmill_model) for c in COMPONENTS}
            compensated.append(compensated_loads(chosen, of_belt))
        used = {c: sum(x[c] for x in compensated) + loads[c][still].mean() for c in COMPONENTS}
    return PlateLoad(f_y=used["Fy"], f_z=loads["Fz"], m_x=used["Mx"])


def _torque(
    kind: str,
    person: Person,
    plate: PlateLoad,
    poses: dict[str, np.ndarray],
    acceleration: Callable[[str], np.ndarray],
) -> np.ndarray:
    """Torque of both ankles from one free body (N·m), shape (n,).

    acceleration: second derivative of a pose (rad/s², m/s²).
    """
    feet = (person.feet, person.body.gravity_m_per_s2, plate, poses["ankle_point"], poses["foot_com"])
    if kind == "ankle":
        return standing_torque(*feet, acceleration("foot_com"), acceleration("foot"))
    if kind in AS_PRINTED:
        # eq (3-14) is the torque on the feet (standing_torque_as_printed)
        return -standing_torque_as_printed(*feet, acceleration("foot_com"), kind == VECTORS)
    if kind == "single-joint":
        shank_dd, ankle_dd = acceleration("shank"), acceleration("ankle_point")
        return single_joint_torque(person.body, poses["shank"], shank_dd, ankle_dd)
    raise InputError(
        f"expected a torque of {', '.join(TORQUES)}, found {kind!r}: correct torque in standing.pathways"
    )
