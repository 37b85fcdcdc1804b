"""Page of a trial for a web browser, composed by a module of tepsipe/reporting/pages."""

import job

job.start(snakemake)

import os
from importlib import import_module
from pathlib import Path
from urllib.parse import quote

from tepsipe.io.trial import read_sources
from tepsipe.reporting.pages.trial_page import thumbnail, write_page

given, params, target = snakemake.input, snakemake.params, Path(snakemake.output.page)

report = os.path.relpath(target.parents[2] / "index.html", target.parent)
places = {"Report": report, "All trials": f"{report}#trials", "Chapter": f"{report}#{params.chapter}"}
for words, condition in params.neighbours.items():
    places[f"{words}: {condition}"] = quote(f"{condition}{target.suffix}")

_, sources = read_sources(given.trial)
files = {f"raw: {Path(source['file']).name}": source["file"] for source in sources.values()}
files["trial (HDF5)"] = given.trial
results, (experiment, condition) = Path(given.trial).parents[2], Path(given.trial).parts[-2:]
for words, folder, kind in (("fit (HDF5)", "fits", ".h5"), ("estimates (CSV)", "estimates", ".csv")):
    own = (results / folder / experiment / condition).with_suffix(kind)
    if own.is_file():
        files[words] = own
links = {words: quote(Path(os.path.relpath(file, target.parent)).as_posix()) for words, file in files.items()}

page = import_module(f"tepsipe.reporting.pages.{params.composed_by}").page(given, params)
write_page(target, page, places, links)
Path(snakemake.output.picture).write_text(thumbnail(page), encoding="utf-8", newline="\n")
