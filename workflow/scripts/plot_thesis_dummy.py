"""Figure of the inverse problem."""

import job

job.start(snakemake)

from tepsipe.experiments.thesis_dummy.tables import read_cells
from tepsipe.reporting.figures.style import save_figure
from tepsipe.reporting.figures.thesis_dummy import plot_thesis_dummy

figure = plot_thesis_dummy(read_cells(snakemake.input.table))
save_figure(figure, snakemake.output.figure_thesis_dummy, snakemake.output.figure_thesis_dummy_png)
