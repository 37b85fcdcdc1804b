"""Fit treadmill models to trials with the empty belt and with the weight, and evaluate them on others."""

import job

job.start(snakemake)

from dataclasses import replace

from model_choices import family_options

from tepsipe.io.result import write_result
from tepsipe.io.trial import read_trial
from tepsipe.signals.filters import Lowpass
from tepsipe.signals.perturbations import WindowOptions
from tepsipe.treadmill.calibration import calibrate, mean_responses, plate_groups, plate_plan, write_scores
from tepsipe.treadmill.registry import save_models
from tepsipe.treadmill.trial_recordings import COMPONENTS, PlateOptions, Weight, plate_recordings

analysis, options = snakemake.params.analysis, family_options(snakemake.params.models)
family = snakemake.params.models["family"]
weight = Weight(**snakemake.params.weight)
window = WindowOptions(**analysis["window"])
trials = [read_trial(path) for path in snakemake.input.trials]
filters = [Lowpass(cutoff, analysis["lowpass_order"], True) for cutoff in analysis["cutoffs_hz"]]
files = {"Fy": snakemake.output.Fy, "Mx": snakemake.output.Mx}
scores = []
for lowpass in filters:
    plate = PlateOptions(snakemake.params.belt, lowpass, filters[0], window, analysis["segment_s"])
    recordings = [
        plate_recordings(
            trial,
            f"{experiment}/{condition}",
            condition,
            plate,
            weight if experiment == "weight" else None,
        )
        for (experiment, condition, _), trial in zip(snakemake.params.trials, trials, strict=True)
    ]
    frame = None
    for load in COMPONENTS:
        labelled = [
            (experiment, role, found[load])
            for (experiment, _, role), found in zip(snakemake.params.trials, recordings, strict=True)
        ]
        training, testing = plate_groups(labelled)
        plan = plate_plan(family, list(testing))
        found, fitted = calibrate(plan, training, testing, load, replace(options, frame=frame))
        scores += found
        frame = next((m.model.frame for m in fitted if m.name == "loaded-frame"), None)
        if lowpass == filters[0]:
            # one model per name: that of the empty belt, which needs no other recording
            kept = [model for model, entry in zip(fitted, plan, strict=True) if entry.train != "weight"]
            save_models(files[load], kept)
            if load == "Fy":
                write_result(snakemake.output.fit, mean_responses(kept, testing["weight"]))
write_scores(snakemake.output.scores, scores)
