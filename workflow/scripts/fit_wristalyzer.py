"""Estimate the joint's admittance and fit I, B, K to one Wristalyzer trial."""

import job

job.start(snakemake)

from tepsipe.experiments.wristalyzer.fit import fit
from tepsipe.io.estimates import CONTRIBUTIONS, ESTIMATES
from tepsipe.io.result import write_result
from tepsipe.io.trial import read_trial

params, output = snakemake.params, snakemake.output
trial, condition = read_trial(snakemake.input.trial), snakemake.wildcards.condition
fitted = fit(trial, params.section, condition, params.seed, params.uncertainty)
write_result(output.fit, fitted.result)
ESTIMATES.write(output.estimates, fitted.estimates)
CONTRIBUTIONS.write(output.uncertainty, fitted.contributions)
