"""Impedance of ankle and hip of one person on a moving platform."""

import job

job.start(snakemake)

from tepsipe.experiments.platform.fit import fit
from tepsipe.io.estimates import ESTIMATES
from tepsipe.io.result import write_result
from tepsipe.io.trial import read_trial

trial, condition = read_trial(snakemake.input.trial), snakemake.wildcards.condition
fitted = fit(trial, snakemake.params.section, condition)
write_result(snakemake.output.fit, fitted.result)
ESTIMATES.write(snakemake.output.estimates, fitted.estimates)
