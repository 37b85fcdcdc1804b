"""Figure of the ankle's stiffness in walking."""

from collections.abc import Iterator

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from tepsipe.drawing.style import CYCLE, in_style, new_figure

NAMES = {"state": "matched", "mean": "plain mean"}
TEXT = {"condition": str}


def draw_walking(files, chosen) -> Iterator[tuple[str, Figure]]:
    """Figure of the study; resampled strides of simulated trials are alike, and need fewer than real ones."""
    rows, needed = (pd.read_csv(path, dtype=TEXT) for path in (files.rows, files.needed))
    recovery = pd.read_csv(files.recovery, dtype=TEXT) if files.recovery else None
    yield "figure_walking", plot_walking(rows, needed[~needed.condition.isin(chosen.simulated)], recovery)


@in_style
def plot_walking(rows: pd.DataFrame, needed: pd.DataFrame, recovery: pd.DataFrame | None = None) -> Figure:
    """K (N·m/rad) over stance with its intervals, and strides for a standard uncertainty of 15 % of K.

    ``rows``, ``needed`` and ``recovery`` are the tables of the study (units in their columns). Phases without
    a finite interval are left blank; crosses are the truth of simulated trials.
    """
    figure, (left, right) = new_figure(1, 2, 3.0)
    of_k = rows[(rows.quantity == "K") & np.isfinite(rows.ci_low.astype(float))]
    for colour, (condition, own) in zip(CYCLE, of_k.groupby("condition", sort=False), strict=False):
        ends = [own.value - own.ci_low, own.ci_high - own.value]
        left.errorbar(own.at_percent, own.value, yerr=ends, fmt="o-", color=colour, label=condition)
        if recovery is not None:
            true = recovery[(recovery.condition == condition) & (recovery.quantity == "K")]
            left.plot(own.at_percent[: len(true)], true.truth, "x", color=colour)
    if of_k.empty:
        left.set_yticks([])
        left.text(
            0.5,
            0.5,
            "no response of the angle:\nall intervals are infinite",
            ha="center",
            va="center",
            transform=left.transAxes,
        )
    else:
        left.legend(loc="upper left")
    left.set(xlabel="stance (%)", ylabel="K (N·m/rad)", xlim=(0.0, 100.0))
    marks = {"state": "-", "mean": "--"}
    for colour, (condition, trial) in zip(CYCLE, needed.groupby("condition", sort=False), strict=False):
        for matching, own in trial.groupby("matching", sort=False):
            label = f"{condition}, {NAMES[matching]}"
            right.semilogy(
                own.phase_percent,
                own.strides_for_15_percent,
                marks[matching],
                marker="o",
                color=colour,
                markersize=3.5,
                label=label,
            )
    ticks = [
        t for t in (1, 3, 10, 30, 100, 300, 1000, 3000) if t <= 3.0 * needed.strides_for_15_percent.max()
    ]
    right.set_yticks(ticks, [str(t) for t in ticks])
    right.minorticks_off()
    right.set(xlabel="stance (%)", ylabel="strides for 15 % of K", xlim=(0.0, 100.0))
    right.legend(loc="upper right")
    return figure
