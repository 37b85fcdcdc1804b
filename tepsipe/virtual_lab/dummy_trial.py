"""One trial of the ankle dummy on the treadmill, from protocol and truth to raw files."""

from pathlib import Path

import numpy as np

from tepsipe.virtual_lab.belt import DriveTruth, velocity_command
from tepsipe.virtual_lab.dummy import DummyTruth, move_dummy
from tepsipe.virtual_lab.force_plate import PlateTruth, plate_electronics, plate_voltages
from tepsipe.virtual_lab.motion_capture import CaptureTruth, record_markers
from tepsipe.virtual_lab.rubber import Rubber
from tepsipe.virtual_lab.seeds import generator
from tepsipe.virtual_lab.treadmill_files import (
    write_calibration,
    write_markers,
    write_treadmill_log,
)

INTEGRATION_RATE_HZ = 2000.0


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
    """
    seed, rig = truth["seed"], truth["treadmill"]
    dummy = DummyTruth(**truth["dummy"]["subject"])
    plate, capture = PlateTruth(**rig["plate"]), CaptureTruth(**rig["capture"])
    drive = DriveTruth(**rig["drive"])
    rng = generator(seed, "dummy", condition)
    protocol = rig["protocol"]
    trigger_s = protocol["lead_s"] + rng.random() / plate.rate_hz
    last_onset = duration_s - protocol["rest_after_s"] - interval_s + 1e-9
    onsets = trigger_s + np.arange(protocol["rest_before_s"], last_onset, interval_s)
    command = velocity_command(profile, amplitude_m_per_s, onsets, protocol["pulse_s"])
    motion = move_dummy(
        dummy,
        Rubber(**truth["dummy"]["rubber"]),
        drive,
        command,
        trigger_s + duration_s + protocol["tail_s"],
        INTEGRATION_RATE_HZ,
    )
    sample = np.arange(0, motion.time.size, round(INTEGRATION_RATE_HZ / plate.rate_hz))
    volts_per_newton, matrix = plate_electronics(plate, generator(seed, "plate"))
    voltages = plate_voltages(
        plate,
        volts_per_newton,
        motion.reaction,
        motion.belt_velocity,
        motion.belt_acceleration,
        dummy.foot_mass_kg + dummy.leg_mass_kg,
        INTEGRATION_RATE_HZ,
        sample,
        rng,
    )
    time = motion.time[sample]
    noisy = motion.belt_velocity[sample] + drive.velocity_noise_m_per_s * rng.standard_normal(sample.size)
    velocity = drive.velocity_step_m_per_s * np.round(noisy / drive.velocity_step_m_per_s)
    running = (time >= trigger_s) & (time < trigger_s + duration_s)
    commanded = np.array([command(t) for t in time.tolist()])
    write_treadmill_log(log, plate.rate_hz, voltages, velocity, commanded, np.where(running, 5.0, 0.0))
    write_calibration(calibration, matrix)
    frames = round(duration_s * capture.rate_hz)
    positions = record_markers(capture, dummy, motion, trigger_s, frames, rng)
    write_markers(markers, positions, capture.rate_hz)
