"""Figure of the dummy's parameters from several pathways side by side."""

from collections.abc import Collection, Mapping

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tepsipe.io.result import Result
from tepsipe.mechanics.impedance_model import PARAMETERS, UNITS
from tepsipe.reporting.figures.names import short_name, unit_symbol, words
from tepsipe.reporting.figures.style import COLOURS, in_style, new_figure

# an axis goes beyond the values that it must show by this part of their range (-)
MARGIN = 0.35


def draw_truth(axis: Axes, x: np.ndarray, values: np.ndarray, half_width: float = 0.36) -> None:
    """A short line at every true value (unit of the axis)."""
    look = {"color": COLOURS["measured"], "linewidth": 1.3, "zorder": 4}
    axis.hlines(values, x - half_width, x + half_width, label="true", **look)


@in_style
def plot_pathways(
    results: dict[str, Result],
    colours: dict[str, str],
    truth: Mapping[str, np.ndarray],
    usable: Collection[str] | None = None,
) -> Figure:
    """Mean I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad) of every pathway with 95 % intervals.

    results: condition -> its result.
    colours: pathway -> name of its colour.
    truth: quantity -> true values, condition by condition (unit of the quantity); empty without any.
    usable: pathways whose values determine the axes, by default all; a triangle marks a value beyond them.
    Returns: A panel for each quantity.
    """
    figure, axes = new_figure(3, 1, 3.9, sharex=True)
    x = np.arange(len(results))
    shifts = np.linspace(-0.22, 0.22, len(colours))
    for k, (axis, quantity) in enumerate(zip(axes, PARAMETERS, strict=True)):
        shown = _shown_range(results, usable or colours, k, truth.get(quantity))
        for shift, pathway in zip(shifts, colours, strict=True):
            intervals = [result.arrays[f"{pathway}/mean_and_interval"] for result in results.values()]
            value, low, high = np.array(intervals)[:, :, k].T
            look = {"color": COLOURS[colours[pathway]], "markersize": 3.4}
            for beyond, edge, mark in ((value < shown[0], shown[0], "v"), (value > shown[1], shown[1], "^")):
                axis.plot((x + shift)[beyond], np.full(beyond.sum(), edge), mark, **look)
            error = [value - low, high - value]
            label = words(pathway)
            axis.errorbar(x + shift, value, error, fmt="o", linewidth=0.9, capsize=1.8, label=label, **look)
        if truth:
            draw_truth(axis, x, truth[quantity])
        axis.set_ylabel(f"${quantity}$ ({unit_symbol(UNITS[quantity])})")
        axis.set_ylim(shown[0] - 0.03 * np.ptp(shown), shown[1] + 0.03 * np.ptp(shown))
        axis.set_xticks(np.arange(len(results) + 1) - 0.5, minor=True)
        axis.grid(axis="x", visible=False)
        axis.grid(axis="x", which="minor", color="#d4d4d4", linewidth=0.5)
        axis.tick_params(axis="x", which="both", length=0.0)
    handles, names = axes[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=3)
    axes[2].set_xticks(x, [short_name(name) for name in results])
    axes[2].set_xlabel("Perturbation profile and velocity amplitude")
    figure.align_ylabels()
    return figure


def _shown_range(
    results: dict[str, Result], pathways: Collection[str], k: int, truth: np.ndarray | None
) -> tuple[float, float]:
    """Ends of an axis with all values of some pathways and the true ones (unit of the quantity)."""
    values = [float(r.arrays[f"{p}/mean_and_interval"][0, k]) for r in results.values() for p in pathways]
    values += [] if truth is None else [float(value) for value in truth if np.isfinite(value)]
    margin = MARGIN * (max(values) - min(values))
    return min(values) - margin, max(values) + margin
