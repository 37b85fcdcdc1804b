"""Join the tables of all walking trials, draw them, and typeset the chapter on walking."""

import job

job.start(snakemake)

import json
from pathlib import Path

import pandas as pd
from typeset import source_files, typeset

from tepsipe.reporting.figures.style import save_figure
from tepsipe.reporting.figures.walking import plot_walking
from tepsipe.reporting.numbers.walking import walking_data

rows = pd.concat(
    [pd.read_csv(path, keep_default_na=False, na_values=["nan"]) for path in snakemake.input.rows]
)
needed = pd.concat([pd.read_csv(path, dtype={"condition": str}) for path in snakemake.input.needed])
rows.to_csv(snakemake.output.rows, index=False, float_format="%.10g")
needed.to_csv(snakemake.output.needed, index=False, float_format="%.10g")
about = [json.loads(Path(path).read_text(encoding="utf-8")) for path in snakemake.input.about]
# resampled strides are alike, and need fewer than real ones
made = [trial["condition"] for trial in about if trial["source"] == "virtual_lab"]
needed = needed[~needed.condition.isin(made)]
recovery = pd.read_csv(snakemake.input.recovery) if snakemake.input.recovery else None
save_figure(plot_walking(rows, needed, recovery), snakemake.output.figure, snakemake.output.figure_png)
study = {
    "title": snakemake.params.title,
    "recordings_source": snakemake.params.recordings_source,
    "planned": snakemake.params.planned,
    "code": snakemake.params.code,
}
data = walking_data(rows, needed, about, study, recovery)
Path(snakemake.output.data).write_text(json.dumps(data, indent=1, ensure_ascii=False) + "\n", "utf-8")

files = source_files(snakemake.input.source, snakemake.params.source_folder) | {
    "walking.svg": snakemake.output.figure,
    "report.json": snakemake.output.data,
}
typeset(files, "walking.typ", snakemake.output.pdf)
