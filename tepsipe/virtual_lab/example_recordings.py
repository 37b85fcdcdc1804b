"""Simulated recordings that `tepsipe.load_example` returns, with their truth.

    python -m tepsipe.virtual_lab.example_recordings FOLDER

writes them into a folder, one compressed file of NumPy each. As in an instrument, samples are whole counts:
a resolution, which the facts of a recording name, times a count gives the sample in its unit. All joints
here are linear, so that one I, B and K is true for every amplitude.
"""

import json
import sys
from pathlib import Path

import numpy as np
import scipy

from tepsipe.virtual_lab.belt import DriveTruth, velocity_command
from tepsipe.virtual_lab.dummy import MARKERS, DummyMarkers, DummyTruth, dummy_marker_paths, move_dummy
from tepsipe.virtual_lab.rubber import Rubber
from tepsipe.virtual_lab.seeds import generator
from tepsipe.virtual_lab.treadmill_trial import CaptureTruth, record_markers
from tepsipe.virtual_lab.wristalyzer_trial import ManipulatorTruth, record_manipulator

SEED = 1
RATE_HZ = 250.0
# steps of the simulation per sample
FINER = 8

# ---- an ankle dummy on a treadmill ---------------------------------------------------------------

# I of the joint adds to the leg's own inertia
DUMMY_TRUTH = {"I": 0.02, "B": 0.15, "K": 10.0}
DUMMY_DURATION_S = 62.0
LEG = {"mass_kg": 0.4, "com_m": 0.4485, "inertia_kgm2": 0.027}
# anterior and longitudinal offset from the ankle (m)
LEG_LAYOUT_M = {
    "ankle": (0.0, 0.0),
    "leg1": (-0.012, 0.6),
    "leg2": (0.012, 0.5),
    "leg3": (-0.012, 0.4),
    "leg4": (0.012, 0.3),
}
FOOT_LAYOUT_M = ((-0.04, 0.015), (0.04, 0.015), (0.0, 0.04))
DRIVE = DriveTruth(
    belt_mass_kg=45.0,
    bandwidth_hz=14.0,
    integral_time_s=0.25,
    force_limit_N=1150.0,
    delay_s=0.012,
    viscous_Ns_per_m=60.0,
    velocity_step_m_per_s=0.0005,
    velocity_noise_m_per_s=0.001,
)
CAMERAS = CaptureTruth(
    rate_hz=RATE_HZ,
    marker_sampling_hz=np.inf,  # all markers at once
    latency_s=0.0,
    clock_ppm=0.0,
    length_scale=1.0,
    vertical_rad=0.0,
    noise_m=0.00002,
    occlusions_per_minute=0.0,
    occlusion_s=0.001,
)


