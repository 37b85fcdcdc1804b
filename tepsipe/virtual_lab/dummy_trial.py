"""One trial of the ankle dummy on the treadmill, from protocol and truth to raw files."""

from pathlib import Path

import numpy as np

from tepsipe.virtual_lab.belt import DriveTruth
from tepsipe.virtual_lab.dummy import MARKERS, DummyMarkers, DummyTruth, dummy_marker_paths, move_dummy
from tepsipe.virtual_lab.rubber import Rubber
from tepsipe.virtual_lab.seeds import generator
from tepsipe.virtual_lab.treadmill_trial import (
    INTEGRATION_RATE_HZ,
    record_capture,
    record_log,
    schedule_trial,
)
from tepsipe.virtual_lab.truth_file import TrueMotion, write_true_motion


def make_dummy_trial(
    truth: dict,
    condition: str,
    profile: str,
    amplitude_m_per_s: float,
    interval_s: float,
    duration_s: float,
    log: Path,
    calibration: Path,
    markers: Path,
    motion_file: Path | None = None,
) -> None:
    """Make one trial of the ankle dummy on the treadmill.

    Parameters
    ----------
    truth : dict
        The laboratory's constants, as its configuration file holds them (units in the keys).
    condition : str
        Name of the condition: it seeds the trial's noise.
    profile : {"sine", "minjerk"}
        Shape of the perturbations.
    amplitude_m_per_s, interval_s, duration_s : float
        Velocity amplitude (m/s), time between perturbations (s), length of the trial (s).
    log, calibration, markers : Path
        Files to write: treadmill log, calibration matrix and C3D.
    motion_file : Path, optional
        File for the hidden motion of the joint (s, rad, N·m).
    """
    seed, rig = truth["seed"], truth["treadmill"]
    dummy = DummyTruth(**truth["dummy"]["subject"])
    rng = generator(seed, "dummy", condition)
    rest_after_s = rig["protocol"]["rest_after_s"]
    schedule = schedule_trial(rig, profile, amplitude_m_per_s, interval_s, duration_s, rest_after_s, rng)
    motion = move_dummy(
        dummy,
        Rubber(**truth["dummy"]["rubber"]),
        DriveTruth(**rig["drive"]),
        schedule.command,
        schedule.ends_s,
        INTEGRATION_RATE_HZ,
    )
    load_kg = dummy.foot_mass_kg + dummy.leg_mass_kg
    record_log(rig, seed, schedule, motion, load_kg, rng, log, calibration)
    paths = dummy_marker_paths(DummyMarkers(**truth["dummy"]["markers"]), dummy, motion)
    record_capture(rig, schedule, MARKERS, paths, rng, markers)
    if motion_file is not None:
        rate = motion.angle_rate
        acceleration = np.gradient(rate, motion.time)
        elapsed = motion.time - schedule.trigger_s
        write_true_motion(
            motion_file, TrueMotion(elapsed, motion.angle, rate, acceleration, motion.joint_torque)
        )
