"""Figures of the coverage study: share of intervals that hold the truth, and the intervals themselves."""

from collections.abc import Iterator

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from tepsipe.reporting.coverage import SHIFTED
from tepsipe.reporting.figures.names import words
from tepsipe.reporting.figures.style import COLOURS, in_style, new_figure

MOST_PANELS = 8
TEXT = {"condition": str, "flags": str}
ROOM = 1.5  # beyond the 98 % quantile of what is drawn


def draw(files, chosen) -> Iterator[tuple[str, Figure]]:
    """Figures of the tables of the coverage and of all estimates."""
    coverage, outcomes = (pd.read_csv(path, dtype=TEXT) for path in (files.coverage, files.outcomes))
    yield "figure_coverage", plot_coverage(coverage, chosen.first)
    yield "figure_coverage_intervals", plot_intervals(outcomes, chosen.first)


@in_style
def plot_coverage(coverage: pd.DataFrame, first: str) -> Figure:
    """Coverage (%) of every recommended estimate with its 95 % interval, nominal and shifted laboratories.

    ``coverage`` is the table of the coverage (units in its columns), ``first`` the nominal set.
    """
    quoted = coverage[coverage.recommended.astype(bool) & coverage.coverage.notna()]
    names = list(dict.fromkeys(_name(row) for row in quoted.itertuples()))
    figure, axis = new_figure(1, 1, 0.9 + 0.34 * max(1, len(names)))
    axis.axvline(95.0, color=COLOURS["other"], linewidth=0.8)
    for mechanism, beside, colour in ((first, -0.13, "recommended"), (SHIFTED, 0.13, "as printed")):
        rows = quoted[quoted.mechanism == mechanism]
        if rows.empty:
            continue
        share = 100.0 * rows.coverage.to_numpy()
        ends = 100.0 * rows[["coverage_low", "coverage_high"]].to_numpy()
        places = np.array([names.index(_name(row)) for row in rows.itertuples()]) + beside
        errors = [np.maximum(share - ends[:, 0], 0.0), np.maximum(ends[:, 1] - share, 0.0)]
        axis.errorbar(
            share,
            places,
            xerr=errors,
            fmt="o",
            markersize=3.5,
            capsize=2.5,
            color=COLOURS[colour],
            label=mechanism,
        )
    axis.set_yticks(range(len(names)), names)
    axis.set(xlabel="coverage (%)", ylim=(len(names) - 0.4, -0.6))
    axis.grid(axis="y", visible=False)
    if names:
        figure.legend(loc="outside upper right", ncols=2)
    return figure


def _name(row) -> str:
    return f"{row.experiment}, {words(row.pathway)}, {words(row.estimator)}: {row.quantity}"


@in_style
def plot_intervals(outcomes: pd.DataFrame, first: str) -> Figure:
    """Intervals of the recommended K and mass against the truth (%), sorted by their errors.

    ``outcomes`` is the table of all estimates with their truth (units in its column ``unit``), ``first`` the
    nominal set. Intervals that miss the truth are drawn dark.
    """
    quoted = outcomes[
        outcomes.recommended.astype(bool)
        & outcomes.quantity.isin(["K", "B", "mass"])
        & (outcomes.truth != 0.0)
    ]
    quoted = quoted[quoted[["value", "ci_low", "ci_high"]].notna().all(axis=1)]
    groups = list(quoted.groupby(["experiment", "pathway", "estimator", "quantity"], sort=False))[
        :MOST_PANELS
    ]
    rows = max(1, -(-len(groups) // 2))
    figure, axes = new_figure(rows, 2, 0.4 + 2.1 * rows, squeeze=False)
    for axis in axes.flat[len(groups) :]:
        axis.set_axis_off()
    for axis, ((experiment, pathway, _, quantity), own) in zip(axes.flat, groups, strict=False):
        _draw_intervals(axis, own, first)
        axis.set_title(f"{experiment}, {words(pathway)}: {quantity}", loc="left")
        axis.set(ylabel="from the truth (%)", xlabel="estimates, by error")
    return figure


def _draw_intervals(axis, own: pd.DataFrame, first: str) -> None:
    scale = 100.0 / own.truth.abs()
    value, low, high = ((own[name] - own.truth) * scale for name in ("value", "ci_low", "ci_high"))
    order = np.argsort(value.to_numpy(), kind="stable")
    place = np.empty(len(own))
    place[order] = np.arange(len(own))
    nominal, missed = (own.mechanism == first).to_numpy(), ((low > 0.0) | (high < 0.0)).to_numpy()
    kinds = (
        (nominal & ~missed, "compensated too"),
        (~nominal & ~missed, "other too"),
        (nominal & missed, "recommended"),
        (~nominal & missed, "as printed"),
    )
    for chosen, colour in kinds:
        axis.vlines(place[chosen], low[chosen], high[chosen], color=COLOURS[colour], linewidth=1.0)
    axis.plot(place, value, ".", color=COLOURS["measured"], markersize=2.0)
    axis.axhline(0.0, color=COLOURS["measured"], linewidth=0.6)
    limit = ROOM * float(np.quantile(np.abs(np.concatenate([low, high])), 0.98))
    if limit > 0.0:
        axis.set_ylim(-limit, limit)
    axis.grid(axis="x", visible=False)
