"""Figure of the impedance against the operating point."""

import job

job.start(snakemake)

import pandas as pd

from tepsipe.reporting.figures.operating_points import plot_operating_points
from tepsipe.reporting.figures.style import save_figure

text = {"participant": str, "condition": str}
points, relations = (
    pd.read_csv(path, dtype=text, keep_default_na=False, na_values=[""])
    for path in (snakemake.input.points, snakemake.input.relations)
)
drawn = {"figure_operating_points": plot_operating_points(points, relations)}
for name, figure in drawn.items():
    save_figure(figure, snakemake.output[name], snakemake.output[f"{name}_png"])
