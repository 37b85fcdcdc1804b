"""Figure of the forward simulations of one trial (thesis Figures B-1 to B-12)."""

from collections.abc import Iterator

from matplotlib.figure import Figure

from tepsipe.io.result import read_result
from tepsipe.reporting.figures.simulation import plot_angles


def draw(files, chosen) -> Iterator[tuple[str, Figure]]:
    """Swing and angle of one trial (``fit``)."""
    yield "figure_b_trial", plot_angles(read_result(files.fit))
