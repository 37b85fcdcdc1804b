"""Figures 4-13 and 4-14 of a trial of the standing person."""

from collections.abc import Iterator

from matplotlib.figure import Figure

from tepsipe.io.result import read_result
from tepsipe.reporting.figures.standing import plot_activity, plot_processed


def draw(files, chosen) -> Iterator[tuple[str, Figure]]:
    """Two figures of the responses of a trial."""
    result = read_result(files.responses)
    yield "4_13", plot_processed(result)
    yield "4_14", plot_activity(result)
