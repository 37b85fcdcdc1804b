"""Figures 4-13 and 4-14 of every trial of the standing person."""

import job

job.start(snakemake)

from tepsipe.io.result import read_result
from tepsipe.reporting.figures import standing as figures
from tepsipe.reporting.figures.style import save_png

drawn = (snakemake.output.figures_4_13, snakemake.output.figures_4_14)
for path, processed, activity in zip(snakemake.input.responses, *drawn, strict=True):
    result = read_result(path)
    save_png(figures.plot_processed(result), processed)
    save_png(figures.plot_activity(result), activity)
