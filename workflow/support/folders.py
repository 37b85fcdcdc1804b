"""Where a study may write: in folders of its own, never over what it reads.

Every output lies below ``pathvars.results`` or ``pathvars.logs``. Neither folder may hold an input, be a
folder of the source code or, unless ``study.outside`` is true, lie outside the folder that the study runs in.
Symbolic links and ``..`` are resolved first.
"""

import os
import re
from collections.abc import Iterable, Iterator
from pathlib import Path

from tepsipe.errors import InputError, quoted
from tepsipe.io.names import DEVICES, LONGEST, special_in
from workflow.support.places import place_of

# of the checkout; in none of these folders there may be outputs
SOURCES = (
    *("Snakefile", "workflow", "tepsipe", "report", "profiles", "tests", "docs", "examples", "benchmarks"),
    *("Makefile", "pyproject.toml", "requirements.txt", "requirements.in", "README.md"),
    *(".git", ".venv", ".snakemake"),
)
LONGEST_BYTES = 255  # of the name of a file or a folder
# files that the section `study` names
INPUTS = {
    "trial_sheet": "the trial sheet",
    "virtual_lab": "the virtual laboratory",
    "reported": "the reported values",
    "participants": "the participants",
}


def check_path(name: str, value: str | None, key: str) -> None:
    """Refuse a path in the configuration that Snakemake would take for a pattern, or that names nothing."""
    if value is None:
        return
    special = special_in(value)
    if special:
        raise InputError(
            f"{name}: expected a path without {' '.join(map(repr, special))} for {key!r}, found "
            f"{quoted(value)}: rename it"
        )
    if not value.strip() or value.startswith("-"):
        raise InputError(
            f"{name}: expected a path for {key!r} that does not begin with a hyphen and is not empty, found "
            f"{quoted(value)}: rename it"
        )
    if max(len(os.fsencode(part)) for part in value.split("/")) > LONGEST_BYTES:
        raise InputError(
            f"{name}: expected names of at most {LONGEST_BYTES} bytes in the path for {key!r}, found "
            f"{quoted(value)}: shorten it"
        )
    if value.startswith(("~", "$")):
        what = "the home directory" if value.startswith("~") else "the variable"
        raise InputError(
            f"{name}: expected a path from / or from the folder of the run for {key!r}, found "
            f"{quoted(value)}: write {what} out"
        )


def check_checkout(folder: Path) -> None:
    """Refuse a checkout in whose path Snakemake would look for wildcards and variables."""
    forbidden = sorted(set("{}<>") & set(str(folder)))
    if forbidden:
        raise InputError(
            f"{folder}: expected tepsipe in a folder without {' '.join(map(repr, forbidden))}, which "
            "Snakemake takes for wildcards, found them in its path: rename that folder; studies lie anywhere"
        )


def check_paths(config: dict, name: str) -> None:
    """Check every path of the configuration as text."""
    for section in ("study", "pathvars"):
        for key in (*INPUTS, "recordings_folder", "results", "logs"):
            if key in config[section]:
                check_path(name, config[section][key], f"{section}.{key}")
    if Path(config["study"]["recordings_folder"]).is_file():
        raise InputError(
            f"{name}: expected study.recordings_folder to name a folder, found the file "
            f"{quoted(config['study']['recordings_folder'])}: name the folder that holds it"
        )
    report = config["study"]["name"]
    if len(report) > LONGEST or report in DEVICES:
        raise InputError(
            f"{name}: expected study.name to be the name of a file of at most {LONGEST} characters, found "
            f"{quoted(report)}: choose another"
        )
    for key, what in INPUTS.items():
        path = config["study"][key]
        if path is not None and Path(path).is_dir():
            raise InputError(
                f"{name}: expected study.{key} to name {what}, found the folder {quoted(path)}: name the file"
            )


