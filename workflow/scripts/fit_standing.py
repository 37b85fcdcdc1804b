"""Post-process one trial of a standing person, cut its epochs, and estimate the ankle impedance."""

import job

job.start(snakemake)

from tepsipe.experiments.standing.fit import fit
from tepsipe.io.estimates import CONTRIBUTIONS, ESTIMATES
from tepsipe.io.result import read_result, write_result
from tepsipe.io.trial import read_trial
from tepsipe.treadmill.registry import load_treadmill_models

params, output = snakemake.params, snakemake.output
fitted = fit(
    read_trial(snakemake.input.trial),
    params.section,
    snakemake.wildcards.condition,
    params.seed,
    params.uncertainty,
    [load_treadmill_models(path) for path in snakemake.input.models],
    [read_result(path) for path in snakemake.input.held_out],
)
write_result(output.fit, fitted.result)
write_result(output.responses, fitted.further["responses"])
ESTIMATES.write(output.estimates, fitted.estimates)
CONTRIBUTIONS.write(output.uncertainty, fitted.contributions)
