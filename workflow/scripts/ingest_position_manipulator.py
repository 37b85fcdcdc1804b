"""Ingest one trial of a position-controlled manipulator."""

import job

job.start(snakemake)

from tepsipe.ingest.limits import Limits, Rig
from tepsipe.ingest.manipulators import TableOptions, ingest_position_manipulator
from tepsipe.ingest.plausibility import plausible_trial
from tepsipe.io.readers.plain_table import DELIMITERS
from tepsipe.io.readers.text_table import read_text_table
from tepsipe.io.trial import write_trial

files = dict(snakemake.params.files)
options = TableOptions(
    angle_unit=snakemake.params.angle_unit,
    torque_sign=snakemake.params.torque_sign,
    **snakemake.params.ingest,
)
delimiter = DELIMITERS[snakemake.params.delimiter]
columns, named_by = snakemake.params.columns, snakemake.params.named_by
table = read_text_table(files["log"], columns, delimiter, named_by, options.units)
trial = ingest_position_manipulator(table, options, snakemake.params.duration_s, files["log"])
trial = plausible_trial(trial, Limits(**snakemake.params.plausible), Rig(), files)
chosen = vars(options) | dict(snakemake.params.named) | ({"columns": columns} if named_by else {})
write_trial(
    snakemake.output.trial, trial, "position_manipulator", snakemake.wildcards.condition, files, chosen
)
