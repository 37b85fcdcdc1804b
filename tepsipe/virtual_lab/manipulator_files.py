"""Write the files that the manipulator's computers would have written."""

from pathlib import Path

import numpy as np

from tepsipe.virtual_lab.manipulator import ManipulatorRecording


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
