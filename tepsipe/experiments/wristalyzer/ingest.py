"""Raw files of a torque-controlled manipulator to a trial."""

from tepsipe.ingest.limits import Limits, Rig
from tepsipe.ingest.manipulator_options import ManipulatorOptions
from tepsipe.ingest.manipulators import ingest_torque_manipulator
from tepsipe.ingest.plausibility import plausible_trial
from tepsipe.io.readers.text_table import read_text_table
from tepsipe.io.trial import Trial


def ingest(
    files: dict[str, str], section: dict, duration_s: float, named_by: dict, limits: Limits, rig: Rig
) -> tuple[Trial, dict]:
    """A plausible trial of the manipulator's log and its command, and the options used."""
    of_files = section["files"]
    options = ManipulatorOptions(angle_unit=of_files["angle_unit"], **section["ingest"])
    log, command = (
        read_text_table(files[kind], of_files[columns], "\t", named_by[columns], options.units)
        for kind, columns in (("log", "log_columns"), ("command", "command_columns"))
    )
    trial = ingest_torque_manipulator(log, command, options, duration_s, files["log"], files["command"])
    used = vars(options)
    if any(named_by.values()):
        used = used | {columns: of_files[columns] for columns in ("log_columns", "command_columns")}
    return plausible_trial(trial, limits, rig, files), used
