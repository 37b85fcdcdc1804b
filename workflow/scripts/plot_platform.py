"""Figures of a person on a moving platform."""

import job

job.start(snakemake)

from tepsipe.io.estimates import ESTIMATES
from tepsipe.io.result import read_result
from tepsipe.reporting.figures import platform as figures
from tepsipe.reporting.figures.style import save_figure

conditions = snakemake.params.conditions
results = {c: read_result(path) for c, path in zip(conditions, snakemake.input.fits, strict=True)}
estimates = {c: ESTIMATES.read(path) for c, path in zip(conditions, snakemake.input.estimates, strict=True)}
drawn = {
    "figure_platform_responses": figures.plot_responses(results),
    "figure_platform_quantities": figures.plot_quantities(results, estimates),
    "figure_platform_prediction": figures.plot_prediction(results),
}
for name, figure in drawn.items():
    save_figure(figure, snakemake.output[name], snakemake.output[f"{name}_png"])
