"""One trial of a person standing on the treadmill, from protocol and truth to raw files.

Markers on the marked leg of a standing person, on skin that moves and a joint that lies elsewhere.

The soft tissue of shank and thigh is a damped oscillator under the acceleration a of the bone below the
marker, in each direction of the sagittal plane, and the marker takes part in its motion by a share:

    x'' + 2 d w x' + w^2 x = -a,     displacement = share x

The skin over the malleolus slides forward by a length per rotation of the ankle. The forefoot follows the
tilt of the hindfoot by a share, the arch takes the rest.
"""

import math
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import numpy as np
import scipy

from tepsipe.virtual_lab.belt import DriveTruth
from tepsipe.virtual_lab.electromyography import CHANNELS, EmgTruth, record_emg, sample_trigger, write_emg
from tepsipe.virtual_lab.person import (
    PersonMotion,
    loads_of_legs,
    marked_shank,
    marked_tilt,
    move_person,
    true_ankles,
)
from tepsipe.virtual_lab.person_constants import (
    MARKERS,
    MUSCLES,
    MuscleTruth,
    NervesTruth,
    PersonMarkers,
    PersonTruth,
    SkinTruth,
    Subject,
    TaskTruth,
    shanks,
    thighs,
)
from tepsipe.virtual_lab.seeds import generator
from tepsipe.virtual_lab.treadmill_trial import (
    MarkerPath,
    Protocol,
    plates_of,
    record_capture,
    record_log,
    schedule_at_random,
)
from tepsipe.virtual_lab.truth_file import write_true_motion


def person_marker_paths(
    markers: PersonMarkers, person: PersonTruth, skin: SkinTruth, motion: PersonMotion
) -> list[MarkerPath]:
    """Paths of the markers on foot, ankle, shank and thigh, in the order of `MARKERS`.

    motion: exact motion of the rig.
    Returns: each gives x, y, z, shape (n, 3), at instants, shape (n,).
    """
    belt = scipy.interpolate.CubicSpline(motion.time, motion.position)
    x = person.position_x_m + markers.lateral_m

    def path(displacement: np.ndarray) -> MarkerPath:
        """Path of a point from its displacement forward of the ankle and above the belt (m), shape (n, 2)."""
        spline = scipy.interpolate.CubicSpline(motion.time, displacement)

        def at(instant: np.ndarray) -> np.ndarray:
            forward, up = spline(instant).T
            y = person.position_y_m + belt(instant) + forward
            return np.column_stack([np.full(instant.shape, x), y, up])

        return at

    return [path(displacement) for displacement in marker_displacements(markers, person, skin, motion)]


def marker_displacements(
    markers: PersonMarkers, person: PersonTruth, skin: SkinTruth, motion: PersonMotion
) -> list[np.ndarray]:
    """Positions of the markers, forward of the ankle and above the belt (m), each of shape (n, 2).

    motion: exact motion of the rig.
    Returns: in the order of `MARKERS`, on the grid of ``motion``.
    """
    stance, height = person.stance_rad, person.ankle_height_m
    centre_y, centre_z = markers.joint_centre_m
    swung, thigh = (motion.angles[:, k] - stance[k] for k in (0, 1))
    shank = stance[0] + marked_shank(person, swung)
    # both legs carry the same hips: the thigh rotates less by the excess rotation of the marked shank
    size = person.mass_kg, person.stature_m
    longer = shanks(*size).length_m / thighs(*size).length_m
    thigh = stance[1] + thigh - longer * (shank - stance[0] - swung)
    tilt = marked_tilt(person, motion.foot)
    ankle = np.array([0.0, height])
    knee = ankle + _turned(shank, 0.0, shanks(*size).length_m)
    rotation = shank - stance[0] - tilt
    slid = np.column_stack([skin.slip_m_per_rad * rotation, np.zeros_like(rotation)])
    displacements = []
    for along, up in markers.foot_m:
        share = person.forefoot_share if along > 0.0 else 1.0
        displacements.append(ankle + _turned(share * tilt, along - centre_y, up - centre_z - height))
    displacements.append(ankle + _turned(shank, -centre_y, -centre_z) + slid)
    for across, along in markers.shank_m:
        bone = ankle + _turned(shank, across - centre_y, along - centre_z)
        displacements.append(bone + wobble(skin, skin.shank_share, motion, bone))
    for across, along in markers.thigh_m:
        bone = knee + _turned(thigh, across, along)
        displacements.append(bone + wobble(skin, skin.thigh_share, motion, bone))
    return displacements


