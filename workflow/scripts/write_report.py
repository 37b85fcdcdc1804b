"""Report of a run: its raw numbers as JSON, and PDFs, whose chapters read them and the tables."""

import job

job.start(snakemake)

from pathlib import Path

from typeset import chapters, read_run, report_files, source_files, table_files, typeset, write_json

from tepsipe.reporting.run import report_content

given, params = snakemake.input, snakemake.params
tables = table_files(given.tables)
run = read_run(tables, given.fits, params.settings, params.study, given.provenance)
write_json(snakemake.output.data, report_content(run, chapters(params.chapters)))

files = source_files(given.source, params.source_folder)
files |= report_files(snakemake.output.data, tables, given.figures)
pdfs = snakemake.output.pdf
pdfs = [pdfs] if isinstance(pdfs, str) else pdfs
failed = typeset(files, dict(zip((params.main, "supplement.typ"), pdfs, strict=False)))
if failed:
    line = f"Sentences of the report that do not hold in this run: {', '.join(failed)}\n"
    Path(snakemake.log[0]).write_text(line, encoding="utf-8")
