"""Gather the comparison of simulations with recordings over all trials."""

import job

job.start(snakemake)

from tepsipe.experiments.forward.scores import read_forward, write_forward

write_forward(snakemake.output.table, [row for path in snakemake.input.forward for row in read_forward(path)])
