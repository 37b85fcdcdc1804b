"""Figures of an experiment or a part, drawn by a module of tepsipe/reporting/figures."""

import job

job.start(snakemake)

from importlib import import_module

from tepsipe.reporting.figures.drawn import write_drawn
from tepsipe.reporting.figures.style import save_figure, save_png

module = import_module(f"tepsipe.reporting.figures.{snakemake.params.drawn_by}")
for name, figure in module.draw(snakemake.input, snakemake.params):
    svg, png = snakemake.output.get(name), snakemake.output[f"{name}_png"]
    if svg:
        save_figure(figure, svg, png)
        write_drawn(figure, snakemake.output[f"{name}_csv"])
    else:
        save_png(figure, png)
