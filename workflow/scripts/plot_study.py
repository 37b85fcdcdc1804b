"""Figures of a study of its own, by the function draw of the module that the rule names."""

import job

job.start(snakemake)

from importlib import import_module

from tepsipe.reporting.figures.style import save_figure

module = import_module(f"tepsipe.reporting.figures.{snakemake.params.module}")
figures = module.draw(dict(snakemake.input.items()), snakemake.params.chosen)
for name, figure in figures.items():
    save_figure(figure, snakemake.output[name], snakemake.output[f"{name}_png"])
