"""Figures of the position-controlled manipulator."""

import job

job.start(snakemake)

from tepsipe.figures import ankle_figures as figures
from tepsipe.figures.style import save_figure
from tepsipe.result_file import read_result

results = {
    name: read_result(path)
    for name, path in zip(snakemake.params.conditions, snakemake.input.fits, strict=True)
}
drawn = {
    "figure_ankle_impedance": figures.plot_impedance(results),
    "figure_ankle_prediction": figures.plot_held_out(results),
    "figure_ankle_responses": figures.plot_responses(results),
}
for name, figure in drawn.items():
    save_figure(figure, snakemake.output[name], snakemake.output[f"{name}_png"])
