"""Figure of springs."""

from collections.abc import Iterator

from matplotlib.figure import Figure

from tepsipe.drawing.style import in_style, new_figure
from tepsipe.io.estimates import ESTIMATES, Estimate


def draw_toy(files, chosen) -> Iterator[tuple[str, Figure]]:
    """Figure of the estimates of all trials."""
    yield (
        "figure_toy_stiffness",
        plot_stiffness([row for path in files.estimates for row in ESTIMATES.read(path)]),
    )


@in_style
def plot_stiffness(rows: list[Estimate]) -> Figure:
    """Stiffness of every trial (N·m/rad)."""
    figure, axes = new_figure(1, 1, 2.0)
    axes.plot([row.value for row in rows], "o", label="stiffness")
    axes.set_ylabel("Stiffness (N·m/rad)")
    return figure
