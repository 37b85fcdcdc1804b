# Checks and look-ups that the rules share. No rule stands here.

import compileall
import os
import sys
from functools import partial
from hashlib import sha256
from itertools import chain
from pathlib import Path

from tepsipe.experiments.registry import EXPERIMENTS
from tepsipe.io.formats import modules_for
from tepsipe.mechanics.engines import resolved_engine
from tepsipe.virtual_lab.registry import RIGS
from workflow.support import groups, outputs, report_params
from workflow.support.parts import APPENDIX
from workflow.support.places import library_beside, place_of
from workflow.support.folders import check_checkout
from workflow.support.imported_files import listed_in, reached_by
from workflow.support.rigs import RIG_KEYS, rig_of
from workflow.settings.complete import only, pick, without
from workflow.support.checked_study import checked_sections, checked_study, with_its_file
from workflow.support.lookups.thesis import table_experiment
from workflow.support.study import any_of
from workflow.support.version import code_version
from workflow.support.yaml_file import base_of

# bytecode once, not once per job: some environments keep Python from writing it; pip has made that of a wheel
compileall.compile_dir(CHECKOUT / "tepsipe", quiet=2)


def here(path):
    """A file of this project, as seen from the folder that the study runs in."""
    return os.path.relpath(place_of(path, CHECKOUT))


def sections_of(key):
    """Check the file that study.<key> names; return a function that takes some of it, of no file nothing."""
    content = checked_sections(config, key)
    return (lambda *paths: {}) if content is None else partial(pick, content)


try:
    STUDY = checked_study(config, CONFIGFILES)
    # a rule is given no more of these files than it reads, and runs again for nothing else. Only the rules that
    # make raw files, compare with the truth, or list the laboratory's constants may call truth_of
    truth_of, reported_of = sections_of("virtual_lab"), sections_of("reported")
    # what moves the simulated dummy; it must be installed
    ENGINE = resolved_engine(config["dummy"]["simulation"]["engine"]) if STUDY.has("simulation") else None
    check_checkout(CHECKOUT)
except InputError as error:
    sys.exit(f"tepsipe: {with_its_file(error, config, CONFIGFILES)}")

SETTINGS, SEED = STUDY.settings, config["study"]["seed"]
# trials that the command line names as targets, as in snakemake -c2 dummy/sine-0.3
NAMED = [trial for trial in STUDY.trials if "/".join(trial) in sys.argv]
# facts that every report tells
ABOUT_STUDY = {
    "title": config["study"]["title"],
    "recordings_source": config["study"]["recordings_source"],
    "experiments": STUDY.all_conditions(),
    "made": STUDY.all_simulated(),
}


# what an experiment declares reaches a job by the params of its rule: an edit re-runs those whose params change
DECLARATIONS = {
    "tepsipe/experiments/experiment.py",
    *(f"tepsipe/experiments/{known.folder}/__init__.py" for known in EXPERIMENTS.values()),
}
# sources of schematics and flow charts
DRAWINGS = [here(f"report/{name}.typ") for name in ("drawings", "format")]


wildcard_constraints:
    condition=any_of(condition for _, condition in STUDY.trials),
    task=any_of(STUDY.tasks.names()),


def as_it_is(value):
    """Param function: text of the user, in which Snakemake looks for no wildcards."""
    return lambda w: value


def sheet(column, experiment):
    """Param function: a column of the trial's row."""
    return lambda w: getattr(STUDY.trials[experiment, w.condition], column)


def of_trial(function, experiment):
    """Param function: what a function of experiment and condition finds for the trial."""
    return lambda w: function(experiment, w.condition)


def section_of(experiment, *paths):
    """Param function: what the fit of a trial reads of the section of its experiment; paths as for `pick`."""
    return lambda w: pick(STUDY.of_trial(experiment, w.condition), *paths)


def raw_files(experiment):
    """Param function: kind -> path of the trial's raw files, recorded or simulated."""
    return lambda w: STUDY.raw_files(experiment, w.condition, config["pathvars"]["results"])


