"""Fit treadmill models to trials with the empty belt and with weights, and evaluate them on others."""

import job

job.start(snakemake)

from dataclasses import replace

import numpy as np

from tepsipe.io.result import write_result
from tepsipe.io.trial import read_trial
from tepsipe.signals.filters import Lowpass
from tepsipe.signals.perturbations import WindowOptions
from tepsipe.treadmill.bristle_fit import fit_bristle_frame
from tepsipe.treadmill.calibration import (
    MODEL_SCORES,
    calibrate,
    group_of,
    mean_responses,
    plate_groups,
    plate_plan,
)
from tepsipe.treadmill.held_out import below_limit, held_out_residuals
from tepsipe.treadmill.plate_check import check_plate, resting
from tepsipe.treadmill.prepared import prepare_trial
from tepsipe.treadmill.registry import FamilyOptions, save_models
from tepsipe.treadmill.trial_recordings import (
    COMPONENTS,
    PlateOptions,
    Weight,
    plate_recordings,
    zeroed_per_pulse,
)

analysis, models = snakemake.params.analysis, dict(snakemake.params.models)
family, draws = models.pop("family"), models.pop("calibration_draws")
options = FamilyOptions(**models)
window = WindowOptions(**analysis["window"])
filters = [Lowpass(cutoff, analysis["lowpass_order"], True) for cutoff in analysis["cutoffs_hz"]]
files = {"Fy": snakemake.output.Fy, "Mx": snakemake.output.Mx}
weights = [None if weight is None else Weight(**weight) for weight in snakemake.params.weights]
usual_kg = snakemake.params.usual_kg
rows = list(zip(snakemake.params.trials, weights, map(read_trial, snakemake.input.trials), strict=True))
check = check_plate(
    [
        resting(prepare_trial(trial, f"{e}/{c}", filters[0], window), snakemake.params.belt, weight)
        for (e, c, _), weight, trial in rows
    ],
    snakemake.wildcards.plate,
)
rows = [(labels, weight, check.corrected(trial, snakemake.params.belt)) for labels, weight, trial in rows]
scores, joint = [], None
for lowpass in filters:
    plate = PlateOptions(snakemake.params.belt, lowpass, filters[0], window, analysis["segment_s"])
    recordings, labels = [], []
    for (experiment, condition, role), weight, trial in rows:
        found = plate_recordings(trial, f"{experiment}/{condition}", condition, plate, weight)
        recordings.append({load: zeroed_per_pulse(r) for load, r in found.items()})
        labels.append((group_of(experiment, recordings[-1]["Fy"].carried_kg, usual_kg), role))
    by_role = {
        role: [r for r, (_, own) in zip(recordings, labels, strict=True) if own == role]
        for role in ("calibrate", "validate")
    }
    if "bristle-frame" in family:
        generator = np.random.default_rng(snakemake.params.seed)
        joint = fit_bristle_frame(by_role["calibrate"], draws, generator, joint)
    frame, below = None, set()
    for load in COMPONENTS:
        training, testing = plate_groups(
            [(*label, found[load]) for label, found in zip(labels, recordings, strict=True)]
        )
        plan = plate_plan(family, list(testing))
        found, fitted = calibrate(plan, training, testing, load, replace(options, frame=frame, joint=joint))
        scores += found
        below |= {
            testing[s.test][0].carried_kg
            for s in found
            if s.model == "bristle-frame" and below_limit(s.r2, s.r2_limit)
        }
        frame = next((m.model.frame for m in fitted if m.name == "loaded-frame"), None)
        if lowpass == filters[0]:
            # one model per name: that of the empty belt, which needs no other recording
            kept = [model for model, entry in zip(fitted, plan, strict=True) if entry.train != "weight"]
            save_models(files[load], kept)
            if load == "Fy":
                write_result(snakemake.output.fit, mean_responses(kept, testing["weight"]))
    if lowpass == filters[0]:
        left = held_out_residuals(joint, by_role["calibrate"], by_role["validate"], sorted(below))
        left.facts["plate"] = check.facts
        write_result(snakemake.output.held_out, left)
MODEL_SCORES.write(snakemake.output.scores, scores)
