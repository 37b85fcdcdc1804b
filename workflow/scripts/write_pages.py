"""Pages of the trials of an experiment, composed by a module of tepsipe/reporting/pages."""

import job

job.start(snakemake)

from importlib import import_module

from tepsipe.reporting.pages.trial_page import write_page

module = import_module(f"tepsipe.reporting.pages.{snakemake.params.composed_by}")
pages = module.pages(snakemake.input, snakemake.params)
for path, page in zip(snakemake.output.pages, pages, strict=True):
    write_page(path, page)
