"""Predict what every set of perturbations says about the joints, and estimate the recorded persons."""

import job

job.start(snakemake)

import numpy as np

from tepsipe.experiments.planning.several_joints import (
    MODELS,
    Point,
    epochs_of,
    estimate,
    predict,
    read_draws,
    sets_of,
)
from tepsipe.identification.several_joints.determined import Limits
from tepsipe.io.csv_file import write_records
from tepsipe.mechanics.segment_chain import Chain
from tepsipe.reporting.several_joints import element_rows, model_rows, set_rows

joints = snakemake.params.joints
person, limits = joints["person"], Limits(**joints["limits"])
chain = Chain.from_settings(person)
points = {name: Point.from_settings(one) for name, one in joints["perturbations"].items()}
sets = sets_of(points)
matrices = (np.array(person["stiffness_Nm_per_rad"]), np.array(person["damping_Nms_per_rad"]))
recordings, tolerance = read_draws(snakemake.input.trials), 0.01 * joints["inertia_percent"]
rng, drawn = np.random.default_rng([snakemake.params.seed, 3]), {chosen: [] for chosen in sets}
for recording in recordings:
    # masses and centres of mass are measured with errors, others for every person
    own = epochs_of(recording, chain.drawn(rng, tolerance), points, tolerance=tolerance)
    for chosen in sets:
        drawn[chosen].append(estimate(own, chosen, limits))

# how weights and drives are expected to be, the first recording shows
first = recordings[0]
expected = epochs_of(first, chain, points, tolerance=tolerance)
predictions = predict(expected, sets, matrices, limits)
write_records(snakemake.output.sets, set_rows(predictions, drawn, matrices, limits))
write_records(snakemake.output.elements, element_rows(predictions, drawn, matrices, expected))
cases = {}
for window_s in (joints["protocol"]["after_s"], *joints["windows_s"]):
    cases[window_s] = [
        predict(epochs_of(first, chain, points, model, tolerance, window_s), sets, matrices, limits)
        for model in MODELS
    ]
write_records(snakemake.output.models, model_rows(cases, matrices[0], limits))
