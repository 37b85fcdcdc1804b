"""Fit one joint with friction and a nonlinear stiffness to all Wristalyzer trials."""

import job

job.start(snakemake)

from tepsipe.experiments.wristalyzer.pooled import fit_together
from tepsipe.io.estimates import CONTRIBUTIONS, ESTIMATES
from tepsipe.io.result import write_result
from tepsipe.io.trial import read_trial
from tepsipe.statistics.uncertainty import sources_of

params, output = snakemake.params, snakemake.output
trials = {c: read_trial(path) for c, path in zip(params.conditions, snakemake.input.trials, strict=True)}
fitted = fit_together(trials, sources_of(params.uncertainty), **params.analysis)
write_result(output.fit, fitted.result)
ESTIMATES.write(output.estimates, fitted.estimates)
CONTRIBUTIONS.write(output.uncertainty, fitted.contributions)
