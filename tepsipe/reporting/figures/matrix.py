"""Maps of VAF with their numbers (thesis Figures 4-3, 4-10 and 4-11)."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tepsipe.reporting.figures.style import SMALLEST_PT, in_style, new_figure

MAP = "cividis"


@in_style
def plot_matrix(matrix: np.ndarray, names: list[str], what: str, labels: tuple[str, str]) -> Figure:
    """Cross-validation as a map of VAF (%)."""
    size = len(names)
    figure, axes = new_figure(height_in=2.3 if size < 8 else 3.2)
    image = axes.imshow(matrix, cmap=MAP, aspect="auto")
    axes.set_xticks(range(size), names, rotation=45 if size > 8 else 0, ha="right" if size > 8 else "center")
    axes.set_yticks(range(size), names)
    axes.grid(False)
    middle = 0.5 * (matrix.max() + matrix.min())
    digits = 0 if np.ptp(matrix) > 3.0 else 2
    for row in range(size):
        for column in range(size):
            value = matrix[row, column]
            colour = "black" if value > middle else "white"
            axes.text(
                column,
                row,
                f"{value:.{digits}f}",
                ha="center",
                va="center",
                color=colour,
                fontsize=8.5 if size < 8 else SMALLEST_PT,
            )
    axes.set(ylabel=labels[0], xlabel=labels[1])
    figure.colorbar(image, ax=axes, label=what)
    return figure


def draw_vafs(axis: Axes, vafs: np.ndarray, fontsize: float = SMALLEST_PT) -> None:
    """Numbers on a map of VAF from 0 to 100 %; cells below 0 are white, those without a number have a dash.

    ``vafs`` has a row for every row of the map (%).
    """
    shown = np.ma.masked_less(np.ma.masked_invalid(vafs), 0.0)
    axis.imshow(shown, cmap=MAP, vmin=0.0, vmax=100.0, aspect="auto")
    for (row, column), value in np.ndenumerate(vafs):
        dark = 0.0 <= value < 55.0
        axis.text(
            column,
            row,
            _vaf(value),
            ha="center",
            va="center_baseline",
            color="white" if dark else "black",
            fontsize=fontsize,
        )
    axis.grid(visible=False)
    axis.tick_params(length=0.0)


def _vaf(value: float) -> str:
    if not np.isfinite(value):
        return "\N{EN DASH}"
    if value <= -1e5:
        exponent = int(np.floor(np.log10(-value)))
        return rf"$-10^{{{exponent}}}$"
    return f"{value:.0f}".replace("-0", "0").replace("-", "\N{MINUS SIGN}")
