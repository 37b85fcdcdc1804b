"""Draw and typeset the report on planned experiments and on filters."""

import job

job.start(snakemake)

import json
import shutil
import tempfile
from pathlib import Path

import pandas as pd
import typst

from tepsipe.reporting.figures.planning import plot_filters, plot_needed, plot_pulses, plot_treadmill_filters
from tepsipe.reporting.figures.style import save_figure
from tepsipe.reporting.numbers.planning import plan_data

plan, pulses, shapes, filters = (
    pd.read_csv(snakemake.input[name]) for name in ("plan", "pulses", "shapes", "filters")
)
figures = {
    "needed": plot_needed(plan),
    "pulses": plot_pulses(shapes),
    "filters": plot_filters(filters),
    "treadmill_filters": plot_treadmill_filters(filters),
}
for name, figure in figures.items():
    save_figure(figure, snakemake.output[name], snakemake.output[f"{name}_png"])
about = {
    "title": snakemake.params.title,
    "settings": snakemake.params.plan,
    "code": snakemake.params.code,
}
data = plan_data(plan, pulses, filters, about)
Path(snakemake.output.data).write_text(
    json.dumps(data, indent=1, ensure_ascii=False) + "\n", encoding="utf-8"
)

# Typst reads below one root only
with tempfile.TemporaryDirectory() as folder:
    root = Path(folder)
    for name in ("plan.typ", "style.typ"):
        shutil.copyfile(Path(snakemake.params.source_folder) / name, root / name)
    for name in figures:
        shutil.copyfile(snakemake.output[name], root / f"{name}.svg")
    shutil.copyfile(snakemake.output.data, root / "report.json")
    typst.compile(
        str(root / "plan.typ"),
        output=snakemake.output.pdf,
        root=str(root),
        ignore_system_fonts=True,
        timestamp=0,
        pdf_standards="a-2b",
    )