def dummy() -> tuple[dict[str, np.ndarray], dict]:
    """A leg on an elastic joint, on a belt with 14 pulses; the joint has sensors of angle and torque."""
    rng = generator(SEED, "example", "dummy")
    onsets_s = 3.0 + np.cumsum(rng.uniform(3.7, 4.3, 14)) - 4.0
    subject = DummyTruth(
        foot_mass_kg=2.1,
        foot_height_m=0.055,
        foot_com_m=[0.0, 0.0275],
        joint_offset_m=[0.0, 0.0],
        leg_mass_kg=LEG["mass_kg"],
        leg_com_m=LEG["com_m"],
        leg_inertia_kgm2=LEG["inertia_kgm2"],
        joint_inertia_kgm2=DUMMY_TRUTH["I"],
        rest_angle_rad=0.01,
        position_x_m=0.0,
        position_y_m=0.0,
        gravity_m_per_s2=9.81,
    )
    joint = Rubber(DUMMY_TRUTH["K"], DUMMY_TRUTH["B"], 0.0, 1.0, 0.0)
    command = velocity_command("sine", 0.3, onsets_s, 0.1)
    motion = move_dummy(subject, joint, DRIVE, command, DUMMY_DURATION_S, FINER * RATE_HZ)
    frames = round(DUMMY_DURATION_S * RATE_HZ)
    ankle, *leg = map(list, LEG_LAYOUT_M.values())
    layout = DummyMarkers([list(place) for place in FOOT_LAYOUT_M], ankle, leg, 0.0)
    paths = dummy_marker_paths(layout, subject, motion)
    positions = record_markers(CAMERAS, paths, 0.0, frames, rng)[:, :, 1:]
    signals = {
        "angle_rad": motion.angle[::FINER][:frames] + 0.0001 * rng.standard_normal(frames),
        "torque_Nm": motion.joint_torque[::FINER][:frames] + 0.005 * rng.standard_normal(frames),
        "belt_velocity_m_per_s": motion.belt_velocity[::FINER][:frames]
        + DRIVE.velocity_noise_m_per_s * rng.standard_normal(frames),
        "positions_m": np.moveaxis(positions, 0, -1),
    }
    resolution = {
        "angle_rad": 0.00001,
        "torque_Nm": 0.001,
        "belt_velocity_m_per_s": DRIVE.velocity_step_m_per_s,
        "positions_m": 0.00001,
    }
    facts = {
        "description": "Leg of the ankle dummy on a linear joint, perturbed by 14 pulses of a treadmill belt "
        "(0.3 m/s, 0.1 s). Sensors in the joint measure its angle and torque; cameras record markers.",
        "truth": DUMMY_TRUTH,
        "rate_hz": RATE_HZ,
        "resolution": resolution,
        "leg": LEG,
        "layout_m": LEG_LAYOUT_M,
        "labels": list(MARKERS),
        "belt_fixed": list(MARKERS[:4]),
    }
    return _counts(signals, resolution), facts


# ---- a human ankle -------------------------------------------------------------------------------

ANKLE_TRUTH = {"I": 0.015, "B": 2.0, "K": 80.0, "reflex_gain": 5.0, "reflex_delay": 0.04}
ANKLE_DURATION_S = 60.0


def ankle() -> tuple[dict[str, np.ndarray], dict]:
    """A human ankle under random movement: intrinsic I, B, K, and a stretch reflex.

    The reflex torque is the dorsiflexion velocity, delayed and smoothed by the muscle's twitch (a bell of
    30 ms about 0.1 s), times its gain.
    """
    rng = generator(SEED, "example", "ankle")
    step = 1.0 / (FINER * RATE_HZ)
    count = round(ANKLE_DURATION_S / step)
    time = step * np.arange(count)
    lowpass = scipy.signal.butter(2, 4.0, fs=1.0 / step, output="sos")
    angle = scipy.signal.sosfiltfilt(lowpass, rng.standard_normal(count))
    angle *= 0.02 / angle.std()
    course = scipy.interpolate.CubicSpline(time, angle)
    rate, acceleration = course(time, 1), course(time, 2)
    torque = ANKLE_TRUTH["I"] * acceleration + ANKLE_TRUTH["B"] * rate + ANKLE_TRUTH["K"] * angle
    late = np.interp(time - ANKLE_TRUTH["reflex_delay"], time, np.maximum(rate, 0.0))
    twitch = np.exp(-0.5 * ((np.arange(0.0, 0.3, step) - 0.1) / 0.03) ** 2)
    torque += ANKLE_TRUTH["reflex_gain"] * scipy.signal.fftconvolve(late, twitch / twitch.sum())[:count]
    frames = round(ANKLE_DURATION_S * RATE_HZ)
    signals = {
        "angle_rad": angle[::FINER] + 0.00002 * rng.standard_normal(frames),
        "torque_Nm": torque[::FINER] + 0.1 * rng.standard_normal(frames),
    }
    resolution = {"angle_rad": 0.00001, "torque_Nm": 0.01}
    facts = {
        "description": "Human ankle under imposed random movement: intrinsic inertia, damping and stiffness, "
        "and a stretch reflex that answers dorsiflexion only.",
        "truth": ANKLE_TRUTH,
        "rate_hz": RATE_HZ,
        "resolution": resolution,
    }
    return _counts(signals, resolution), facts


