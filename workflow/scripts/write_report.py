"""Numbers of the report of a run as JSON: those that are in no table, and whether its sentences hold."""

import job

job.start(snakemake)

from typeset import chapters, read_run, table_files, write_json

from tepsipe.reporting.run import report_content

given, params = snakemake.input, snakemake.params
run = read_run(table_files(given.tables), given.fits, params.settings, params.study, given.provenance)
write_json(snakemake.output.data, report_content(run, chapters(params.chapters)))
