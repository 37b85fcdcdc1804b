"""Ingest one trial of an instrumented treadmill whose belt is accelerated."""

import job

job.start(snakemake)

from tepsipe.ingest.belt_table import BeltTableOptions, ingest_belt_table
from tepsipe.ingest.limits import Limits, Rig
from tepsipe.ingest.plausibility import plausible_trial
from tepsipe.io.readers.plain_table import DELIMITERS
from tepsipe.io.readers.text_table import read_text_table
from tepsipe.io.trial import write_trial

files, columns = dict(snakemake.params.files), dict(snakemake.params.columns)
options = BeltTableOptions(load_unit=snakemake.params.load_unit, **snakemake.params.ingest)
delimiter = DELIMITERS[snakemake.params.delimiter]
named_by = {key: f"{key}_column of the trial sheet" for key in columns}
table = read_text_table(files["log"], columns, delimiter, named_by)
trial = ingest_belt_table(table, columns, options, snakemake.params.duration_s, files["log"])
trial = plausible_trial(trial, Limits(**snakemake.params.plausible), Rig(), files)
chosen = vars(options) | {"columns": columns}
write_trial(snakemake.output.trial, trial, "belt", snakemake.wildcards.condition, files, chosen)
