"""Figure of the ankle dummy's parameters from the foot's side, beside those from the leg's."""

import job

job.start(snakemake)

from tepsipe.io.result import Result, read_result
from tepsipe.reporting.figures.dummy import plot_pathways
from tepsipe.reporting.figures.style import save_figure

results = {}
sides = zip(snakemake.params.conditions, snakemake.input.leg, snakemake.input.foot, strict=True)
for name, leg, foot in sides:
    found = [read_result(path) for path in (leg, foot)]
    results[name] = Result({**found[0].arrays, **found[1].arrays}, {}, found[1].facts)
pathways = [snakemake.params.recommended, *found[1].facts["pathways"]]
names = ("recommended", "as printed", "other", "other too", "compensated too", "compensated")
colours = dict(zip(pathways, names, strict=False)) | dict.fromkeys(pathways[len(names) :], "command")
for name, figure in {"figure_foot": plot_pathways(results, colours)}.items():
    save_figure(figure, snakemake.output[name], snakemake.output[f"{name}_png"])
