"""Figure of the inverse problem."""

import job

job.start(snakemake)

from tepsipe.experiments.thesis_dummy.tables import CELL_ROWS
from tepsipe.reporting.figures.style import save_figure
from tepsipe.reporting.figures.thesis_dummy import plot_thesis_dummy

drawn = {"figure_thesis_dummy": plot_thesis_dummy(CELL_ROWS.read(snakemake.input.table))}
for name, figure in drawn.items():
    save_figure(figure, snakemake.output[name], snakemake.output[f"{name}_png"])
