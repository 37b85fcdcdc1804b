"""Figure of the impedance that changes within trials."""

import job

job.start(snakemake)

from tepsipe.experiments.position_manipulator.time_varying import VARYING_ROWS
from tepsipe.reporting.figures.style import save_figure
from tepsipe.reporting.figures.time_varying import plot_time_varying

drawn = {"figure_time_varying": plot_time_varying(VARYING_ROWS.read(snakemake.input.table))}
for name, figure in drawn.items():
    save_figure(figure, snakemake.output[name], snakemake.output[f"{name}_png"])
