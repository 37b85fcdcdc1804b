"""Index of the run for a browser."""

import job

job.start(snakemake)

from pathlib import Path
from urllib.parse import quote

from typeset import index_parts, report_files, source_files, table_files

from tepsipe.reporting.pages.index import Listing, render_index
from workflow.support.captions import read_captions

params = snakemake.params
captions = read_captions(snakemake.input.captions)
listing = Listing(
    pdf=params.pdf,
    figures={
        category: {figure: captions[caption] for figure, caption in figures.items()}
        for category, figures in params.figures.items()
    },
    tables={table: captions[caption] for table, caption in params.tables.items()},
    trials=params.trials,
    activity=params.activity,
)
files = source_files(snakemake.input.report, params.report_folder)
files |= report_files(snakemake.input.data, table_files(snakemake.input.tables))
page = render_index(params.title, index_parts(files, f"./{quote(params.pdf)}"), listing)
Path(snakemake.output.html).write_text(page, encoding="utf-8", newline="\n")
