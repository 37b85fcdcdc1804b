"""One trial of the Wristalyzer experiment, from its protocol and the laboratory's truth to raw files."""

from pathlib import Path

from tepsipe.virtual_lab.manipulator import ManipulatorTruth, record_manipulator
from tepsipe.virtual_lab.manipulator_files import write_dflow_log, write_torque_command
from tepsipe.virtual_lab.rubber import Rubber
from tepsipe.virtual_lab.seeds import generator
from tepsipe.virtual_lab.truth_file import write_true_motion


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

    Parameters
    ----------
    truth : dict
        The laboratory's constants, as its configuration file holds them (units in the keys).
    condition : str
        Name of the condition: it seeds the trial's noise.
    factor : float
        Scale factor of the perturbation (-).
    duration_s : float
        Length of the perturbation (s).
    log, command : Path
        Files to write: manipulator log and torque command.
    motion_file : Path, optional
        File for the hidden motion of the handle (s, rad, N·m).
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
