"""Raw file of a person on a moving platform to a trial."""

from tepsipe.ingest.limits import Limits, Rig
from tepsipe.ingest.manipulator_options import PlatformTableOptions
from tepsipe.ingest.platform import ingest_platform
from tepsipe.ingest.plausibility import plausible_trial
from tepsipe.io.readers.plain_table import DELIMITERS
from tepsipe.io.readers.text_table import read_text_table
from tepsipe.io.trial import Trial


def ingest(
    files: dict[str, str], section: dict, duration_s: float, named_by: dict, limits: Limits, rig: Rig
) -> tuple[Trial, dict]:
    """A plausible trial of the platform's table, and the options used."""
    of_files = section["files"]
    units = {key: of_files[key] for key in ("angle_unit", "torque_sign", "platform_unit")}
    options = PlatformTableOptions(**units, **section["ingest"])
    columns = {key: name for key, name in of_files["columns"].items() if name is not None}
    delimiter = DELIMITERS[of_files["delimiter"]]
    table = read_text_table(files["log"], columns, delimiter, named_by["columns"], options.units)
    trial = ingest_platform(table, options, duration_s, files["log"])
    return plausible_trial(trial, limits, rig, files), vars(options) | {"columns": columns}
