"""One trial with the weight, or with the empty belt: mass, and belt-induced force."""

import job

job.start(snakemake)

from tepsipe.experiments.weight.fit import fit
from tepsipe.io.estimates import CONTRIBUTIONS, ESTIMATES
from tepsipe.io.result import write_result
from tepsipe.io.trial import read_trial

params, output = snakemake.params, snakemake.output
name = f"{snakemake.wildcards.experiment}/{snakemake.wildcards.condition}"
fitted = fit(read_trial(snakemake.input.trial), params.section, name, params.uncertainty)
write_result(output.fit, fitted.result)
ESTIMATES.write(output.estimates, fitted.estimates)
CONTRIBUTIONS.write(output.uncertainty, fitted.contributions)
