"""Specification curve of the ankle dummy: I, B, K by every combination of choices (thesis Appendix A)."""

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tepsipe.experiments.dummy.specification_curve import (
    AS_PRINTED,
    CHOICES,
    FILTERED,
    NONE,
    RECOMMENDED,
    REFERENCES,
    TORQUES,
    WHOLE_TRIAL,
    WINDOWS,
    Specification,
)
from tepsipe.identification.estimators import ESTIMATORS, OUTPUT_ERROR
from tepsipe.mechanics.impedance_model import UNITS
from tepsipe.reporting.figures.names import short_name, unit_symbol, words
from tepsipe.reporting.figures.style import COLOURS, in_style, legend_above, new_figure

# rows of a choice that have a given order; filters are sorted, none last
_ORDER = {
    "torque": TORQUES,
    "filtered": FILTERED,
    "reference": REFERENCES,
    "window": (*WINDOWS, WHOLE_TRIAL),
    "estimator": tuple(ESTIMATORS),
}
_TITLES = {
    "torque": "Torque",
    "filter": "Filter",
    "filtered": "Filtered signals",
    "reference": "Rest",
    "window": "Window",
    "estimator": "Estimator",
}
# a combination is not recommended: the estimate to quote needs no choice of these
_ROLES = {RECOMMENDED: "consistent regression"}
_SHOWN = {"K": (-10.0, 25.0), "B": (-0.3, 0.6)}  # N·m/rad, N·m·s/rad


@in_style
def plot_specification(rows: list[Specification], quoted: float | None = None) -> Figure:
    """K (N·m/rad) and B (N·m·s/rad) of every specification, sorted by K, and its choices.

    Values beyond the axes are triangles at their edge. ``quoted`` is the trial's recommended K (N·m/rad).
    """
    levels = _levels(rows)
    figure, (top, middle, below) = new_figure(
        3,
        1,
        5.9,
        sharex=True,
        height_ratios=[2.4, 1.3, 0.19 * sum(1 + len(names) for names in levels.values())],
    )
    x = np.arange(len(rows))
    roles = {
        AS_PRINTED: [k for k, row in enumerate(rows) if row.role == AS_PRINTED],
        RECOMMENDED: [k for k, row in enumerate(rows) if row.role == RECOMMENDED],
        OUTPUT_ERROR: [k for k, row in enumerate(rows) if row.estimator == OUTPUT_ERROR],
    }
    colours = {AS_PRINTED: "as printed", RECOMMENDED: "recommended", OUTPUT_ERROR: "compensated"}
    for axis, quantity, values in (
        (top, "K", np.array([row.K_Nm_per_rad for row in rows])),
        (middle, "B", np.array([row.B_Nms_per_rad for row in rows])),
    ):
        _draw_values(axis, quantity, x, values, COLOURS["other"], 2.5)
        for role, chosen in roles.items():
            colour = COLOURS[colours[role]]
            _draw_values(axis, quantity, x[chosen], values[chosen], colour, 26.0, _label(role, rows, chosen))
        axis.set_ylabel(f"${quantity}$ ({unit_symbol(UNITS[quantity])})")
    for value in [quoted] if quoted else [rows[k].K_Nm_per_rad for k in roles[RECOMMENDED]]:
        label = f"within 5 % of the recommended $K$ = {value:.2f} N·m/rad"
        top.axhspan(0.95 * value, 1.05 * value, color=COLOURS["window"], zorder=0, label=label)
    legend_above(figure, top, 2)
    _draw_choices(below, rows, levels, {k: COLOURS[colours[r]] for r, found in roles.items() for k in found})
    for role in (AS_PRINTED, RECOMMENDED):
        for chosen in roles[role]:
            for axis in (top, middle, below):
                axis.axvline(chosen, color=COLOURS[role], linewidth=0.5, alpha=0.7, zorder=0)
    below.set_xlabel(f"Combinations of choices for {short_name(rows[0].condition)}, sorted by $K$")
    below.set_xlim(-3, len(rows) + 2)
    figure.align_ylabels([top, middle])
    return figure


def _label(role: str, rows: list[Specification], chosen: list[int]) -> str:
    values = [rows[k].K_Nm_per_rad for k in chosen]
    if not values:
        return _ROLES.get(role, words(role))
    low, high = min(values), max(values)
    range_of_k = f"{low:.2f}" if len(values) == 1 else f"{low:.2f} to {high:.2f}"
    return f"{_ROLES.get(role, words(role))}: $K$ = {range_of_k} N·m/rad"


def _draw_values(
    axis: Axes, quantity: str, x: np.ndarray, values: np.ndarray, colour: str, size: float, label=None
) -> None:
    low, high = _SHOWN[quantity]
    inside = (values >= low) & (values <= high)
    line = {"color": colour, "linewidths": 0.0, "zorder": 2 + (label is not None)}
    axis.scatter(x[inside], values[inside], s=size, label=label, **line)
    margin = 0.03 * (high - low)
    for beyond, edge, marker in ((values < low, low, "v"), (values > high, high, "^")):
        axis.scatter(x[beyond], np.full(beyond.sum(), edge), s=max(size, 7.0), marker=marker, **line)
    axis.set_ylim(low - margin, high + margin)


def _levels(rows: list[Specification]) -> dict[str, list[str]]:
    """Choice -> its values in the order of the figure, without the missing ones of a specification."""
    levels = {}
    for k, choice in enumerate(CHOICES):
        found = sorted({row.choices[k] for row in rows}, key=lambda name: (name == NONE, name))
        order = _ORDER.get(choice, ())
        wanted = [*(name for name in order if name in found), *(name for name in found if name not in order)]
        levels[choice] = [name for name in wanted if name != NONE or choice == "filter"]
    return levels


def _draw_choices(
    axis: Axes, rows: list[Specification], levels: dict[str, list[str]], marked: dict[int, str]
) -> None:
    places, labels, titles, y = [], [], [], 0.0
    for k, (choice, names) in enumerate(levels.items()):
        titles.append((y, _TITLES[choice]))
        y += 1.0
        for name in names:
            own = [i for i, row in enumerate(rows) if row.choices[k] == name]
            plain = [i for i in own if i not in marked]
            axis.vlines(plain, y - 0.36, y + 0.36, color=COLOURS["measured"], linewidth=0.45)
            for i in own:
                if i in marked:
                    axis.vlines(i, y - 0.46, y + 0.46, color=marked[i], linewidth=1.6, zorder=3)
            places.append(y)
            labels.append(words(name))
            y += 1.0
    axis.set_yticks(places, labels, fontsize=7.5)
    for place, title in titles:
        axis.annotate(
            title,
            (0.0, place),
            xycoords=("axes fraction", "data"),
            xytext=(-6, 0),
            textcoords="offset points",
            ha="right",
            va="center",
            fontsize=8.0,
            fontweight="bold",
        )
    axis.tick_params(axis="y", length=0)
    axis.grid(visible=False)
    axis.set_ylim(y - 0.4, -0.6)
