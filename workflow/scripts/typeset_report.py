"""Report of a run as PDFs, from its numbers, tables and figures."""

import job

job.start(snakemake)

from pathlib import Path

from typeset import report_files, source_files, table_files, typeset

given, params = snakemake.input, snakemake.params
files = source_files(given.source, params.source_folder)
files |= report_files(given.data, table_files(given.tables), given.figures)
failed = typeset(files, dict(zip((params.main, "supplement.typ"), snakemake.output.pdf, strict=False)))
if failed:
    line = f"Sentences of the report that do not hold in this run: {', '.join(failed)}\n"
    Path(snakemake.log[0]).write_text(line, encoding="utf-8")
