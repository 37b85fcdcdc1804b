"""Modules that a script imports, so that rules can name them as inputs.

Snakemake sees edits of a rule's inputs and of its script, but not of what the script imports.
"""

import re
from functools import cache
from pathlib import Path


@cache
def reached_by(script: str, root: str = ".") -> list[str]:
    """Files of this project that a script imports, directly or through others, sorted."""
    start = f"{root}/{script}"
    found: set[str] = set()
    waiting = [start]
    while waiting:
        new = _needed(waiting.pop(), root) - found
        found |= new
        waiting += new
    return sorted(path.removeprefix(f"{root}/") for path in found)


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
    for start in places:
        for depth in range(1, len(parts) + 1):
            path = _file_of("/".join((start, *parts[:depth])))
            if path:
                files.append(path)
    return files


@cache
def _file_of(path: str) -> str | None:
    """File of the package or module at a path, without its suffix."""
    for name in (f"{path}/__init__.py", f"{path}.py"):
        if Path(name).is_file():
            return name
    return None
