"""Figure of impedance that changes within trials."""

from collections.abc import Iterator

import matplotlib
import numpy as np
from matplotlib.figure import Figure

from tepsipe.experiments.position_manipulator.time_varying import VARYING_ROWS, VaryingRow
from tepsipe.reporting.figures.style import CYCLE, in_style, new_figure

PANELS = {
    "K": "$K$ (N·m/rad)",
    "B": "$B$ (N·m·s/rad)",
    "reflex_gain_ratio": "Reflex gain\n(rel. to trial)",
    "torque": "Mean torque\n(N·m)",
}
AXES = {
    "time": "Time (s)",
    "time after the trigger": "Time after the trigger (s)",
    "schedule": "Schedule",
}
# more trials are drawn without a legend
IN_LEGEND = 18


def draw(files, chosen) -> Iterator[tuple[str, Figure]]:
    """Figure of the table of impedance within trials."""
    yield "figure_time_varying", plot_time_varying(VARYING_ROWS.read(files.table))


@in_style
def plot_time_varying(rows: list[VaryingRow]) -> Figure:
    """K, B, reflex gain and mean torque with intervals, one column per kind of axis (units in the rows)."""
    kinds = [kind for kind in AXES if any(row.over == kind for row in rows)]
    panels = [p for p in PANELS if p == "torque" or any(row.quantity == p for row in rows)]
    if not kinds:
        figure, axis = new_figure(1, 1, 1.2)
        axis.axis("off")
        axis.text(0.5, 0.5, "all trials are too short for windows", ha="center", va="center")
        return figure
    figure, axes = new_figure(
        len(panels), len(kinds), 0.7 + 1.35 * len(panels), squeeze=False, sharex="col", sharey="row"
    )
    colours = _colours(list(dict.fromkeys(row.condition for row in rows)))
    for column, kind in zip(axes.T, kinds, strict=True):
        for condition, colour in colours.items():
            own = [row for row in rows if row.over == kind and row.condition == condition]
            for axis, panel in zip(column, panels, strict=True):
                if own:
                    _draw(axis, own, panel, colour)
        column[-1].set_xlabel(AXES[kind])
    if len(colours) <= IN_LEGEND:
        for condition, colour in colours.items():
            axes[0, 0].plot([], [], ".-", color=colour, label=condition)
        figure.legend(loc="outside upper center", ncols=6, columnspacing=1.2, handlelength=1.4)
    for axis, panel in zip(axes[:, 0], panels, strict=True):
        axis.set_ylabel(PANELS[panel])
    figure.align_ylabels()
    return figure


def _colours(conditions: list[str]) -> dict[str, object]:
    """A colour per trial: those of the report, of many trials a scale."""
    if len(conditions) <= len(CYCLE):
        return dict(zip(conditions, CYCLE, strict=False))
    return dict(
        zip(conditions, matplotlib.colormaps["turbo"](np.linspace(0.05, 0.95, len(conditions))), strict=True)
    )


def _draw(axis, rows: list[VaryingRow], panel: str, colour) -> None:
    if panel == "torque":
        rows = [row for row in rows if row.quantity == "K"]
        axis.plot([row.at for row in rows], [row.torque_Nm for row in rows], ".-", color=colour)
        return
    rows = [row for row in rows if row.quantity == panel]
    at = [row.at for row in rows]
    axis.fill_between(
        at, [r.ci_low for r in rows], [r.ci_high for r in rows], color=colour, alpha=0.15, linewidth=0.0
    )
    axis.plot(at, [row.value for row in rows], ".-", color=colour)
