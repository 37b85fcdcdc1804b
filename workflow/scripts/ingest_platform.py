"""Ingest one trial of a person on a moving platform."""

import job

job.start(snakemake)

from tepsipe.ingest.limits import Limits, Rig
from tepsipe.ingest.platform import PlatformTableOptions, ingest_platform
from tepsipe.ingest.plausibility import plausible_trial
from tepsipe.io.readers.plain_table import DELIMITERS
from tepsipe.io.readers.text_table import read_text_table
from tepsipe.io.trial import write_trial

files = dict(snakemake.params.files)
options = PlatformTableOptions(
    angle_unit=snakemake.params.angle_unit,
    torque_sign=snakemake.params.torque_sign,
    platform_unit=snakemake.params.platform_unit,
    **snakemake.params.ingest,
)
delimiter = DELIMITERS[snakemake.params.delimiter]
columns = {key: name for key, name in snakemake.params.columns.items() if name is not None}
table = read_text_table(files["log"], columns, delimiter, snakemake.params.named_by, options.units)
trial = ingest_platform(table, options, snakemake.params.duration_s, files["log"])
trial = plausible_trial(trial, Limits(**snakemake.params.plausible), Rig(), files)
chosen = vars(options) | dict(snakemake.params.named) | {"columns": columns}
write_trial(snakemake.output.trial, trial, "platform", snakemake.wildcards.condition, files, chosen)
