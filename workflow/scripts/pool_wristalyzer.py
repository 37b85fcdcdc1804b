"""Fit one joint with friction and a nonlinear stiffness to all Wristalyzer trials."""

import job

job.start(snakemake)

from tepsipe.experiments.wristalyzer.pooled import fit_wristalyzer_together, pooled_estimates, pooled_result
from tepsipe.io.estimates import CONTRIBUTIONS, ESTIMATES
from tepsipe.io.result import write_result
from tepsipe.io.trial import read_trial
from tepsipe.statistics.uncertainty import sources_of

params = snakemake.params
trials = [read_trial(path) for path in snakemake.input.trials]
found, flags = fit_wristalyzer_together(trials, **params.analysis)
write_result(snakemake.output.fit, pooled_result(list(params.conditions), found))
rows, contributions = pooled_estimates(found, sources_of(params.uncertainty), flags)
ESTIMATES.write(snakemake.output.estimates, rows)
CONTRIBUTIONS.write(snakemake.output.uncertainty, contributions)
