"""Parts common to all trials on the treadmill: schedule, and recording by log, plate and cameras."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np

from tepsipe.virtual_lab.belt import BeltMotion, DriveTruth, velocity_command
from tepsipe.virtual_lab.force_plate import Loaded, PlateTruth, plate_electronics, voltages_of_belts
from tepsipe.virtual_lab.motion_capture import CaptureTruth, MarkerPath, record_markers
from tepsipe.virtual_lab.seeds import generator
from tepsipe.virtual_lab.treadmill_files import write_calibration, write_markers, write_treadmill_log

INTEGRATION_RATE_HZ = 2000.0


@dataclass(frozen=True)
class Protocol:
    """Perturbations and length of one trial."""

    profile: str
    """{"sine", "negative-sine", "minjerk"}: Shape of the perturbations."""
    amplitude_m_per_s: float
    """Velocity amplitude."""
    interval_s: float | tuple[float, float]
    """Time from a perturbation to the next (s); its shortest and longest value where it is random."""
    duration_s: float
    """Length of the trial."""


@dataclass(frozen=True)
class Schedule:
    """Instant of a trial's trigger, and the command of the belt."""

    trigger_s: float
    duration_s: float
    """Trigger's edge on the laboratory's clock, and how long the trigger is high."""
    ends_s: float
    """End of the recording."""
    onsets_s: Annotated[np.ndarray, "(k,)"]
    """Commanded onsets of the perturbations."""
    command: Callable[[float], float]
    """Commanded belt velocity (m/s) at t (s)."""


def schedule_trial(rig: dict, protocol: Protocol, rest_after_s: float, rng: np.random.Generator) -> Schedule:
    """Lay out a trial's perturbations, the last a whole interval before the rest at the end.

    rig: the treadmill's constants, as the laboratory's configuration holds them.
    rest_after_s: unperturbed time at the trial's end.
    """
    trigger_s = _trigger(rig, rng)
    last_onset = protocol.duration_s - rest_after_s - protocol.interval_s + 1e-9
    onsets = trigger_s + np.arange(rig["protocol"]["rest_before_s"], last_onset, protocol.interval_s)
    return _schedule(rig, protocol, onsets, trigger_s)


def schedule_at_random(rig: dict, protocol: Protocol, rng: np.random.Generator) -> Schedule:
    """Lay out a trial's perturbations at random intervals, with at least a longest one before its end.

    rig: the treadmill's constants, as the laboratory's configuration holds them.
    protocol: perturbations with the shortest and the longest interval, also from the trigger to the first.
    """
    trigger_s = _trigger(rig, rng)
    shortest_s, longest_s = protocol.interval_s
    onsets = trigger_s + np.cumsum(rng.uniform(shortest_s, longest_s, int(protocol.duration_s / shortest_s)))
    onsets = onsets[onsets < trigger_s + protocol.duration_s - longest_s]
    return _schedule(rig, protocol, onsets, trigger_s)


def _trigger(rig: dict, rng: np.random.Generator) -> float:
    return rig["protocol"]["lead_s"] + rng.random() / rig["plate"]["rate_hz"]


def _schedule(rig: dict, protocol: Protocol, onsets: np.ndarray, trigger_s: float) -> Schedule:
    usual, lasts_s = rig["protocol"], protocol.duration_s
    command = velocity_command(protocol.profile, protocol.amplitude_m_per_s, onsets, usual["pulse_s"])
    return Schedule(trigger_s, lasts_s, trigger_s + lasts_s + usual["tail_s"], onsets, command)


def record_log(
    rig: dict,
    seed: int,
    schedule: Schedule,
    loads: dict[str, tuple[BeltMotion, float]],
    rng: np.random.Generator,
    files: dict[str, Path],
) -> None:
    """Write the treadmill's log of a motion and the calibration matrix of its plates.

    rig: the treadmill's constants, as the laboratory's configuration holds them.
    seed: seed of the laboratory: every trial has the same plate.
    loads: belt, left or right -> motion and reaction on the grid of the integration (s, m, N, N·m), and
    mass on the belt (kg). Two belts move alike.
    files: files to write: ``log`` and ``calibration``.
    """
    plate, drive = PlateTruth(**rig["plate"]), DriveTruth(**rig["drive"])
    plates = {"left": PlateTruth(**rig["plate"] | rig.get("left_plate", {})), "right": plate}
    motion = next(iter(loads.values()))[0]
    sample = np.arange(0, motion.time.size, round(motion.rate_hz / plate.rate_hz))
    volts_per_newton, matrix = plate_electronics(plate, generator(seed, "plate"))
    loaded = {belt: Loaded(plates[belt], *load) for belt, load in loads.items()}
    voltages = voltages_of_belts(loaded, volts_per_newton, sample, rng)
    time = motion.time[sample]
    noisy = motion.belt_velocity[sample] + drive.velocity_noise_m_per_s * rng.standard_normal(sample.size)
    velocity = drive.velocity_step_m_per_s * np.round(noisy / drive.velocity_step_m_per_s)
    running = (time >= schedule.trigger_s) & (time < schedule.trigger_s + schedule.duration_s)
    commanded = np.array([schedule.command(t) for t in time.tolist()])
    trigger = np.where(running, 5.0, 0.0)
    write_treadmill_log(files["log"], plate.rate_hz, voltages, velocity, commanded, trigger)
    write_calibration(files["calibration"], matrix)


def record_capture(
    rig: dict,
    schedule: Schedule,
    labels: tuple[str, ...],
    paths: list[MarkerPath],
    rng: np.random.Generator,
    markers: Path,
) -> None:
    """Write the markers that the motion capture system records while the trigger is high.

    rig: the treadmill's constants, as the laboratory's configuration holds them.
    schedule: trigger and length of the trial.
    labels: names of the markers, in the strober's order.
    paths: exact position, shape (n, 3), of each marker at instants, shape (n,).
    markers: C3D file to write.
    """
    capture = CaptureTruth(**rig["capture"])
    frames = round(schedule.duration_s * capture.rate_hz)
    positions = record_markers(capture, paths, schedule.trigger_s, frames, rng)
    write_markers(markers, labels, positions, capture.rate_hz)
