"""Gather the comparison of simulations with recordings over all trials."""

import job

job.start(snakemake)

from tepsipe.experiments.forward.scores import FORWARD_SCORES

FORWARD_SCORES.write(snakemake.output.table, FORWARD_SCORES.read(*snakemake.input.forward))