# ---- a joint in a torque-controlled manipulator --------------------------------------------------

MANIPULATOR_TRUTH = {"I": 0.015, "B": 0.2, "K": 10.0}
MANIPULATOR_DURATION_S = 60.0
MANIPULATOR_PERIOD_S = 10.0


def manipulator() -> tuple[dict[str, np.ndarray], dict]:
    """A joint perturbed by a periodic torque of 1 to 20 Hz; its angle and the torque are measured."""
    rate_hz = FINER * RATE_HZ
    rig = ManipulatorTruth(
        inertia_kgm2=MANIPULATOR_TRUTH["I"],
        contact_Nm_per_rad3=0.0,
        friction_Nm=0.0,
        friction_rate_rad_per_s=1.0,
        ripple_Nm=0.01,
        ripple_bandwidth_hz=32.0,
        torque_per_factor_Nm=0.8,
        torque_scale=1.0,
        angle_scale=1.0,
        torque_delay_s=0.0,
        band_low_hz=1.0,
        band_high_hz=20.0,
        period_s=MANIPULATOR_PERIOD_S,
        command_rate_hz=rate_hz,
        log_rate_hz=rate_hz,
        log_jitter_s=0.0,
        repeated_fraction=0.0,
        missing_fraction=0.0,
        encoder_step_rad=0.0001,
        encoder_zero_rad=0.0,
        lead_s=MANIPULATOR_PERIOD_S,
        tail_s=0.0,
    )
    joint = Rubber(MANIPULATOR_TRUTH["K"], MANIPULATOR_TRUTH["B"], 0.0, 1.0, 0.0)
    of_command, of_trial = (generator(SEED, "example", "manipulator", name) for name in ("command", "trial"))
    # a first period, which is left out, lets the joint settle
    duration_s = MANIPULATOR_DURATION_S + MANIPULATOR_PERIOD_S
    recorded = record_manipulator(rig, joint, 1.0, duration_s, of_command, of_trial)
    frames = round(MANIPULATOR_DURATION_S * RATE_HZ)
    at = round((rig.lead_s + MANIPULATOR_PERIOD_S) * rate_hz) + FINER * np.arange(frames)
    signals = {
        "angle_rad": recorded.motion.angle[at],
        "torque_Nm": recorded.motion.torque[at] + 0.01 * of_trial.standard_normal(frames),
    }
    resolution = {"angle_rad": rig.encoder_step_rad, "torque_Nm": 0.001}
    facts = {
        "description": "Elastic joint in a manipulator that applies a random torque of 1 to 20 Hz, periodic "
        "in 10 s. An encoder measures the angle, a sensor the torque.",
        "truth": MANIPULATOR_TRUTH,
        "rate_hz": RATE_HZ,
        "resolution": resolution,
        "period_s": MANIPULATOR_PERIOD_S,
    }
    return _counts(signals, resolution), facts


# ---- files ---------------------------------------------------------------------------------------

RECORDINGS = {"dummy": dummy, "ankle": ankle, "manipulator": manipulator}


def _counts(signals: dict[str, np.ndarray], resolution: dict[str, float]) -> dict[str, np.ndarray]:
    return {name: np.round(x / resolution[name]).astype(np.int32) for name, x in signals.items()}


def write_recordings(folder: Path) -> list[Path]:
    """Simulate every recording and write it as ``<name>.npz``: counts, and facts as JSON (units in keys)."""
    written = []
    for name, simulate in RECORDINGS.items():
        counts, facts = simulate()
        path = folder / f"{name}.npz"
        np.savez_compressed(path, facts=json.dumps(facts, ensure_ascii=False), **counts)
        written.append(path)
    return written


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    print(*write_recordings(Path(sys.argv[1])), sep="\n")
