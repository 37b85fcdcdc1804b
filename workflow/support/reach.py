"""Modules that a script imports, so that rules can name them as inputs.

Snakemake sees edits of a rule's inputs and of its script, but not of what the script imports.
"""

import ast
from functools import cache
from pathlib import Path


@cache
def reached_by(script: str, root: str = ".") -> list[str]:
    """Files of this project that a script imports, directly or through others, sorted."""
    base = Path(root)
    found: set[Path] = set()
    waiting = [base / script]
    while waiting:
        new = _needed(waiting.pop(), base, (base / script).parent) - found
        found |= new
        waiting += new
    return sorted(path.relative_to(base).as_posix() for path in found)


# files and folders are looked up once, not once for every rule: that takes longer than all else at the start
@cache
def _needed(file: Path, base: Path, script_folder: Path) -> set[Path]:
    """Files of this project that one file imports directly."""
    return {found for module in _imported(file) for found in _files_of(module, base, script_folder)}


def _imported(file: Path) -> set[str]:
    names = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"), str(file))):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            # `from package import module` and `from module import name` look alike
            names.add(node.module)
            names |= {f"{node.module}.{alias.name}" for alias in node.names}
    return names


@cache
def _files_of(module: str, base: Path, script_folder: Path) -> list[Path]:
    """The module's own file and those of the packages around it, if they are this project's."""
    parts = module.split(".")
    files = []
    for start in (base, script_folder):
        for depth in range(1, len(parts) + 1):
            path = start.joinpath(*parts[:depth])
            if (path / "__init__.py").is_file():
                files.append(path / "__init__.py")
            elif path.with_suffix(".py").is_file():
                files.append(path.with_suffix(".py"))
    return files
