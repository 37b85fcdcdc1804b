"""Report of a run: its raw numbers as JSON, and the PDF, whose chapters read them and the tables."""

import job

job.start(snakemake)

from report_texts import texts_of
from typeset import chapters, read_run, report_files, source_files, table_files, typeset, write_json

from tepsipe.reporting.run import raw, report_content

params = snakemake.params
tables = table_files(snakemake.input.tables)
run = read_run(tables, snakemake.input.fits, params.settings, params.study, snakemake.input.provenance)
data = raw(texts_of(run, tables)) | report_content(run, chapters(params.chapters))
write_json(snakemake.output.data, data)

files = source_files(snakemake.input.source, params.source_folder)
files |= report_files(snakemake.output.data, tables, snakemake.input.figures)
typeset(files, "report.typ", snakemake.output.pdf)
