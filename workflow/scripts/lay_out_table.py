"""Arrange one of the thesis's tables, each value beside the reported one."""

import job

job.start(snakemake)

from pathlib import Path

import yaml

from tepsipe.io.estimates import read_estimates
from tepsipe.reporting.thesis_tables import lay_out_table, write_table

name, conditions = snakemake.wildcards.table, list(snakemake.params.conditions)
reported = {}
if snakemake.input.reported:
    content = yaml.safe_load(Path(snakemake.input.reported).read_text(encoding="utf-8"))
    reported = content["tables"].get(name, {})
rows = lay_out_table(
    name,
    read_estimates(snakemake.input.estimates),
    reported,
    conditions,
    [tuple(snakemake.params.as_printed), tuple(snakemake.params.recommended)],
)
write_table(snakemake.output.table, rows, conditions)
