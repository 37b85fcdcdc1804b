"""Figures of an experiment or a part, drawn by a module of tepsipe/reporting/figures."""

import job

job.start(snakemake)

import json
from importlib import import_module
from pathlib import Path

import typst

from tepsipe.reporting.figures.figure_numbers import HEADER, write_drawn
from tepsipe.reporting.figures.style import Drawing, save_figure, save_png


def save_drawing(name, drawing, svg, png):
    """Typeset a drawing, a function of its source, as SVG and PNG."""
    source = Path(drawing.source)
    main = f'#import "/{source.name}": {name}, drawing\n#show: drawing\n#{name}(json(bytes(sys.inputs.run)))'
    run = {"run": json.dumps(drawing.shown)}
    for path, ppi in ((svg, None), (png, 150.0)):
        typst.compile(
            main.encode(), path, str(source.parent), ignore_system_fonts=True, ppi=ppi, sys_inputs=run
        )


module = import_module(f"tepsipe.reporting.figures.{snakemake.params.drawn_by}")
for name, figure in module.draw(snakemake.input, snakemake.params):
    svg, png = snakemake.output.get(name), snakemake.output[f"{name}_png"]
    if isinstance(figure, Drawing):
        save_drawing(name, figure, svg, png)
        Path(snakemake.output[f"{name}_csv"]).write_text(HEADER, encoding="utf-8", newline="\n")
    elif svg:
        save_figure(figure, svg, png)
        write_drawn(figure, snakemake.output[f"{name}_csv"])
    else:
        save_png(figure, png)
