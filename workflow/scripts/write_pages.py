"""Page of a trial for a web browser, composed by the module ``page`` of its experiment."""

import job

job.start(snakemake)

import os
from importlib import import_module
from pathlib import Path
from urllib.parse import quote

from tepsipe.drawing.trial_page import thumbnail, write_page
from tepsipe.io.trial import read_sources
from workflow.support.origins import command

given, params, target = snakemake.input, snakemake.params, Path(snakemake.output.page)

report = os.path.relpath(target.parents[2] / "index.html", target.parent)
places = {"Report": report, "All trials": f"{report}#trials", "Chapter": f"{report}#{params.chapter}"}
places["Command of the run"] = f"{report}#make-again"
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

# without the configuration files of the run: a further one would make the pages of all trials again
again = command(f"{experiment}/{Path(condition).stem}", [f"ingest_{experiment}"], ())
module, function = params.composed_by.split(":")
page = getattr(import_module(f"tepsipe.{module}"), function)(given, params)
write_page(target, page, places, links, again)
Path(snakemake.output.picture).write_text(thumbnail(page), encoding="utf-8", newline="\n")
