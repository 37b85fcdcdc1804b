"""A cross-validation as a map (thesis Figure 4-3)."""

import numpy as np
from matplotlib.figure import Figure

from tepsipe.reporting.figures.style import in_style, new_figure


@in_style
def plot_matrix(matrix: np.ndarray, names: list[str], what: str, labels: tuple[str, str]) -> Figure:
    """Cross-validation as a map of VAF (%)."""
    size = len(names)
    figure, axes = new_figure(height_in=2.3 if size < 8 else 3.2)
    image = axes.imshow(matrix, cmap="cividis", aspect="auto")
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
                fontsize=8.5 if size < 8 else 6.5,
            )
    axes.set(ylabel=labels[0], xlabel=labels[1])
    figure.colorbar(image, ax=axes, label=what)
    return figure
