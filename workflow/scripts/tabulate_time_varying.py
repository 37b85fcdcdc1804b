"""Impedance that changes, of all trials in one table."""

import job

job.start(snakemake)

from tepsipe.experiments.position_manipulator.time_varying import read_varying, write_varying

rows = [row for path in snakemake.input.rows for row in read_varying(path)]
write_varying(snakemake.output.table, rows)
