"""Captions of figures and tables."""

import re
from functools import cache
from pathlib import Path

from workflow.support.places import ROOT
from workflow.support.yaml_file import read_settings

OF_PROJECT = ROOT / "report" / "captions.yaml"


def read_captions(path: str | Path) -> dict[str, str]:
    """Name of a figure or table -> its caption."""
    return {name: text for group in _groups(Path(path)).values() for name, text in group.items()}


def captions_of(name: str) -> tuple[str, ...]:
    """Captions of the figures of an experiment or part, in the order in which they are shown."""
    return tuple(_groups(OF_PROJECT).get(name, ()))


def caption_of(figure: str) -> str:
    """Name of a figure's caption, which figures of single trials share."""
    return re.sub(r"^figure_b_([1-9]|1[0-2])$", "figure_b_trial", figure)


def group_of(figure: str) -> str | None:
    """Experiment or part below which a figure has its caption; figures of single trials share one."""
    return next((name for name, own in _groups(OF_PROJECT).items() if caption_of(figure) in own), None)


@cache
def _groups(path: Path) -> dict[str, dict[str, str]]:
    """Experiment or part -> name of a figure -> its caption; ``tables`` has those of tables."""
    return read_settings(path)
