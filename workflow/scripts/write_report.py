"""Report of a run: its raw numbers as JSON, and the PDF, whose chapters read them and the tables."""

import job

job.start(snakemake)

import json
from pathlib import Path
from urllib.parse import quote

from report_texts import texts_of
from typeset import (
    chapters,
    first_page,
    read_run,
    report_files,
    source_files,
    table_files,
    typeset,
    write_json,
)

from tepsipe.reporting.run import raw, report_content

provenance = json.loads(Path(snakemake.input.provenance).read_text(encoding="utf-8"))
study = snakemake.params.study | {"provenance": provenance}
tables = table_files(snakemake.input.tables)
run = read_run(tables, snakemake.input.fits, snakemake.params.settings, study)
data = raw(texts_of(run, tables)) | report_content(run, chapters(snakemake.params.chapters))
write_json(snakemake.output.data, data)

files = source_files(snakemake.input.source, snakemake.params.source_folder)
files |= report_files(snakemake.output.data, tables, snakemake.input.figures)
typeset(files, "report.typ", snakemake.output.pdf)
first = first_page(files, f"./{quote(Path(snakemake.output.pdf).name)}")
write_json(snakemake.output.data, data | {"first_page": first})
