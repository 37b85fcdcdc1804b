"""Run the study of one drawn laboratory by the rules of this project, and keep its tables."""

import job

job.start(snakemake)

import json
import shutil
from pathlib import Path

from tepsipe.io.estimates import CONTRIBUTIONS, ESTIMATES, RECOVERIES
from workflow.support.laboratories import TABLES, forget, run

about, folder = snakemake.params.about, Path(snakemake.output.laboratory).parent / "study"
failed = run(snakemake.params.files, folder)
kept = [snakemake.output.estimates, snakemake.output.uncertainty, snakemake.output.recovery]
for name, path in zip(TABLES, kept, strict=True):
    if not failed:
        shutil.copyfile(folder / f"results/tables/{name}.csv", path)
if failed:
    ESTIMATES.write(snakemake.output.estimates, [])
    CONTRIBUTIONS.write(snakemake.output.uncertainty, [])
    RECOVERIES.write(snakemake.output.recovery, [])
forget(folder)
Path(snakemake.output.laboratory).write_text(
    json.dumps(about | {"failed": failed}, ensure_ascii=False) + "\n", encoding="utf-8"
)
