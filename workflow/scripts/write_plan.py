"""Draw and typeset the report on planned experiments and on filters."""

import job

job.start(snakemake)

import json
from pathlib import Path

import pandas as pd
from typeset import source_files, typeset

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

files = source_files(snakemake.input.source, snakemake.params.source_folder) | {
    "needed.svg": snakemake.output.needed,
    "pulses.svg": snakemake.output.pulses,
    "filters.svg": snakemake.output.filters,
    "treadmill_filters.svg": snakemake.output.treadmill_filters,
    "several_joints.svg": snakemake.output.joints,
    "report.json": snakemake.output.data,
}
typeset(files, "plan.typ", snakemake.output.pdf)
