"""Execute the tutorials into notebooks with outputs, which the site shows.

    python docs/run_tutorials.py

executes those in docs/tutorials that have changed since, or whose library has; the results are in
build/tutorials. The tests execute all of them (``pytest -m tutorial``).
"""

import hashlib
import os
import re
import sys
import tempfile
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from pathlib import Path

import jupytext
import nbformat
from nbclient import NotebookClient

ROOT = Path(__file__).resolve().parents[1]
SOURCES = ROOT / "docs/tutorials"
EXECUTED = ROOT / "build/tutorials"
# what a tutorial may read in the folder where it runs, beside the installed library
PROJECT = ("Snakefile", "config", "examples", "profiles", "report", "tests", "tepsipe", "workflow")
CODE = ("tepsipe", "workflow", "config")
DIGEST = "sources_sha256"


def tutorials() -> list[str]:
    """Names of all tutorials."""
    return sorted(path.stem for path in SOURCES.glob("*.py"))


@cache
def _code() -> bytes:
    """Digest of everything outside the tutorials that determines their outputs."""
    digest = hashlib.sha256()
    for folder in CODE:
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix in (".py", ".npz", ".smk", ".yaml", ".tsv"):
                digest.update(path.read_bytes())
    return digest.digest()


def digest(name: str) -> str:
    """Digest of a tutorial and of the code that it runs."""
    return hashlib.sha256(_code() + (SOURCES / f"{name}.py").read_bytes()).hexdigest()


def is_current(name: str) -> bool:
    """Return whether the executed notebook belongs to the present sources."""
    path = EXECUTED / f"{name}.ipynb"
    return path.is_file() and nbformat.read(path, as_version=4).metadata.get(DIGEST) == digest(name)


def execute(name: str, timeout_s: int = 900) -> nbformat.NotebookNode:
    """Run a tutorial in an empty folder that links to the project, and keep it with its outputs.

    Raises
    ------
    nbclient.exceptions.CellExecutionError
        If a cell fails.
    """
    notebook = jupytext.read(SOURCES / f"{name}.py")
    notebook.metadata["kernelspec"] = {"display_name": "Python 3", "language": "python", "name": "python3"}
    commands = os.pathsep.join([str(Path(sys.executable).parent), os.environ["PATH"]])
    environment = os.environ | {
        "PATH": commands,
        "PYTHONPATH": str(ROOT),
        "IPYTHONDIR": tempfile.gettempdir(),
    }
    with tempfile.TemporaryDirectory(prefix="tutorial-", ignore_cleanup_errors=True) as folder:
        for part in PROJECT:
            if (ROOT / part).exists():
                (Path(folder) / part).symlink_to(ROOT / part)
        client = NotebookClient(
            notebook,
            coalesce_streams=True,
            timeout=timeout_s,
            extra_arguments=["--log-level=40"],
            resources={"metadata": {"path": folder}},
        )
        client.execute(env=environment)
    for output in (output for cell in notebook.cells for output in cell.get("outputs", ())):
        if output.output_type == "stream":  # without the marks by which a terminal erases a line
            output.text = re.sub(r"[^\n]*\r(?!\n)|\x1b\[[0-9;]*[A-Za-z]", "", output.text)
    notebook.metadata[DIGEST] = digest(name)
    EXECUTED.mkdir(parents=True, exist_ok=True)
    nbformat.write(notebook, EXECUTED / f"{name}.ipynb")
    return notebook


if __name__ == "__main__":
    stale = [name for name in tutorials() if not is_current(name)]
    if stale:
        print("tutorials to execute:", *stale, flush=True)
    with ThreadPoolExecutor(max_workers=2) as pool:  # each has a process of its own
        list(pool.map(execute, stale))
