"""Modules that a script imports, as one input of its rule.

Snakemake sees edits of a rule's inputs and of its script, but not of what the script imports. If every module
were an input of every job, most of the time in which a run finds out that it has nothing to do would go into
looking at the same files again and again. So a rule has one input, a file with the digests of its modules.
"""

import hashlib
import os
import re
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path

from tepsipe.errors import InputError, quoted
from workflow.support.places import library_beside, place_of

# beside Snakemake's records of the run: where these are lost, the files are new, and the results made again
FOLDER = ".snakemake/tepsipe/library"
PACKAGES = ("tepsipe/", "workflow/support/")  # that jobs import


def listed_in(name: str, files: Iterable[str], root: str) -> str:
    """File with the digests of other files, below `FOLDER`; written only if one of them has changed.

    name: of the file.
    files: below ``root``, as `place_of` finds them.
    """
    path = Path(FOLDER) / name
    content = "".join(f"{_digest(place_of(file, root))}  {file}\n" for file in files)
    try:
        if not path.is_file() or path.read_text(encoding="utf-8") != content:
            path.parent.mkdir(parents=True, exist_ok=True)
            new = path.with_name(f"{name}.{os.getpid()}")
            new.write_text(content, encoding="utf-8")
            new.replace(path)
    except OSError as error:
        raise InputError(
            f"{path}: expected a file that can be written, found that the system refuses it "
            f"({quoted(error)}): free space or change its permissions, then run again"
        ) from error
    return path.as_posix()


def modules_in(lists: Iterable[str]) -> list[str]:
    """Names of the modules in files of `listed_in`, without scripts."""
    lines = (line for path in lists for line in Path(path).read_text(encoding="utf-8").splitlines())
    files = {line.partition("  ")[2] for line in lines}
    modules = (file for file in files if file.endswith(".py") and file.startswith(PACKAGES))
    return sorted(file.removesuffix(".py").removesuffix("/__init__").replace("/", ".") for file in modules)


def checksums(paths: Mapping[str, str | None]) -> dict[str, dict[str, str]]:
    """Path and SHA-256 of files by their kinds, of those that are named."""
    return {kind: {"file": path, "sha256": _digest(path)} for kind, path in paths.items() if path}


@cache
def _digest(path: str) -> str:
    return hashlib.sha256(Path(path).read_bytes()).hexdigest()


@cache
def reached_by(script: str, root: str = ".") -> list[str]:
    """Files of this project that a script imports, directly or through others, sorted."""
    start = place_of(script, root)
    found: set[str] = set()
    waiting = [start]
    while waiting:
        new = _needed(waiting.pop(), root) - found
        found |= new
        waiting += new
    return sorted(path.removeprefix(f"{root}/").removeprefix(f"{library_beside(root)}/") for path in found)


# files and folders are looked up once, not once for every rule: that takes longer than all else at the start
@cache
def _needed(file: str, base: str) -> set[str]:
    """Files of this project that one file imports directly."""
    folder = file.rpartition("/")[0]
    # a script, which is in no package, imports those beside it by their bare names
    places = (base,) if _file_of(folder) else (base, folder)
    return {found for module in _imported(file) for found in _files_of(module, places)}


# by their text, in a fifth of the time of a syntax tree; prose that looks like an import names no file
FROM = re.compile(r"^[ \t]*from[ \t]+([A-Za-z_][\w.]*)[ \t]+import[ \t]+(\([^)]*\)|[^\n]*)", re.MULTILINE)
IMPORT = re.compile(r"^[ \t]*import[ \t]+([^\n#;]+)", re.MULTILINE)
COMMENT = re.compile(r"#[^\n]*")


def _imported(file: str) -> set[str]:
    text = Path(file).read_text(encoding="utf-8")
    names = {name.split()[0] for found in IMPORT.findall(text) for name in found.split(",") if name.strip()}
    for module, found in FROM.findall(text):
        # `from package import module` and `from module import name` look alike
        names.add(module)
        parts = COMMENT.sub("", found).strip("()").split(",")
        names |= {f"{module}.{part.split()[0]}" for part in parts if part.strip()}
    return names


@cache
def _files_of(module: str, places: tuple[str, ...]) -> list[str]:
    """The module's own file and those of the packages around it, if they are this project's."""
    parts = module.split(".")
    files = []
    # the library's own modules are in one place, which an installation shares with other packages
    for start in (library_beside(places[0]),) if parts[0] == "tepsipe" else places:
        for depth in range(1, len(parts) + 1):
            path = _file_of("/".join((start, *parts[:depth])))
            if path:
                files.append(path)
                if not path.endswith("/__init__.py"):
                    break  # what a module is asked for is no file
    return files


@cache
def _file_of(path: str) -> str | None:
    """File of the package or module at a path, without its suffix."""
    for name in (f"{path}/__init__.py", f"{path}.py"):
        if os.path.isfile(name):  # noqa: PTH113 -- thousands of times, in a third of the time of a Path
            return name
    return None
