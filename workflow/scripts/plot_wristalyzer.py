"""Figures of the Wristalyzer experiment."""

import job

job.start(snakemake)

import numpy as np

from tepsipe.io.result import read_result
from tepsipe.reporting.figures import wristalyzer as figures
from tepsipe.reporting.figures.matrix import plot_matrix
from tepsipe.reporting.figures.style import save_figure

names = list(snakemake.params.conditions)
results = {name: read_result(path) for name, path in zip(names, snakemake.input.fits, strict=True)}
matrix = read_result(snakemake.input.matrix).arrays["vaf"]
best, band = snakemake.params.best, tuple(snakemake.params.fit_band_hz)
vaf = float(np.diag(matrix)[names.index(best)])
axes = ("Parameters from scale factor", "Data of scale factor")
drawn = {
    "figure_2_4": figures.plot_perturbation(results),
    "figure_3_1": figures.plot_spectral_estimate(results[best], best, band),
    "figure_4_1": figures.plot_admittance_fit(results[best], best, band),
    "figure_4_2": figures.plot_prediction(results[best], best, vaf),
    "figure_4_3": plot_matrix(matrix, names, "VAF (%)", axes),
    "figure_starting_values": figures.plot_starting_values(results, snakemake.params.start_stiffness),
    "figure_averaging": figures.plot_averaging(results[best], best, band),
}
for name, figure in drawn.items():
    save_figure(figure, snakemake.output[name], snakemake.output[f"{name}_png"])
