"""Figure of the participants: every person, and the mean over people."""

from collections.abc import Iterator

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from tepsipe.reporting.figures.names import unit_symbol, words
from tepsipe.reporting.figures.style import COLOURS, in_style, new_figure

QUANTITIES = ("K", "B", "K_per_kg")
# of experiments whose joints are several
OF_JOINTS = {"platform": ("K_mode_ankle", "K_mode_hip")}
SYMBOLS = {
    "K": "$K$",
    "B": "$B$",
    "K_per_kg": "$K$ per body mass",
    "K_mode_ankle": "$K$, slow, ankle",
    "K_mode_hip": "$K$, slow, hip",
}
MEAN_BESIDE = 0.24


def draw(files, chosen) -> Iterator[tuple[str, Figure]]:
    """Figure of the tables of participants and of the means over them."""
    text = {"participant": str, "condition": str}
    people, group = (pd.read_csv(path, dtype=text) for path in (files.participants, files.group))
    yield "figure_participants", plot_participants(people, group, chosen.shown)


@in_style
def plot_participants(people: pd.DataFrame, group: pd.DataFrame, shown: dict[str, list[str]]) -> Figure:
    """Dots per person, joined between conditions, and the mean over people with its 95 % interval.

    ``people`` and ``group`` are the tables of participants and of means over them (units in their column
    ``unit``); ``shown`` holds the pathway and estimator of every experiment, one row of panels each.
    """
    alone = [q for q in QUANTITIES if (people.quantity == q).any()] or ["K"]
    quantities = {experiment: OF_JOINTS.get(experiment, alone) for experiment in shown}
    most = max(map(len, quantities.values()))
    figure, axes = new_figure(len(shown), most, 0.5 + 2.7 * len(shown), squeeze=False)
    for row, (experiment, (pathway, estimator)) in enumerate(shown.items()):
        for axis in axes[row, len(quantities[experiment]) :]:
            axis.set_visible(False)
        for axis, quantity in zip(axes[row], quantities[experiment], strict=False):
            own, mean = (
                _chosen(table, experiment, pathway, estimator, quantity) for table in (people, group)
            )
            _draw(axis, own, mean)
            if not own.empty:
                axis.set(ylabel=f"{SYMBOLS[quantity]} ({unit_symbol(own.unit.iloc[0])})")
        axes[row, 0].set_title(
            f"{experiment.replace('_', ' ')}: {words(pathway)}, {words(estimator)}", loc="left"
        )
    return figure


def _chosen(
    table: pd.DataFrame, experiment: str, pathway: str, estimator: str, quantity: str
) -> pd.DataFrame:
    """Rows of one quantity, without differences, with the place of each as a column."""
    rows = table[
        (table.experiment == experiment)
        & (table.pathway == pathway)
        & (table.estimator == estimator)
        & (table.quantity == quantity)
        & ~table.condition.str.contains(" minus ", regex=False)
    ].copy()
    rows["place"] = rows.condition
    if "belt" in rows:
        belts = rows.belt.fillna("")
        rows["place"] = np.where(belts == "", rows.condition, rows.condition + "\n" + belts)
    return rows


def _draw(axis, people: pd.DataFrame, group: pd.DataFrame) -> None:
    if people.empty:
        axis.text(0.5, 0.5, "no estimate", ha="center", va="center", transform=axis.transAxes)
        return
    places = {place: k for k, place in enumerate(dict.fromkeys(group.place))}
    for _, own in people.groupby("participant", sort=True):
        x = [places[place] for place in own.place]
        axis.plot(x, own.value, "o-", color=COLOURS["other"], markersize=3.5, linewidth=0.6)
    for mean in group.itertuples():
        x = places[mean.place] + MEAN_BESIDE
        low = 0.0 if np.isnan(mean.ci_low) else mean.mean - mean.ci_low
        high = 0.0 if np.isnan(mean.ci_high) else mean.ci_high - mean.mean
        axis.errorbar(
            x, mean.mean, [[low], [high]], fmt="s", color=COLOURS["recommended"], markersize=4.5, capsize=3.0
        )
    axis.set_xticks([k + 0.5 * MEAN_BESIDE for k in places.values()], list(places))
    axis.set_xlim(-0.4, len(places) - 1 + MEAN_BESIDE + 0.4)
    axis.grid(axis="x", visible=False)
