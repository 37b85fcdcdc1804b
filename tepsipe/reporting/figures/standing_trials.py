"""Figures 4-13 and 4-14 of every trial of the standing person."""

from collections.abc import Iterator

from matplotlib.figure import Figure

from tepsipe.io.result import read_result
from tepsipe.reporting.figures.standing import plot_activity, plot_processed


def draw(files, chosen) -> Iterator[tuple[str, Figure]]:
    """Two figures of the responses of every trial, named by its condition."""
    for condition, path in zip(chosen.conditions, files.responses, strict=True):
        result = read_result(path)
        yield f"{condition}_4_13", plot_processed(result)
        yield f"{condition}_4_14", plot_activity(result)
