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

given, params = snakemake.input, snakemake.params
whole = params.main == "report.typ"
study = dict(params.study)
if whole:
    study["provenance"] = json.loads(Path(given.provenance).read_text(encoding="utf-8"))
tables = table_files(given.tables)
run = read_run(tables, given.fits, params.settings, study)
data = report_content(run, chapters(params.chapters))
if whole:
    data = raw(texts_of(run, tables)) | data
write_json(snakemake.output.data, data)

files = source_files(given.source, params.source_folder)
files |= report_files(snakemake.output.data, tables, given.figures)
typeset(files, params.main, snakemake.output.pdf)
if whole:
    first = first_page(files, f"./{quote(Path(snakemake.output.pdf).name)}")
    write_json(snakemake.output.data, data | {"first_page": first})
