"""Figures 4-13 and 4-14 of one trial of the standing person."""

import job

job.start(snakemake)

from tepsipe.figures import pilot_figures as figures
from tepsipe.figures.style import save_png
from tepsipe.result_file import read_result

result = read_result(snakemake.input.responses)
save_png(figures.plot_processed(result), snakemake.output.figure_4_13)
save_png(figures.plot_activity(result), snakemake.output.figure_4_14)
