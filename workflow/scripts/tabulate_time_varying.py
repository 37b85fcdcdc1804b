"""Impedance that changes, of all trials in one table."""

import job

job.start(snakemake)

from tepsipe.experiments.position_manipulator.time_varying import VARYING_ROWS

rows = VARYING_ROWS.read(*snakemake.input.rows)
VARYING_ROWS.write(snakemake.output.table, rows)
