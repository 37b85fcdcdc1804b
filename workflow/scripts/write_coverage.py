"""Draw and typeset the report on the coverage."""

import job

job.start(snakemake)

import json
from pathlib import Path

import pandas as pd
from typeset import source_files, typeset

from tepsipe.reporting.figures.coverage import plot_coverage, plot_intervals
from tepsipe.reporting.figures.style import save_figure
from tepsipe.reporting.numbers.coverage import coverage_data

text = {"condition": str, "flags": str, "failed": str}
coverage, dropped, flags, outcomes, laboratories = (
    pd.read_csv(path, dtype=text)
    for path in (
        snakemake.input.coverage,
        snakemake.input.dropped,
        snakemake.input.flags,
        snakemake.input.outcomes,
        snakemake.input.laboratories,
    )
)
first = next(iter(snakemake.params.sets))
save_figure(plot_coverage(coverage, first), snakemake.output.shares, snakemake.output.shares_png)
save_figure(plot_intervals(outcomes, first), snakemake.output.intervals, snakemake.output.intervals_png)
about = {
    "title": snakemake.params.title,
    "sets": snakemake.params.sets,
    "drawn": snakemake.params.drawn,
    "experiments": snakemake.params.experiments,
    "code": snakemake.params.code,
    "seed": snakemake.params.seed,
}
data = coverage_data(coverage, dropped, flags, laboratories, about)
Path(snakemake.output.data).write_text(
    json.dumps(data, indent=1, ensure_ascii=False) + "\n", encoding="utf-8"
)

files = source_files(snakemake.input.source, snakemake.params.source_folder) | {
    "coverage.svg": snakemake.output.shares,
    "intervals.svg": snakemake.output.intervals,
    "report.json": snakemake.output.data,
}
typeset(files, "coverage.typ", snakemake.output.pdf)
