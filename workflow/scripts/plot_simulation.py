"""Figures of the forward simulations."""

import job

job.start(snakemake)

from tepsipe.experiments.forward.scores import FORWARD_SCORES
from tepsipe.io.result import read_result
from tepsipe.reporting.figures import simulation as figures
from tepsipe.reporting.figures.style import save_figure

names = list(snakemake.params.conditions)
results = {name: read_result(path) for name, path in zip(names, snakemake.input.fits, strict=True)}
scores = FORWARD_SCORES.read(snakemake.input.forward)
frequent, rare = snakemake.params.frequent, snakemake.params.rare
drawn = {
    "figure_4_7": figures.plot_angles(results[frequent]),
    "figure_4_8": figures.plot_angles(results[rare]),
    "figure_4_9": figures.plot_torques(results[frequent]),
    "figure_4_10": figures.plot_scores(scores, names, "vaf_perturbation"),
    "figure_4_11": figures.plot_scores(scores, names, "vaf_trial"),
    "figure_b": figures.plot_all_angles(results),
    "figure_b_13": figures.plot_all_torques(results),
}
# Figures B-1 to B-12, and no more: the thesis's B-13 is another one
drawn |= {
    f"figure_b_{number}": figures.plot_angles(result)
    for number, result in enumerate(list(results.values())[:12], start=1)
}
for name, figure in drawn.items():
    save_figure(figure, snakemake.output[name], snakemake.output[f"{name}_png"])
