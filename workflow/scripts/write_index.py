"""Index of the run for a browser."""

import job

job.start(snakemake)

import json
from pathlib import Path

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
report = json.loads(Path(snakemake.input.data).read_text(encoding="utf-8"))
page = render_index(report, listing)
Path(snakemake.output.html).write_text(page, encoding="utf-8", newline="\n")
