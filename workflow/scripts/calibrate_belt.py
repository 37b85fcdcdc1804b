"""Fit treadmill models to recordings with the role calibrate, and evaluate them on those to validate."""

import job

job.start(snakemake)

from tepsipe.experiments.belt.fit import fit
from tepsipe.io.result import write_result
from tepsipe.io.trial import read_trial
from tepsipe.treadmill.calibration import MODEL_SCORES
from tepsipe.treadmill.registry import save_models

params, output, roles = snakemake.params, snakemake.output, dict(snakemake.params.roles)
trials = {name: read_trial(path) for name, path in zip(roles, snakemake.input.trials, strict=True)}
found = fit(trials, params.section, roles)
save_models(output.models, found.models)
write_result(output.fit, found.result)
MODEL_SCORES.write(output.scores, found.scores)
