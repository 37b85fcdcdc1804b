"""Figures of the position-controlled manipulator."""

import job

job.start(snakemake)

from tepsipe.io.result import read_result
from tepsipe.reporting.figures import position_manipulator as figures
from tepsipe.reporting.figures.style import save_figure

results = {
    name: read_result(path)
    for name, path in zip(snakemake.params.conditions, snakemake.input.fits, strict=True)
}
drawn = {
    "figure_position_manipulator_impedance": figures.plot_impedance(results),
    "figure_position_manipulator_prediction": figures.plot_held_out(results),
    "figure_position_manipulator_responses": figures.plot_responses(results),
    "figure_position_manipulator_stationarity": figures.plot_stationarity(results),
    "figure_position_manipulator_residual": figures.plot_residual(results),
}
for name, figure in drawn.items():
    save_figure(figure, snakemake.output[name], snakemake.output[f"{name}_png"])
