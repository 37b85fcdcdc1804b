"""Raw file of a position-controlled manipulator to a trial."""

from tepsipe.ingest.limits import Limits, Rig
from tepsipe.ingest.manipulator_options import TableOptions
from tepsipe.ingest.manipulators import ingest_position_manipulator
from tepsipe.ingest.plausibility import plausible_trial
from tepsipe.io.readers.plain_table import DELIMITERS
from tepsipe.io.readers.text_table import read_text_table
from tepsipe.io.trial import Trial


def ingest(
    files: dict[str, str], section: dict, duration_s: float, named_by: dict, limits: Limits, rig: Rig
) -> tuple[Trial, dict]:
    """A plausible trial of the manipulator's table, and the options used."""
    of_files, given = section["files"], named_by["columns"]
    units = {key: of_files[key] for key in ("angle_unit", "torque_sign")}
    options = TableOptions(**units, **section["ingest"])
    columns, delimiter = of_files["columns"], DELIMITERS[of_files["delimiter"]]
    table = read_text_table(files["log"], columns, delimiter, given, options.units)
    trial = ingest_position_manipulator(table, options, duration_s, files["log"])
    used = vars(options) | ({"columns": columns} if given else {})
    return plausible_trial(trial, limits, rig, files), used
