"""Figures of an experiment or a part, drawn by a function of a module of figures."""

import job

job.start(snakemake)

import json
from importlib import import_module
from pathlib import Path

import typst

from tepsipe.drawing.style import HEADER, Drawing, save_figure, save_png, write_drawn


def save_drawing(name, drawing, svg):
    """Typeset a drawing, a function of its source, as SVG."""
    source = Path(drawing.source)
    main = f'#import "/{source.name}": {name}, drawing\n#show: drawing\n#{name}(json(bytes(sys.inputs.run)))'
    run = {"run": json.dumps(drawing.shown)}
    typst.compile(main.encode(), svg, str(source.parent), ignore_system_fonts=True, sys_inputs=run)


module, function = snakemake.params.drawn_by.split(":")
draw = getattr(import_module(f"tepsipe.{module}"), function)
for name, figure in draw(snakemake.input, snakemake.params):
    svg = snakemake.output.get(name)
    if isinstance(figure, Drawing):
        save_drawing(name, figure, svg)
        Path(snakemake.output[f"{name}_csv"]).write_text(HEADER, encoding="utf-8", newline="\n")
    elif svg:
        save_figure(figure, svg)
        write_drawn(figure, snakemake.output[f"{name}_csv"])
    else:
        save_png(figure, snakemake.output[f"{name}_png"])
