"""One trial of the Wristalyzer experiment, from its protocol and the laboratory's truth to raw files."""

from pathlib import Path

import numpy as np

from tepsipe.virtual_lab.manipulator import ManipulatorRecording, ManipulatorTruth, record_manipulator
from tepsipe.virtual_lab.rubber import Rubber
from tepsipe.virtual_lab.seeds import generator
from tepsipe.virtual_lab.truth_file import write_true_motion


def write_dflow_log(path: Path, recording: ManipulatorRecording) -> None:
    """Write the manipulator's log: tab-separated text, stamps in s, angle in rad, torque in N·m.

    ``TriggerTime`` is 0 until the command starts, then the stamp at which it did.
    """
    started = recording.log_time >= recording.trigger_time
    trigger = np.where(started, recording.trigger_time, 0.0)
    lines = ["TimeStamp\tFrameNumber\tMotorAngle\tTriggerTime\n"]
    rows = zip(recording.log_time.tolist(), recording.angle.tolist(), trigger.tolist(), strict=True)
    lines += [f"{t:.6f}\t{k}\t{a:.8f}\t{c:.6f}\n" for k, (t, a, c) in enumerate(rows)]
    path.write_text("".join(lines))


def write_torque_command(path: Path, recording: ManipulatorRecording) -> None:
    """Write the torque command: tab-separated text, time from the trigger in s, torque in N·m."""
    lines = ["Time\tTorqueCommand\n"]
    step = 1.0 / recording.command_rate_hz
    lines += [f"{k * step:.9f}\t{tau:.8f}\n" for k, tau in enumerate(recording.command.tolist())]
    path.write_text("".join(lines))


def make_wristalyzer_trial(
    truth: dict,
    condition: str,
    factor: float,
    duration_s: float,
    log: Path,
    command: Path,
    motion_file: Path | None = None,
) -> None:
    """Make one trial of the Wristalyzer experiment.

    truth: the laboratory's constants, as its configuration file holds them.
    condition: name of the condition: it seeds the trial's noise.
    factor: scale factor of the perturbation.
    duration_s: length of the perturbation.
    log, command: files to write: manipulator log and torque command.
    motion_file: file for the hidden motion of the handle.
    """
    seed = truth["seed"]
    recording = record_manipulator(
        ManipulatorTruth(**truth["wristalyzer"]["manipulator"]),
        Rubber(**truth["dummy"]["rubber"]),
        factor,
        duration_s,
        generator(seed, "wristalyzer", "multisine"),
        generator(seed, "wristalyzer", condition),
    )
    write_dflow_log(log, recording)
    write_torque_command(command, recording)
    if motion_file is not None:
        write_true_motion(motion_file, recording.motion)
