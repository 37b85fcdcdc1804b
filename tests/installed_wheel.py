"""Build a wheel, install it and what it declares into an environment of its own, run the library's tests.

    python tests/installed_wheel.py [--extra mujoco] [further arguments of pytest]

The environment is made with pip by the interpreter that runs this. Wheel, environment and copies of tests,
configuration and examples are in a temporary folder, away from the checkout: tests can only import the
installed library. Tests of the workflow and of the checkout's own files stay behind. With ``--extra study``,
the rules in the wheel also run a study (`tests/new_study/test_installed_study.py`).
"""

import argparse
import os
import re
import shutil
import subprocess
import sys
import tempfile
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SOURCES = (
    *("tepsipe", "snakemake_executor_plugin_tepsipe", "pyproject.toml", "setup.py", "README.md", "LICENSE"),
    # of studies
    *("Snakefile", "CITATION.cff", "workflow", "report", "config", "profiles", "docs/decisions"),
)
OF_THE_CHECKOUT = {
    "test_browser.py",
    "test_docs.py",
    "test_refusals.py",
    "test_release.py",
    "test_walls.py",
    "test_public_fits.py",
}
OF_THE_WORKFLOW = re.compile(
    r"^\s*(from|import) (workflow|benchmarks|(study|typst|joint|study_chapter)_builders)\b", re.MULTILINE
)
WHERE = "import sys, tepsipe; print(tepsipe.__file__); sys.exit(not tepsipe.__file__.startswith(sys.prefix))"


def run(*command: object, **options) -> None:
    """Run a command; stop with its exit code if it fails."""
    done = subprocess.run([str(part) for part in command], **options)
    if done.returncode:
        sys.exit(done.returncode)


def copy(name: str, target: Path) -> None:
    """Copy a file or folder of the checkout, without bytecode."""
    if (ROOT / name).is_dir():
        shutil.copytree(ROOT / name, target / name, ignore=shutil.ignore_patterns("__pycache__"))
    else:
        shutil.copy(ROOT / name, target / name)


def main() -> None:
    """Build, install, test."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--extra", action="append", default=[], help="extra to install, for example mujoco")
    chosen, of_pytest = parser.parse_known_args()
    with tempfile.TemporaryDirectory(prefix="tepsipe-wheel-") as name:
        folder = Path(name)
        for part in ("source", "wheel", "tests"):
            (folder / part).mkdir()
        for source in SOURCES:
            copy(source, folder / "source")
        venv.create(folder / "environment", with_pip=True)
        python = folder / "environment" / ("Scripts" if os.name == "nt" else "bin") / "python"
        pip = (python, "-m", "pip", "--quiet", "--disable-pip-version-check")
        run(*pip, "wheel", "--no-deps", "--wheel-dir", folder / "wheel", folder / "source")
        (wheel,) = (folder / "wheel").glob("tepsipe-*.whl")
        extras = ",".join(["test", *chosen.extra])
        run(*pip, "install", f"tepsipe[{extras}] @ {wheel.as_uri()}")
        for source in ("tests", "config", "docs", "examples", "pyproject.toml", "README.md"):
            copy(source, folder / "tests")
        # recordings of others, if the checkout has them
        os.environ.setdefault("TEPSIPE_REAL_DATA", str(ROOT.parent / "shared" / "real-data"))
        elsewhere = {"cwd": folder / "tests"}
        run(python, "-c", WHERE, **elsewhere)
        left = [
            path.relative_to(folder / "tests")
            for path in sorted((folder / "tests" / "tests").rglob("test_*.py"))
            if path.name in OF_THE_CHECKOUT or OF_THE_WORKFLOW.search(path.read_text(encoding="utf-8"))
        ]
        print("left out, because they need the checkout:", *left, flush=True)
        ignored = [part for path in left for part in ("--ignore", path)]
        run(python, "-m", "pytest", "-q", *ignored, *of_pytest, **elsewhere)


if __name__ == "__main__":
    main()
