"""Ingest one trial of the torque-controlled manipulator."""

import job

job.start(snakemake)

from tepsipe.ingest.limits import Limits, Rig
from tepsipe.ingest.manipulators import ManipulatorOptions, ingest_torque_manipulator
from tepsipe.ingest.plausibility import plausible_trial
from tepsipe.io.readers.text_table import read_text_table
from tepsipe.io.trial import write_trial

files = dict(snakemake.params.files)
options = ManipulatorOptions(angle_unit=snakemake.params.angle_unit, **snakemake.params.ingest)
params = snakemake.params
trial = ingest_torque_manipulator(
    read_text_table(files["log"], params.log_columns, "\t", params.log_named_by, options.units),
    read_text_table(files["command"], params.command_columns, "\t", params.command_named_by, options.units),
    options,
    snakemake.params.duration_s,
    files["log"],
    files["command"],
)
trial = plausible_trial(trial, Limits(**params.plausible), Rig(), files)
chosen = vars(options)
if params.log_named_by or params.command_named_by:
    chosen = chosen | {"log_columns": params.log_columns, "command_columns": params.command_columns}
write_trial(snakemake.output.trial, trial, "wristalyzer", snakemake.wildcards.condition, files, chosen)
