"""Raw file of an instrumented treadmill whose belt is accelerated to a trial."""

from tepsipe.ingest.belt_table import BeltTableOptions, ingest_belt_table
from tepsipe.ingest.limits import Limits, Rig
from tepsipe.ingest.plausibility import plausible_trial
from tepsipe.io.readers.plain_table import DELIMITERS
from tepsipe.io.readers.text_table import read_text_table
from tepsipe.io.trial import Trial


def ingest(
    files: dict[str, str], section: dict, duration_s: float, named_by: dict, limits: Limits, rig: Rig
) -> tuple[Trial, dict]:
    """A plausible trial of the treadmill's table, and the options used."""
    of_files = section["files"]
    options = BeltTableOptions(load_unit=of_files["load_unit"], **section["ingest"])
    columns, delimiter = of_files["columns"], DELIMITERS[of_files["delimiter"]]
    table = read_text_table(files["log"], columns, delimiter, named_by["columns"])
    trial = ingest_belt_table(table, columns, options, duration_s, files["log"])
    return plausible_trial(trial, limits, rig, files), vars(options) | {"columns": columns}
