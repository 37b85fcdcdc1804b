"""Figure of the dummy's parameters from several pathways side by side."""

import numpy as np
from matplotlib.figure import Figure

from tepsipe.io.result import Result
from tepsipe.mechanics.impedance_model import PARAMETERS, UNITS
from tepsipe.reporting.figures.names import short_name, unit_symbol, words
from tepsipe.reporting.figures.style import COLOURS, in_style, new_figure


@in_style
def plot_pathways(results: dict[str, Result], colours: dict[str, str]) -> Figure:
    """Mean I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad) of every pathway with 95 % intervals.

    ``colours`` maps names of pathways to names of colours.
    """
    figure, axes = new_figure(3, 1, 3.6, sharex=True)
    x = np.arange(len(results))
    shifts = np.linspace(-0.22, 0.22, len(colours))
    for k, (axis, quantity) in enumerate(zip(axes, PARAMETERS, strict=True)):
        for shift, pathway in zip(shifts, colours, strict=True):
            intervals = [result.arrays[f"{pathway}/mean_and_interval"] for result in results.values()]
            value, low, high = np.array(intervals)[:, :, k].T
            axis.errorbar(
                x + shift,
                value,
                yerr=[value - low, high - value],
                fmt="o",
                markersize=3.2,
                linewidth=0.9,
                capsize=1.8,
                color=COLOURS[colours[pathway]],
                label=words(pathway),
            )
        axis.set_ylabel(f"${quantity}$ ({unit_symbol(UNITS[quantity])})")
        low, high = _range_of_values(results, colours, k)
        bottom, top = axis.get_ylim()
        axis.set_ylim(max(bottom, low), min(top, high))
    handles, names = axes[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=3)
    axes[2].set_xticks(x, [short_name(name) for name in results])
    axes[2].set_xlabel("Perturbation profile and velocity amplitude")
    figure.align_ylabels()
    return figure


def _range_of_values(results: dict[str, Result], pathways, k: int) -> tuple[float, float]:
    """Axis that shows every value of a quantity (its unit); wide intervals run out of it."""
    values = [float(r.arrays[f"{p}/mean_and_interval"][0, k]) for r in results.values() for p in pathways]
    margin = 0.3 * (max(values) - min(values))
    return min(values) - margin, max(values) + margin
