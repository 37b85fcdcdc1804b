"""Parts common to all trials on the treadmill: schedule, and recording by log, plate and cameras.

Write the files that the treadmill and the motion capture system would have written.

Active markers, strobed one after another, as the motion capture system records them.
"""

import errno
import os
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import scipy
from annotated_types import Ge, Gt, Le

from tepsipe.quantities import Angle, Height, NotNegative, Pause, Rate
from tepsipe.virtual_lab.belt import BeltMotion, Command, DriveTruth, velocity_command
from tepsipe.virtual_lab.force_plate import (
    BELTS,
    COMPONENTS,
    TRANSDUCERS,
    Loaded,
    PlateTruth,
    plate_electronics,
    voltages_of_belts,
)
from tepsipe.virtual_lab.seeds import generator

CHANNELS = tuple(f"{belt}_{name}" for belt in BELTS for name in TRANSDUCERS)


def write_treadmill_log(
    path: Path,
    rate_hz: float,
    voltages: Annotated[np.ndarray, "(n, 14)", "V"],
    belt_velocity: Annotated[np.ndarray, "(n,)", "m/s"],
    command: Annotated[np.ndarray, "(n,)", "m/s"],
    trigger: Annotated[np.ndarray, "(n,)", "V"],
) -> None:
    """Write the treadmill's log as a MATLAB file.

    voltages: transducer channels.
    belt_velocity, command: measured and commanded velocity of the right belt.
    trigger: trigger line.
    """
    content = {
        "sample_rate_hz": float(rate_hz),
        "channel_names": np.array(CHANNELS, dtype=object),
        "transducers_V": voltages.astype(np.float32),
        "belt_velocity_m_per_s": belt_velocity.astype(np.float32)[:, None],
        "command_m_per_s": command.astype(np.float32)[:, None],
        "trigger_V": trigger.astype(np.float32)[:, None],
    }
    scipy.io.savemat(path, content)
    # the header holds the date of writing: the same study must give the same bytes
    with open(path, "r+b") as file:
        file.write(b"MATLAB 5.0 MAT-file, instrumented treadmill log".ljust(116))


def write_calibration(path: Path, calibration: np.ndarray) -> None:
    """Write the 12 x 14 calibration matrix as CSV: a row per component and belt (N/V, N·m/V)."""
    lines = [",".join(["component", "unit", *CHANNELS]) + "\n"]
    names = [(belt, component) for belt in BELTS for component in COMPONENTS]
    for (belt, component), row in zip(names, calibration, strict=True):
        unit = "N/V" if component.startswith("F") else "Nm/V"
        lines.append(",".join([f"{component}_{belt}", unit, *[f"{c:.9g}" for c in row]]) + "\n")
    path.write_text("".join(lines))


def write_markers(
    path: Path,
    labels: tuple[str, ...],
    positions: Annotated[np.ndarray, "(frames, markers, 3)"],
    rate_hz: float,
) -> None:
    """Write markers as C3D.

    positions: x, y, z (m), NaN while hidden; the file holds mm.
    rate_hz: frame rate.
    """
    import ezc3d  # loads a compiled library, which only makers of files need

    file = ezc3d.c3d()
    file["parameters"]["POINT"]["RATE"]["value"] = [float(rate_hz)]
    file["parameters"]["POINT"]["LABELS"]["value"] = list(labels)
    file["parameters"]["POINT"]["UNITS"]["value"] = ["mm"]
    points = np.ones((4, positions.shape[1], positions.shape[0]))
    points[:3] = 1000.0 * positions.transpose(2, 1, 0)
    file["data"]["points"] = points
    hidden = np.isnan(points[:3]).any(axis=0)
    file["data"]["meta_points"]["residuals"] = np.where(hidden, -1.0, 0.0)[None]
    file["data"]["meta_points"]["camera_masks"] = np.zeros((7, *hidden.shape), dtype=bool)
    file.write(str(path))
    if path.stat().st_size < 4 * points.size:  # four numbers of four bytes per marker and frame
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))