def raw_inputs(experiment):
    """Input function: raw files that the laboratory simulates; recorded ones are params, by `contents_of`."""
    return lambda w: STUDY.raw_inputs(experiment, w.condition, config["pathvars"]["results"])


def reported_table(name):
    """What the thesis printed in one of its tables."""
    return reported_of("tables").get("tables", {}).get(name, {})


def meant_in(*names):
    """Quantity -> condition -> number of the thesis's tables, with misprints corrected."""
    found = {}
    for name in names:
        for quantity, row in reported_table(name).items():
            found.setdefault(quantity, {}).update(row)
    for slip in reported_of("slips").get("slips", []):
        if slip["table"] in names:
            found[slip["quantity"]][slip["condition"]] = slip["meant"]
    return found


def printed_joints(w):
    """Parameter set -> I, B, K of the thesis for a condition; none for a condition that it does not have."""
    simulations = reported_of("simulations").get("simulations", {})
    tables = meant_in("table_4_2", "table_4_3")
    printed = {key: tables.get(key, {}).get(w.condition) for key in ("I", "B", "K")}
    if not simulations or None in printed.values():
        return {}
    tep = simulations["captions"].get(w.condition, printed)
    return {**simulations["every_condition"], "thesis-tep": tep}


def files_of(*modules):
    """Files of modules of the library by their names."""
    return [f"{name.replace('.', '/')}.py" for name in modules]


def readers_of(experiment):
    """Files of the readers of an experiment's raw files."""
    return files_of(*modules_for(*experiment.purposes))


def library_of(script, *loaded):
    """What stands for the modules that a script reaches, and for modules and other files that it loads by name.

    An edit of one of them re-runs the rule."""
    starts = (f"workflow/scripts/{script}.py", *(path for path in loaded if path.endswith(".py")))
    found = {path for start in starts for path in reached_by(start, str(CHECKOUT))}
    name = "+".join((script, *(".".join(Path(path).parts).removesuffix(".py") for path in loaded)))
    return source_list(name, found.union(loaded) - DECLARATIONS)


def source_list(name, files):
    """The file that lists sources with their digests."""
    # a name of more than 100 characters, as of all chapters of a report, ends with its digest
    short = name if len(name) <= 100 else f"{name[:80]}-{sha256(name.encode()).hexdigest()[:16]}"
    try:
        return listed_in(short, sorted(files), str(CHECKOUT))
    except InputError as error:
        sys.exit(f"tepsipe: {error}")


def chapter_modules(names):
    """Modules of chapters of the report."""
    return [f"tepsipe/reporting/chapters/{name}.py" for name in names]


def laboratory_sources():
    """Everything that a laboratory's study runs through: an edit runs all laboratories again."""
    rules = [CHECKOUT / "Snakefile", *(CHECKOUT / "workflow").rglob("*")]
    kept = [path for path in rules if path.suffix in ("", ".py", ".smk", ".yaml") and path.is_file()]
    library = Path(library_beside(str(CHECKOUT)))
    modules = (path.relative_to(library) for path in (library / "tepsipe").rglob("*.py"))
    files = (*(path.relative_to(CHECKOUT) for path in kept), *modules)
    return source_list("laboratory", [path.as_posix() for path in files])


def report_sources():
    """Typst sources, captions and references of the report."""
    files = sorted(p for p in (CHECKOUT / "report").rglob("*") if p.suffix in (".typ", ".yaml", ".bib"))
    return [os.path.relpath(path) for path in files]


def figure_pairs(*names):
    """Named outputs for figures with these names."""
    return outputs.with_numbers({name: f"<results>/figures/{name}.svg" for name in names})


def figure_files(name, folder=""):
    """Named outputs of a plotting rule, without figures of single trials; below a folder, for example of one
    participant."""
    folder = f"<results>/figures/{folder}".rstrip("/")
    figures = [figure for figure in outputs.figures_of(STUDY, name) if figure not in APPENDIX]
    return outputs.with_numbers({figure: f"{folder}/{figure}.svg" for figure in figures}, folder)
