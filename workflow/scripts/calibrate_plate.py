"""Fit treadmill models to trials with the empty belt and with weights, and evaluate them on others."""

import job

job.start(snakemake)

from tepsipe.experiments.weight.calibrate import PlateTrial, calibrate_plate
from tepsipe.io.result import write_result
from tepsipe.io.trial import read_trial
from tepsipe.treadmill.calibration import MODEL_SCORES
from tepsipe.treadmill.options import Weight
from tepsipe.treadmill.registry import save_models

params, output = snakemake.params, snakemake.output
weights = [None if weight is None else Weight(**weight) for weight in params.weights]
found = calibrate_plate(
    [
        PlateTrial(*labels, weight, read_trial(path))
        for labels, weight, path in zip(params.trials, weights, snakemake.input.trials, strict=True)
    ],
    snakemake.wildcards.plate,
    params.belt,
    params.usual_kg,
    params.analysis,
    params.models,
    params.seed,
)
save_models(output.Fy, found.models["Fy"])
save_models(output.Mx, found.models["Mx"])
write_result(output.fit, found.responses)
write_result(output.held_out, found.held_out)
MODEL_SCORES.write(output.scores, found.scores)
