"""Estimate ankle impedance and muscle latencies from all trials of one task together."""

import job

job.start(snakemake)

from tepsipe.experiments.standing.fit_task import fit
from tepsipe.io.estimates import CONTRIBUTIONS, ESTIMATES
from tepsipe.io.result import read_result, write_result

params, output = snakemake.params, snakemake.output
responses = [read_result(path) for path in snakemake.input.responses]
others = [read_result(path) for path in snakemake.input.others]
fitted = fit(responses, params.section, snakemake.wildcards.task, params.seed, params.uncertainty, others)
write_result(output.fit, fitted.result)
ESTIMATES.write(output.estimates, fitted.estimates)
CONTRIBUTIONS.write(output.uncertainty, fitted.contributions)
