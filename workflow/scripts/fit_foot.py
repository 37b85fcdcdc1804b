"""Estimate I, B, K of one trial of the ankle dummy from the torque by the foot and the force plate."""

import job

job.start(snakemake)

from tepsipe.experiments.dummy.fit_foot import fit
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
    read_result(snakemake.input.held_out[0]),
)
write_result(output.fit, fitted.result)
ESTIMATES.write(output.estimates, fitted.estimates)
CONTRIBUTIONS.write(output.uncertainty, fitted.contributions)
