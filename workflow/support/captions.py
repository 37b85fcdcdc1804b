"""Captions of figures and tables, of one file, in a file each for Snakemake's report."""

import os
import re
from functools import cache
from pathlib import Path

import yaml

FOLDER = Path(".snakemake") / "tepsipe" / "captions"
OF_PROJECT = Path(__file__).parents[2] / "report" / "captions.yaml"


@cache
def caption_file(captions: Path, name: str) -> str:
    """File with one caption; all of them are written where they are missing or of another version."""
    changed = captions.stat().st_mtime_ns
    if not FOLDER.is_dir() or FOLDER.stat().st_mtime_ns != changed:
        FOLDER.mkdir(parents=True, exist_ok=True)
        for own, text in read_captions(captions).items():
            (FOLDER / f"{own}.rst").write_text(text + "\n", encoding="utf-8")
        os.utime(FOLDER, ns=(changed, changed))
    return str((FOLDER / f"{name}.rst").absolute())


def read_captions(path: str | Path) -> dict[str, str]:
    """Name of a figure or table -> its caption."""
    return {name: text for group in _groups(Path(path)).values() for name, text in group.items()}


def captions_of(name: str) -> tuple[str, ...]:
    """Captions of the figures of an experiment or part, in the order in which they are shown."""
    return tuple(_groups(OF_PROJECT).get(name, ()))


def group_of(figure: str) -> str | None:
    """Experiment or part below which a figure has its caption; figures of single trials share one."""
    shared = re.sub(r"^figure_b_([1-9]|1[0-2])$", "figure_b_trial", figure)
    return next((name for name, own in _groups(OF_PROJECT).items() if shared in own), None)


@cache
def _groups(path: Path) -> dict[str, dict[str, str]]:
    """Experiment or part -> name of a figure -> its caption; ``tables`` has those of tables."""
    return yaml.safe_load(path.read_text(encoding="utf-8"))
