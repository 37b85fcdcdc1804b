"""Pages of the trials of an experiment, composed by a module of tepsipe/reporting/pages."""

import job

job.start(snakemake)

import os
from importlib import import_module
from pathlib import Path
from urllib.parse import quote

from tepsipe.io.trial import read_sources
from tepsipe.reporting.pages.trial_page import thumbnail, write_page

given, params = snakemake.input, snakemake.params
module = import_module(f"tepsipe.reporting.pages.{params.composed_by}")
conditions, paths = list(params.trials), list(snakemake.output.pages)


def places_of(k):
    """The report, the chapter of the experiment, and the trials before and after the k-th one."""
    report = os.path.relpath(Path(paths[k]).parents[2] / "index.html", Path(paths[k]).parent)
    places = {"Report": report, "All trials": f"{report}#trials", "Chapter": f"{report}#{params.chapter}"}
    for words, other in (("Previous", k - 1), ("Next", k + 1)):
        if 0 <= other < len(paths):
            places[f"{words}: {conditions[other]}"] = quote(Path(paths[other]).name)
    return places


def files_of(k):
    """Raw files, trial, fit and estimates of the k-th trial."""
    _, sources = read_sources(given.trials[k])
    files = {f"raw: {Path(source['file']).name}": source["file"] for source in sources.values()}
    files["trial (HDF5)"] = given.trials[k]
    results, (experiment, condition) = Path(given.trials[k]).parents[2], Path(given.trials[k]).parts[-2:]
    for words, folder, kind in (("fit (HDF5)", "fits", ".h5"), ("estimates (CSV)", "estimates", ".csv")):
        own = (results / folder / experiment / condition).with_suffix(kind)
        if own.is_file():
            files[words] = own
    here = Path(paths[k]).parent
    return {words: quote(Path(os.path.relpath(file, here)).as_posix()) for words, file in files.items()}


for k, page in enumerate(module.pages(given, params)):
    write_page(paths[k], page, places_of(k), files_of(k))
    Path(snakemake.output.pictures[k]).write_text(thumbnail(page), encoding="utf-8", newline="\n")
