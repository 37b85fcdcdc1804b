"""Estimate impedance, I, B, K of one trial in the position-controlled manipulator."""

import job

job.start(snakemake)

from tepsipe.experiments.position_manipulator.fit import fit
from tepsipe.io.estimates import ESTIMATES
from tepsipe.io.result import write_result
from tepsipe.io.trial import read_trial

trial, condition = read_trial(snakemake.input.trial), snakemake.wildcards.condition
fitted = fit(trial, snakemake.params.section, condition, snakemake.params.seed)
write_result(snakemake.output.fit, fitted.result)
ESTIMATES.write(snakemake.output.estimates, fitted.estimates)