# positions x, y, z of a marker (m), shape (n, 3), at instants (s), shape (n,)
MarkerPath = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class CaptureTruth:
    """Motion capture."""

    rate_hz: Rate
    """Frames per second."""
    marker_sampling_hz: Rate
    """Markers per second within a frame."""
    latency_s: Annotated[float, Ge(0), Le(10)]
    """Time from the trigger to the first marker of the first frame."""
    clock_ppm: Annotated[float, Ge(-100000), Le(100000), "parts per million"]
    """How much faster the clock runs than that of the treadmill's log."""
    length_scale: Annotated[float, Gt(0), Le(10)]
    """Measured over true lengths."""
    vertical_rad: Angle
    """Angle by which an upright rod is seen to lean forwards."""
    noise_m: Height
    """Standard deviation of each coordinate."""
    occlusions_per_minute: Annotated[NotNegative, "1/min"]
    """Mean number of occlusions of a marker per minute."""
    occlusion_s: Pause
    """Their mean length; each hides a frame at least."""


def record_markers(
    capture: CaptureTruth, paths: list[MarkerPath], trigger_s: float, frames: int, rng: np.random.Generator
) -> Annotated[np.ndarray, "(frames, markers, 3)"]:
    """Marker positions frame by frame.

    paths: exact position x, y, z, shape (n, 3), at instants, shape (n,), of each marker, in the strober's
    order.
    trigger_s: time of the trigger's edge on the paths' clock.
    Returns: x, y, z (m); NaN while a marker is hidden.
    """
    faster = 1.0 + 1e-6 * capture.clock_ppm
    first = trigger_s + capture.latency_s + np.arange(frames) / (faster * capture.rate_hz)
    positions = np.empty((frames, len(paths), 3))
    for k, path in enumerate(paths):
        positions[:, k] = path(first + k / capture.marker_sampling_hz)
    if capture.vertical_rad:
        lean, upright = np.sin(capture.vertical_rad), np.cos(capture.vertical_rad)
        y, z = positions[:, :, 1].copy(), positions[:, :, 2].copy()
        positions[:, :, 1], positions[:, :, 2] = upright * y + lean * z, upright * z - lean * y
    positions *= capture.length_scale
    positions += capture.noise_m * rng.standard_normal(positions.shape)
    expected = capture.occlusions_per_minute * frames / capture.rate_hz / 60.0
    further_frames = max(capture.occlusion_s * capture.rate_hz - 1.0, 0.0)
    for k in range(len(paths)):
        for start in rng.integers(0, frames, rng.poisson(expected)):
            length = 1 + rng.poisson(further_frames)
            positions[start : start + length, k] = np.nan
    return positions


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
    command: Command
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


def plates_of(rig: dict) -> dict[str, PlateTruth]:
    """Force plates below the left and the right belt, from the treadmill's constants ``rig``."""
    right = rig["plate"]
    return {"left": PlateTruth(**right | rig.get("left_plate", {})), "right": PlateTruth(**right)}


def record_log(
    rig: dict,
    seed: int,
    schedule: Schedule,
    loads: dict[str, BeltMotion],
    rng: np.random.Generator,
    files: dict[str, Path],
) -> None:
    """Write the treadmill's log of a motion and the calibration matrix of its plates.

    rig: the treadmill's constants, as the laboratory's configuration holds them.
    seed: seed of the laboratory: every trial has the same plate.
    loads: belt, left or right -> motion and reaction on the grid of the integration (s, m, N, N·m). Two
    belts move alike.
    files: files to write: ``log`` and ``calibration``.
    """
    plates, drive = plates_of(rig), DriveTruth(**rig["drive"])
    plate, motion = plates["right"], next(iter(loads.values()))
    sample = np.arange(0, motion.time.size, round(motion.rate_hz / plate.rate_hz))
    volts_per_newton, matrix = plate_electronics(plate, generator(seed, "plate"))
    loaded = {belt: Loaded(plates[belt], load) for belt, load in loads.items()}
    voltages = voltages_of_belts(loaded, volts_per_newton, sample, rng)
    time = motion.time[sample]
    noisy = motion.belt_velocity[sample] + drive.velocity_noise_m_per_s * rng.standard_normal(sample.size)
    velocity = drive.velocity_step_m_per_s * np.round(noisy / drive.velocity_step_m_per_s)
    running = (time >= schedule.trigger_s) & (time < schedule.trigger_s + schedule.duration_s)
    commanded = schedule.command(time)
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
