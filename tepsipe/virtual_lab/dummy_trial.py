"""One trial of the ankle dummy on the treadmill, from protocol and truth to raw files."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import scipy

from tepsipe.virtual_lab.belt import DriveTruth
from tepsipe.virtual_lab.dummy import (
    MARKERS,
    DummyMarkers,
    DummyMotion,
    DummyTruth,
    dummy_marker_paths,
    move_dummy,
)
from tepsipe.virtual_lab.loose_markers import Slip, Wobble, shifted, slipping, wobbling
from tepsipe.virtual_lab.motion_capture import MarkerPath
from tepsipe.virtual_lab.rubber import Rubber
from tepsipe.virtual_lab.seeds import generator
from tepsipe.virtual_lab.tilting_foot import FootTilt
from tepsipe.virtual_lab.treadmill_trial import (
    INTEGRATION_RATE_HZ,
    Protocol,
    record_capture,
    record_log,
    schedule_trial,
)
from tepsipe.virtual_lab.truth_file import TrueMotion, write_true_motion


def make_dummy_trial(truth: dict, condition: str, protocol: Protocol, files: dict[str, Path]) -> None:
    """Make one trial of the ankle dummy on the treadmill.

    truth: the laboratory's constants, as its configuration file holds them.
    condition: name of the condition: it seeds the trial's noise.
    files: files to write: ``log``, ``calibration`` and ``markers``, and ``motion``, the hidden motion of
    the joint, if it is wanted.
    """
    seed, rig = truth["seed"], truth["treadmill"]
    dummy = DummyTruth(**truth["dummy"]["subject"])
    # the rod is set upright by the motion capture
    upright = dummy.rest_angle_rad - rig["capture"]["vertical_rad"]
    dummy = replace(dummy, rest_angle_rad=upright)
    rng = generator(seed, "dummy", condition)
    of_slip = generator(seed, "dummy", condition, "slip")
    rest_after_s = rig["protocol"]["rest_after_s"]
    schedule = schedule_trial(rig, protocol, rest_after_s, rng)
    motion = move_dummy(
        dummy,
        Rubber(**truth["dummy"]["rubber"]),
        DriveTruth(**rig["drive"]),
        schedule.command,
        schedule.ends_s,
        INTEGRATION_RATE_HZ,
        FootTilt(**truth["dummy"]["foot_tilt"]),
    )
    load_kg = dummy.foot_mass_kg + dummy.leg_mass_kg
    record_log(rig, seed, schedule, {"right": (motion, load_kg)}, rng, files)
    paths = _marker_paths(truth["dummy"], dummy, motion, schedule.onsets_s, of_slip)
    record_capture(rig, schedule, MARKERS, paths, rng, files["markers"])
    if "motion" in files:
        angle, rate = motion.angle - motion.tilt, motion.angle_rate - motion.tilt_rate
        # parts that belong to the joint's inertia turn with the leg
        acceleration = np.gradient(motion.angle_rate, motion.time)
        elapsed = motion.time - schedule.trigger_s
        true = TrueMotion(elapsed, angle, rate, acceleration, motion.joint_torque)
        write_true_motion(files["motion"], true)


def _marker_paths(truth: dict, dummy: DummyTruth, motion: DummyMotion, onsets_s, rng) -> list[MarkerPath]:
    """Paths of the markers, including bending between markers and body and yielding tape."""
    layout = DummyMarkers(**truth["markers"])
    paths = dummy_marker_paths(layout, dummy, motion)
    wobble, slip = Wobble(**truth["wobble"]), Slip(**truth["slip"])
    foot = len(layout.foot_m)
    if wobble.common or wobble.growing_per_m:
        lag = wobbling(wobble, motion.time, motion.belt_acceleration)
        lags = scipy.interpolate.CubicSpline(motion.time, lag)
        for k, (_, along) in enumerate([layout.ankle_m, *layout.leg_m], start=foot):
            part = wobble.common + wobble.growing_per_m * along
            paths[k] = shifted(paths[k], lambda instant, part=part: part * lags(instant))
    for k, step in enumerate([slip.foot_m] * foot + [slip.ankle_m]):
        if step:
            paths[k] = shifted(paths[k], slipping(step, slip.settling_s, onsets_s, rng))
    return paths
