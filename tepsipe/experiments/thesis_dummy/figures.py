"""Figures of the inverse problem: printed numbers beside the fitted dummy, and fits by lag of the markers."""

from collections.abc import Iterator

import numpy as np
from matplotlib.figure import Figure

from tepsipe.drawing.names import short_name
from tepsipe.drawing.style import COLOURS, in_style, new_figure
from tepsipe.experiments.thesis_dummy.inverse import CELL_ROWS, CellRow
from tepsipe.experiments.thesis_dummy.profile import LIMIT_95, misfit_over_least
from tepsipe.io.result import read_result

PANELS = (
    ("I", r"$I$ (N·m·s²/rad)"),
    ("B", r"$B$ (N·m·s/rad)"),
    ("K", r"$K$ (N·m/rad)"),
    ("VAF_trial", "100 − VAF of the dataset (%)"),
    ("SEM_B", r"SEM of $B$ (N·m·s/rad)"),
    ("SEM_K", r"SEM of $K$ (N·m/rad)"),
)


def draw_thesis_dummy(files, chosen) -> Iterator[tuple[str, Figure]]:
    """Figures of the table of printed and fitted numbers, and of the fits by lag."""
    yield "figure_thesis_dummy", plot_thesis_dummy(CELL_ROWS.read(files.table))
    yield "figure_thesis_timing", plot_thesis_timing(read_result(files.fit).facts)


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


@in_style
def plot_thesis_timing(facts: dict) -> Figure:
    """Fitted B, profile of the misfit, and two VAFs, by lag of the ankle.

    ``facts`` are those of ``fits/thesis_dummy.h5`` (s, N·m·s/rad, %).
    """
    rows = facts["timing"]["lags"]
    misfit = misfit_over_least(facts["timing"])
    lag_ms = [1e3 * row["lag_s"] for row in rows]
    figure, axes = new_figure(2, 2, 3.8, sharex=True)
    damping, profile, unexplained, vaf = axes.flat

    def line(axis, key: str, colour: str, label: str | None = None) -> None:
        axis.plot(lag_ms, [row[key] for row in rows], ".-", color=COLOURS[colour], label=label)

    line(damping, "damping_Nms_per_rad", "recommended")
    damping.set_title(r"fitted $B$ (N·m·s/rad)")
    profile.plot(lag_ms, misfit, ".-", color=COLOURS["recommended"], label="fitted law")
    profile.axhline(LIMIT_95, color=COLOURS["model"], linestyle="--", label="95 % limit")
    profile.set_title(r"$\chi^2$ above its minimum")
    profile.set_ylim(bottom=0.0)
    line(unexplained, "unexplained_percent", "recommended", "fitted law, no noise")
    unexplained.axhline(
        facts["timing"]["printed"]["unexplained_percent"],
        color=COLOURS["measured"],
        linestyle="--",
        label="printed",
    )
    unexplained.set_title("100 − VAF of a perturbation (%)")
    unexplained.set_ylim(bottom=0.0)
    line(vaf, "vaf_wristalyzer", "model", "Wristalyzer")
    line(vaf, "vaf_without_handle", "recommended", "without handle")
    vaf.set_title("VAF of the angle (%)")
    for axis in axes.flat:
        axis.axvline(0.0, color=COLOURS["measured"], linewidth=0.6, linestyle=":")
    for axis in axes[1]:
        axis.set_xlabel("lag of the ankle (ms)")
    unexplained.legend(loc="upper right")
    profile.legend(loc="upper center")
    vaf.legend(loc="lower left")
    return figure
