"""Figures of a treadmill's calibration."""

import job

job.start(snakemake)

from tepsipe.io.result import read_result
from tepsipe.reporting.figures import treadmill as figures
from tepsipe.reporting.figures.style import save_figure
from tepsipe.treadmill.calibration import MODEL_SCORES

result, scores = read_result(snakemake.input.fit), MODEL_SCORES.read(snakemake.input.scores)
drawn = {
    "figure_belt_prediction": figures.plot_calibration(result, scores, snakemake.params.chosen),
    "figure_belt_cutoff": figures.plot_cutoffs(scores, result.facts["recordings"][0]),
    "figure_belt_ripple": figures.plot_ripple(result),
}
for name, figure in drawn.items():
    save_figure(figure, snakemake.output[name], snakemake.output[f"{name}_png"])
