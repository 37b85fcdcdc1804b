"""Start of the rules of studies, by ``tepsipe check`` and ``tepsipe run``, in a Python of their own.

The library imports none of them. They lie around this package in a checkout, and in its folder ``_study`` in
an installation by pip.
"""

import os
import re
import shutil
import sys
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from shlex import quote

from tepsipe import __version__
from tepsipe.errors import InputError

# packages that only studies need: name -> module
PACKAGES = {"pydantic": "pydantic", "PyYAML": "yaml", "snakemake": "snakemake", "typst": "typst"}
INSTALL = "pip install 'tepsipe[study]'"
# file of a study that names the version it was made with, as pip reads it
REQUIRED = "requirements.txt"
OWN = "config.yaml"  # configuration of a study, in its folder
# beginning of a line on the standard error of a module of the rules that tells how far it is
FAR = "at work: "
CONFIGFILE = re.compile(r"--configfiles?(=.*)?")
# options of Snakemake that state a number of cores, and a profile, which may state one
CORES = re.compile(r"-[a-zA-Z]*[cj](\d+|all)?|--(cores|jobs|profile|workflow-profile)(=.*)?")


def rules_folder() -> Path:
    """Folder with ``Snakefile``, rules and profiles that belong to this library."""
    package = Path(__file__).absolute().parents[1]
    for folder in (package.parent, package / "_study"):
        if _has_rules(folder):
            return folder
    raise InputError(
        f"{package}: expected the rules of studies beside the library, found none: install tepsipe again "
        f"from a wheel or a copy of the repository ({INSTALL})"
    )


def _has_rules(folder: Path) -> bool:
    return (folder / "workflow" / "check.py").is_file()


def commands_in(folder: Path) -> list[str]:
    """Commands that check and run a study; one that the shell finds elsewhere is named with its path."""
    here = str(Path(sys.executable).parent / "tepsipe")
    command = "tepsipe" if shutil.which("tepsipe") == here else quote(here)
    return [f"cd {quote(str(folder))}", f"{command} check", f"{command} run"]


def started_in() -> Path:
    """Folder of the rules for a command in this folder, which may itself be a checkout."""
    return Path.cwd() if _has_rules(Path.cwd()) else rules_folder()


def own_files(named: Sequence[str]) -> list[str]:
    """Configuration files beside the shipped one: those ``named``, or that of the study in this folder."""
    if named or _has_rules(Path.cwd()):
        return [*named]
    if not Path(OWN).is_file():
        raise InputError(
            f"{Path.cwd()}: expected the folder of a study, with {OWN}, found none: change to one, or name "
            "configuration files"
        )
    return [OWN]


def start_of(module: str, arguments: Sequence[str]) -> tuple[list[str], dict[str, str]]:
    """Command and environment that start a module of the rules."""
    missing = [name for name, package in PACKAGES.items() if find_spec(package) is None]
    if missing:
        raise InputError(
            f"tepsipe {module}: expected the packages of studies, found no {', '.join(missing)}: install "
            f"them with {INSTALL}, or run make in a checkout"
        )
    folder = started_in()
    before = os.environ.get("PYTHONPATH")
    places = os.pathsep.join([str(folder), *([before] if before else [])])
    environment = dict(os.environ, PYTHONPATH=places, PYTHONIOENCODING="utf-8:backslashreplace")
    return [sys.executable, "-P", "-m", f"workflow.{module}", *arguments], environment


def arguments_of_run(given: Sequence[str]) -> list[str]:
    """Arguments of Snakemake: all cores, and what a study without a Snakefile needs, if not given."""
    arguments = [*([] if any(map(CORES.fullmatch, given)) else ["--cores", "all"]), *given]
    own = own_files([word for word in given if CONFIGFILE.fullmatch(word)])
    if not Path("Snakefile").exists() and not {"--snakefile", "-s"} & set(given):
        arguments = ["--snakefile", str(started_in() / "Snakefile"), *arguments]
        # a Snakefile comes with a profile, which names the configuration
        arguments += ["--configfile", *own] if own == [OWN] else []
    return arguments


def refuse_other_version(folder: Path) -> None:
    """Refuse a study that was made with another version, as its `REQUIRED` states."""
    made = version_of(folder / REQUIRED)
    if made not in (None, __version__):
        raise InputError(
            f"{folder / REQUIRED}: expected tepsipe {made}, with which this study was made, found "
            f"{__version__}: install it with pip install 'tepsipe[study]=={made}', or go on with tepsipe run "
            "--any-version"
        )


def version_of(file: Path) -> str | None:
    """Version of tepsipe that a file of requirements demands; None without such a line or file."""
    try:
        text = file.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError):
        return None
    found = re.search(r"^\s*tepsipe\s*(?:\[[^]\n]*\])?\s*==\s*([\w.+!-]+)", text, re.MULTILINE)
    return found[1] if found else None
