"""Figure of the inverse problem: printed numbers beside those of the fitted dummy."""

from collections.abc import Iterator

import numpy as np
from matplotlib.figure import Figure

from tepsipe.experiments.thesis_dummy.tables import CELL_ROWS, CellRow
from tepsipe.reporting.figures.names import short_name
from tepsipe.reporting.figures.style import COLOURS, in_style, new_figure

PANELS = (
    ("I", r"$I$ (N·m·s²/rad)"),
    ("B", r"$B$ (N·m·s/rad)"),
    ("K", r"$K$ (N·m/rad)"),
    ("VAF_trial", "100 − VAF of the dataset (%)"),
    ("SEM_B", r"SEM of $B$ (N·m·s/rad)"),
    ("SEM_K", r"SEM of $K$ (N·m/rad)"),
)


def draw(files, chosen) -> Iterator[tuple[str, Figure]]:
    """Figure of the table of printed and fitted numbers."""
    yield "figure_thesis_dummy", plot_thesis_dummy(CELL_ROWS.read(files.table))


@in_style
def plot_thesis_dummy(rows: list[CellRow]) -> Figure:
    """Printed numbers and those of the fitted dummy by condition (units on the axes)."""
    conditions = list(dict.fromkeys(row.condition for row in rows))
    figure, axes = new_figure(2, 3, 3.8, sharex=True)
    for axis, (quantity, label) in zip(axes.flat, PANELS, strict=True):
        own = {row.condition: row for row in rows if row.quantity == quantity}
        places = [k for k, name in enumerate(conditions) if name in own]
        shown = [own[conditions[k]] for k in places]
        if quantity.startswith("VAF"):
            printed, values = ([100.0 - getattr(r, key) for r in shown] for key in ("printed", "value"))
            axis.set_yscale("log")
        else:
            printed, values = ([getattr(r, key) for r in shown] for key in ("printed", "value"))
        fitted = np.array([row.role == "fitted" for row in shown], dtype=bool)
        places, values = np.array(places), np.array(values)
        axis.plot(places, printed, "o", color=COLOURS["measured"], markersize=4, label="thesis")
        for chosen, colour, name in (
            (fitted, COLOURS["recommended"], "dummy, fitted"),
            (~fitted, COLOURS["model"], "dummy, predicted"),
        ):
            axis.plot(places[chosen], values[chosen], "_", color=colour, markersize=11, mew=2.2, label=name)
        if quantity == "I":
            axis.set_ylim(0.0, 1.25 * max(printed))
        axis.set_title(label)
        axis.set_xticks(range(len(conditions)), [short_name(name) for name in conditions], rotation=90)
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=3)
    return figure
