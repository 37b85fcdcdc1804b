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
trial = ingest_torque_manipulator(
    read_text_table(files["log"], snakemake.params.log_columns, "\t"),
    read_text_table(files["command"], snakemake.params.command_columns, "\t"),
    options,
    snakemake.params.duration_s,
    files["log"],
    files["command"],
)
trial = plausible_trial(trial, Limits(**snakemake.params.plausible), Rig(), files)
write_trial(
    snakemake.output.trial,
    trial,
    "wristalyzer",
    snakemake.wildcards.condition,
    files,
    vars(options),
)