def _turned(angle: np.ndarray, across: float, along: float) -> np.ndarray:
    """A point of a segment that tips towards +y, shape (n, 2)."""
    sin, cos = np.sin(angle), np.cos(angle)
    return np.column_stack([across * cos + along * sin, along * cos - across * sin])


def wobble(
    skin: SkinTruth, share: float, motion: PersonMotion, bone: Annotated[np.ndarray, "(n, 2)", "m"]
) -> Annotated[np.ndarray, "(n, 2)", "m"]:
    """Displacement of a marker from the bone below it (m), shape (n, 2).

    share: part of the soft tissue's motion in which the marker takes part.
    motion: exact motion of the rig.
    bone: the point of the bone, forward of the ankle and above the belt.
    Returns: forward and up.
    """
    if not share:
        return np.zeros_like(bone)
    step_s = float(motion.time[1] - motion.time[0])
    acceleration = np.zeros_like(bone)
    acceleration[1:-1] = (bone[2:] - 2.0 * bone[1:-1] + bone[:-2]) / step_s**2
    acceleration[:, 0] += motion.acceleration
    w = 2.0 * math.pi * skin.frequency_hz
    oscillator = ([-1.0], [1.0, 2.0 * skin.damping * w, w**2])
    numerator, denominator, _ = scipy.signal.cont2discrete(oscillator, step_s, method="foh")
    return share * scipy.signal.lfilter(np.ravel(numerator), denominator, acceleration, axis=0)


# the body is slower than the dummy: half as many steps as for the other rigs are enough
INTEGRATION_RATE_HZ = 1000.0


def make_standing_trial(
    truth: dict, condition: str, task: str, protocol: Protocol, files: dict[str, Path], belt: str = "right"
) -> None:
    """Make one trial of a person standing on the treadmill.

    truth: the laboratory's constants, as its configuration file holds them.
    condition: name of the condition: it seeds the trial's noise and intervals.
    task: {"relax", "stiff"}: Task of the person.
    files: files to write: ``log``, ``calibration``, ``markers`` and ``emg``, and ``motion``, the hidden
    motion of the ankles, if it is wanted.
    belt: {"right", "both"}: Both feet on the right belt, or each foot on the belt of its side.
    """
    seed, rig, standing = truth["seed"], truth["treadmill"], truth["standing"]
    rng = generator(seed, "standing", condition)
    of_nerves, of_emg = rng.spawn(2)
    schedule = schedule_at_random(rig, protocol, rng)
    person, doing = PersonTruth(**standing["person"]), TaskTruth(**standing["tasks"][task])
    muscles = {name: MuscleTruth(**standing["muscles"][name]) for name in MUSCLES}
    if belt == "both":  # the middle between the feet is the middle between the belts
        person = replace(person, position_x_m=0.0)
    plates, left = plates_of(rig), person.left_share if belt == "both" else 0.0
    below = [(plates["right"], 1.0 - left)] + ([(plates["left"], left)] if left else [])
    motion = move_person(
        Subject(person, muscles, doing, NervesTruth(**standing["nerves"])),
        DriveTruth(**rig["drive"]),
        schedule.command,
        schedule.ends_s,
        INTEGRATION_RATE_HZ,
        of_nerves,
        below,
    )
    markers = PersonMarkers(**standing["markers"])
    loads = loads_of_legs(person, motion, markers.lateral_m) if belt == "both" else {"right": motion}
    record_log(rig, seed, schedule, loads, rng, files)
    skin = SkinTruth(**standing["skin"])
    paths = person_marker_paths(markers, person, skin, motion)
    record_capture(rig, schedule, MARKERS, paths, rng, files["markers"])
    recorder = EmgTruth(**standing["emg"])
    voltages, instants = record_emg(
        recorder, motion.time, motion.drive, motion.acceleration, schedule.ends_s, of_emg
    )
    trigger = sample_trigger(instants, schedule.trigger_s, schedule.duration_s)
    write_emg(files["emg"], CHANNELS, voltages, trigger, recorder.rate_hz, recorder.limit_uV)
    if "motion" in files:
        write_true_motion(files["motion"], true_ankles(person, doing, motion, schedule.trigger_s))
