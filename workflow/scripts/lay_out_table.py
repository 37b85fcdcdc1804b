"""Arrange one of the thesis's tables, each value beside the reported one."""

import job

job.start(snakemake)

from tepsipe.io.estimates import ESTIMATES
from tepsipe.io.result import read_result
from tepsipe.reporting.thesis_tables import lay_out_table, write_table

conditions = list(snakemake.params.conditions)
rows = lay_out_table(
    snakemake.wildcards.table,
    ESTIMATES.read(*snakemake.input.estimates),
    snakemake.params.reported,
    conditions,
    [tuple(pathway) for pathway in snakemake.params.pathways],
    dict(zip(conditions, map(read_result, snakemake.input.fits), strict=False)),
)
write_table(snakemake.output.table, rows, conditions)
