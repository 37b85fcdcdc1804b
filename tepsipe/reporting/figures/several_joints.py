"""Figure of several joints: what every set of perturbations says, and errors of the elements."""

from collections.abc import Iterator

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from tepsipe.reporting.figures.style import COLOURS, in_style, new_figure

_TICKS = (1.0, 10.0, 100.0, 1e3, 1e4, 1e5, 1e6)


def draw(files, chosen) -> Iterator[tuple[str, Figure]]:
    """Figure of the sets of perturbations and the elements of K."""
    sets, elements = pd.read_csv(files.sets), pd.read_csv(files.elements)
    yield "figure_several_joints", plot_several_joints(sets, elements, chosen.limits["stiffness_percent"])


@in_style
def plot_several_joints(sets: pd.DataFrame, elements: pd.DataFrame, limit_percent: float) -> Figure:
    """Largest interval of an element of K by set of perturbations, and errors of the elements of one set (%).

    ``sets`` and ``elements`` are the tables; ``limit_percent`` is the largest half width of an interval, in
    per cent of sqrt(K_ii K_jj) (%).
    """
    figure, (left, right) = new_figure(1, 2, 3.6, width_ratios=[1.15, 1.0])
    good = (sets.identified.astype(str).str.lower() == "true").to_numpy()
    places = np.arange(len(sets))
    for which, name, colour in ((good, "identified", "compensated"), (~good, "no values", "model")):
        left.plot(
            sets.k_half_width_percent[which],
            places[which],
            "o",
            color=COLOURS[colour],
            markersize=4.0,
            label=name,
        )
    left.axvline(limit_percent, color=COLOURS["other"], linewidth=0.8)
    left.set_xscale("log")
    low, high = sets.k_half_width_percent.min(), sets.k_half_width_percent.max()
    left.set_xlim(0.5 * min(low, limit_percent), 2.0 * high)
    ticks = [tick for tick in _TICKS if 0.5 * low <= tick <= 2.0 * high]
    left.set_xticks(ticks, [f"{tick:,.0f}".replace(",", " ") for tick in ticks])
    left.minorticks_off()
    left.set_yticks(places, [name.replace("+", " + ") for name in sets.perturbations])
    left.set(xlabel="95 % interval of K, ± % of $\\sqrt{K_{ii} K_{jj}}$", ylim=(len(sets) - 0.4, -0.6))
    left.legend(loc="lower right", frameon=True)
    _draw_errors(right, sets, elements)
    return figure


def _draw_errors(axis, sets: pd.DataFrame, elements: pd.DataFrame) -> None:
    """Errors in all recordings, and predicted 95 % intervals, of the set with the narrowest ones."""
    best = sets.loc[sets.k_half_width_percent.idxmin(), "perturbations"]
    own = elements[(elements.perturbations == best) & elements.quantity.str.startswith("K_")]
    places = np.arange(len(own))
    half = 1.96 * own.predicted_u_percent.to_numpy()
    axis.barh(places, 2.0 * half, left=-half, height=0.7, color=COLOURS["window"], linewidth=0.0)
    for place, text in zip(places, own.errors_percent, strict=True):
        errors = [float(x) for x in str(text).split(";") if x and x != "nan"]
        axis.plot(errors, np.full(len(errors), place), "|", color=COLOURS["K"], markersize=8.0)
    axis.axvline(0.0, color=COLOURS["measured"], linewidth=0.6)
    axis.set_yticks(places, [name.removeprefix("K_").replace("_", ", ") for name in own.quantity])
    axis.set(xlabel="error of K, % of $\\sqrt{K_{ii} K_{jj}}$", ylim=(len(own) - 0.4, -0.6))
    axis.set_title(best.replace("+", " + "), loc="left")
