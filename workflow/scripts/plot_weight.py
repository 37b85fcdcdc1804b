"""Figures of the weight experiment and of the treadmill's models."""

import job

job.start(snakemake)

from tepsipe.io.result import read_result
from tepsipe.reporting.figures import weight as figures
from tepsipe.reporting.figures.style import save_figure
from tepsipe.treadmill.calibration import MODEL_SCORES

by_experiment = (
    (snakemake.params.weight, snakemake.input.weight),
    (snakemake.params.empty, snakemake.input.empty),
)
weight, empty = (
    {name: read_result(path) for name, path in zip(names, paths, strict=True)}
    for names, paths in by_experiment
)
plate, scores = read_result(snakemake.input.plate), MODEL_SCORES.read(snakemake.input.scores)
first_hz, last_hz = snakemake.params.cutoffs_hz[0], snakemake.params.cutoffs_hz[-1]
drawn = {
    "figure_4_5": figures.plot_added_forces(empty, weight, f"{first_hz:g} Hz", list(weight)),
    "figure_4_6": figures.plot_masses(weight, snakemake.params.mass_kg),
    "figure_5_1": figures.plot_added_forces(empty, weight, f"{last_hz:g} Hz", list(snakemake.params.coarse)),
    "figure_plate_models": figures.plot_model_scores(scores, "Fy", first_hz),
    "figure_plate_responses": figures.plot_model_responses(
        plate, snakemake.params.example, plate.facts["models"]
    ),
}
for name, figure in drawn.items():
    save_figure(figure, snakemake.output[name], snakemake.output[f"{name}_png"])
