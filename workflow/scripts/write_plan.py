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
from tepsipe.reporting.figures.several_joints import plot_several_joints
from tepsipe.reporting.figures.style import save_figure
from tepsipe.reporting.numbers.planning import plan_data
from tepsipe.reporting.numbers.several_joints import joints_data

plan, pulses, shapes, filters = (
    pd.read_csv(path)
    for path in (
        snakemake.input.plan,
        snakemake.input.pulses,
        snakemake.input.shapes,
        snakemake.input.filters,
    )
)
save_figure(plot_needed(plan), snakemake.output.needed, snakemake.output.needed_png)
save_figure(plot_pulses(shapes), snakemake.output.pulses, snakemake.output.pulses_png)
save_figure(plot_filters(filters), snakemake.output.filters, snakemake.output.filters_png)
save_figure(
    plot_treadmill_filters(filters),
    snakemake.output.treadmill_filters,
    snakemake.output.treadmill_filters_png,
)
several, elements, models = (
    pd.read_csv(path)
    for path in (snakemake.input.joints, snakemake.input.joint_elements, snakemake.input.joint_models)
)
settings = snakemake.params.plan["several_joints"]
limit_percent = settings["limits"]["stiffness_percent"]
save_figure(
    plot_several_joints(several, elements, limit_percent),
    snakemake.output.joints,
    snakemake.output.joints_png,
)
about = {
    "title": snakemake.params.title,
    "settings": snakemake.params.plan,
    "code": snakemake.params.code,
}
data = plan_data(plan, pulses, filters, about)
data["joints"] = joints_data(several, elements, models, settings)
Path(snakemake.output.data).write_text(
    json.dumps(data, indent=1, ensure_ascii=False) + "\n", encoding="utf-8"
)

# Typst reads below one root only
with tempfile.TemporaryDirectory() as folder:
    root = Path(folder)
    for name in ("plan.typ", "several_joints.typ", "style.typ"):
        shutil.copyfile(Path(snakemake.params.source_folder) / name, root / name)
    shutil.copyfile(snakemake.output.needed, root / "needed.svg")
    shutil.copyfile(snakemake.output.pulses, root / "pulses.svg")
    shutil.copyfile(snakemake.output.filters, root / "filters.svg")
    shutil.copyfile(snakemake.output.treadmill_filters, root / "treadmill_filters.svg")
    shutil.copyfile(snakemake.output.joints, root / "several_joints.svg")
    shutil.copyfile(snakemake.output.data, root / "report.json")
    typst.compile(
        str(root / "plan.typ"),
        output=snakemake.output.pdf,
        root=str(root),
        ignore_system_fonts=True,
        timestamp=0,
        pdf_standards="a-2b",
    )