def check_folders(
    config: dict, configfiles: Iterable[str | Path], recordings: Iterable[str], code: str | Path, name: str
) -> None:
    """Refuse folders of results and logs in which outputs would meet inputs, sources or each other."""
    study = config["study"]
    inputs = [("the configuration", path) for path in configfiles]
    inputs += [(what, study[key]) for key, what in INPUTS.items() if study[key] is not None]
    inputs += [("the recording", path) for path in recordings]
    if _real(study["recordings_folder"]) != Path.cwd():
        inputs.append(("the recordings folder", study["recordings_folder"]))
    sources = [("the source", Path(place_of(source, code))) for source in SOURCES]
    sources.append(("the source", Path("Snakefile")))
    for key in ("results", "logs"):
        for folder in _folders(config["pathvars"][key]):
            where = f"{name}: expected pathvars.{key} to be a folder of its own"
            found = f"found {quoted(config['pathvars'][key])}"
            _check_place(folder, study["outside"], f"{name}: expected pathvars.{key}", found)
            _refuse_what_it_holds(folder, [*inputs, *sources], where, found, key)
            _refuse_inside(folder, [path for _, path in sources], where, found)
    _check_apart(config["pathvars"], Path(code), name)


def _real(path: str | Path) -> Path:
    """Absolute path behind symbolic links; of links that lead back to themselves, one of them."""
    return Path(os.path.realpath(path))


def _folders(folder: str) -> Iterator[Path]:
    """The folder, and those that links in it lead to."""
    yield _real(folder)
    try:
        yield from (_real(child) for child in Path(folder).iterdir() if child.is_symlink() and child.is_dir())
    except OSError:  # not there yet, or no folder
        return


def _check_place(folder: Path, outside: bool, where: str, found: str) -> None:
    project = Path.cwd()
    if folder.is_symlink():
        raise InputError(f"{where} to be a folder, {found}, a symbolic link that leads to none: name another")
    if folder.exists() and not folder.is_dir():
        raise InputError(f"{where} to be a folder, {found}, which is a file: name another")
    there = next(path for path in (folder, *folder.parents) if path.exists())
    if not os.access(there, os.W_OK | os.X_OK):
        raise InputError(
            f"{where} to be a folder that can be written to, {found}, where {there} cannot: change its "
            "permissions, or name another"
        )
    if not outside and project not in folder.parents and folder != project:
        raise InputError(
            f"{where} in the folder that the study runs in ({project}), {found}, which is {folder}: name a "
            "folder there, or set study.outside to true"
        )


def _refuse_what_it_holds(folder: Path, inputs, where: str, found: str, key: str) -> None:
    for what, path in inputs:
        resolved = _real(path)
        # a link that lies in the folder would be overwritten, too
        lying = Path(os.path.normpath(Path.cwd() / path))
        if resolved.exists() and (_holds(folder, resolved) or _holds(folder, lying)):
            raise InputError(
                f"{where}, {found}, which holds {what} {path}: name another, for example "
                f"{_example(folder, key)}"
            )


def _holds(folder: Path, path: Path) -> bool:
    """Whether a path is the folder or lies in it, however upper and lower case are written."""
    around = (path, *path.parents)
    if folder in around:
        return True
    return folder.exists() and any(other.exists() and other.samefile(folder) for other in around)


def _refuse_inside(folder: Path, sources: list[Path], where: str, found: str) -> None:
    for source in sources:
        if (source.is_dir() or not source.exists()) and _holds(_real(source), folder):
            raise InputError(
                f"{where}, {found}, which lies in {source.name}/ of the source code: name another, for "
                "example results"
            )


def _example(folder: Path, key: str) -> str:
    relative = os.path.relpath(folder)
    return key if relative == "." else f"{relative}/{key}"


def names_in_results(code: Path) -> set[str]:
    """Files and folders at the top of the results, as the rules name them."""
    files = [*(code / "workflow" / "rules").glob("*.smk"), code / "workflow" / "support" / "outputs.py"]
    return {name for file in files for name in re.findall(r"<results>/([\w.-]+)", file.read_text("utf-8"))}


def _check_apart(pathvars: dict, code: Path, name: str) -> None:
    results, logs = _real(pathvars["results"]), _real(pathvars["logs"])
    if results == logs or _holds(logs, results):
        raise InputError(
            f"{name}: expected pathvars.logs beside or in pathvars.results, in a folder of its own, found "
            f"{quoted(pathvars['logs'])} for results in {quoted(pathvars['results'])}: name another, for "
            f"example {pathvars['results']}/logs"
        )
    if results in logs.parents:
        first = logs.relative_to(results).parts[0]
        if first in names_in_results(code):
            raise InputError(
                f"{name}: expected pathvars.logs in a folder of its own, found {quoted(pathvars['logs'])}, "
                f"which lies among the results in {first}: name another, for example "
                f"{pathvars['results']}/logs"
            )
