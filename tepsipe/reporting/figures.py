"""Figures that belong to no single experiment.

The thesis's idea, the rigs and the time lines of the trials (thesis Figures 1-1, 1-3, 2-8, 2-11, 2-12 and
2-14); uncertainty budgets, source by source; the participants and their mean; the share of intervals that
hold the truth in the coverage study, and the intervals themselves.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from textwrap import fill

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tepsipe.drawing.names import short_name, words
from tepsipe.drawing.style import COLOURS, SMALLEST_PT, Drawing, in_style, new_figure
from tepsipe.io.estimates import CONTRIBUTIONS, ESTIMATES
from tepsipe.io.result import read_result
from tepsipe.io.trial import Trial, read_trial
from tepsipe.quantities import unit_symbol
from tepsipe.reporting.budgets import SHOWN as OF_BUDGETS
from tepsipe.reporting.budgets import RelativeBudget, budgeted, relative_budgets, source_words
from tepsipe.reporting.coverage import SHIFTED
from tepsipe.statistics.uncertainty import SCATTER

# beginning of a trial, before the first perturbation, over which markers are averaged (s)
REST_S = 2.0


def draw_rigs(files, chosen) -> Iterator[tuple[str, Figure | Drawing]]:
    """Figures of one trial of each rig, and of the perturbations of all of them."""
    markers: dict[str, list] = {"wristalyzer": []} if chosen.time_lines.get("wristalyzer") else {}
    for experiment, path in zip(chosen.trials, files.trials, strict=True):
        markers[experiment] = markers_at_rest(read_trial(path))
    rigs = {"markers": markers, "geometry": chosen.geometry, "person": chosen.person}
    onsets = _onsets(files, chosen)
    lines = {
        experiment: [
            TimeLine(short_name(c), duration, onsets.get((experiment, c)), amplitude)
            for c, duration, amplitude in trials
        ]
        for experiment, trials in chosen.time_lines.items()
    }
    chain = {
        "plate_rate_hz": chosen.rate_hz,
        "sampling_hz": chosen.sampling_hz,
        "cutoff_hz": chosen.cutoff_hz,
        "emg": bool(chosen.standing),
    }
    source = files.drawings[0]
    yield "figure_1_1", Drawing(source, {})
    yield "figure_1_3", Drawing(source, {"methods": chosen.methods})
    yield "figure_rigs", Drawing(source, rigs | {"mass_kg": chosen.mass_kg})
    yield "figure_protocol", draw_protocol(lines)
    yield "figure_signal_chain", Drawing(source, chain)
    yield "figure_free_bodies", Drawing(source, {})


def markers_at_rest(trial: Trial) -> list[tuple[int, float, float]]:
    """Number in the order of sampling, y from the ankle (or the mean), z (m) of each marker seen at rest."""
    positions = trial.values("marker_position")[: round(REST_S * trial.rate_hz), :, 1:]
    seen = np.flatnonzero(np.isfinite(positions).any(axis=0).all(axis=1)).tolist()
    points = dict(zip(seen, np.nanmean(positions[:, seen], axis=0).tolist(), strict=True))
    ankle = [points[k][0] for k in seen if trial.axes["marker"][k] == "ankle"]
    middle = np.mean(ankle or [y for y, _ in points.values()])
    return [(k + 1, float(y - middle), z) for k, (y, z) in points.items()]


def _onsets(files, chosen) -> dict[tuple[str, str], np.ndarray]:
    """(experiment, condition) -> onsets of the perturbations (s), of trials with fits or epochs."""
    onsets = {}
    for (experiment, condition), path in zip(chosen.fitted, files.fits, strict=True):
        arrays = read_result(path).arrays
        begins = arrays["windows"][:, 0] if experiment == "dummy" else arrays["onsets"]
        onsets[experiment, condition] = begins / chosen.rate_hz
    for condition, path in zip(chosen.standing, files.epochs, strict=True):
        onsets["standing", condition] = read_result(path).arrays["onsets_s"]
    return onsets


TITLES = {
    "wristalyzer": "Wristalyzer",
    "dummy": "Dummy",
    "weight": "Weight",
    "empty": "Empty belt",
    "standing": "Standing person",
}
# amplitude (m/s) whose tick is as high as its row
FULL = 0.5


@dataclass(frozen=True)
class TimeLine:
    """One trial of a protocol."""

    label: str
    """How the figure calls it."""
    duration_s: float
    """Duration of the trial."""
    onsets_s: Sequence[float] | None
    """Beginning of every perturbation (s); None if the perturbation lasts for the whole trial."""
    amplitude: float | None = None
    """Peak belt velocity (m/s), negative for pulses that begin backwards; None if unknown."""


@in_style
def draw_protocol(protocol: Mapping[str, Sequence[TimeLine]]) -> Figure:
    """The trials of every experiment, a row each, with a tick at every perturbation.

    ``protocol`` maps experiments to their trials; the height of a tick is the amplitude (m/s, full row: 0.5).
    """
    shown = [name for name in TITLES if protocol.get(name)]
    sizes = np.cumsum([len(protocol[name]) + 2 for name in shown])
    split = int(np.argmin(np.abs(sizes - 0.5 * sizes[-1]))) + 1
    columns = [column for column in (shown[:split], shown[split:]) if column]
    rows = max(sum(len(protocol[name]) + 2 for name in column) for column in columns)
    figure, axes = new_figure(1, len(columns), 0.122 * rows + 0.6, squeeze=False)
    for axis, column in zip(axes[0], columns, strict=True):
        _column(axis, [(TITLES[name], protocol[name]) for name in column], rows)
    return figure


def _column(axis: Axes, groups: list[tuple[str, Sequence[TimeLine]]], rows: int) -> None:
    y, ticks, labels = 0.0, [], []
    longest = max(line.duration_s for _, lines in groups for line in lines)
    for title, lines in groups:
        y += 1.7
        axis.text(0.0, -y + 0.2, title, fontsize=8.5, weight="bold", va="center")
        for line in lines:
            y += 1.0
            ticks.append(-y)
            labels.append(line.label)
            axis.plot([0.0, line.duration_s], [-y, -y], color="#bbbbbb", linewidth=0.6)
            if line.onsets_s is None:
                axis.fill_between([0.0, line.duration_s], -y - 0.25, -y + 0.25, color=COLOURS["recommended"])
                continue
            amplitude = FULL if line.amplitude is None else line.amplitude
            colour = COLOURS["recommended"] if amplitude >= 0.0 else COLOURS["model"]
            height = 0.45 * abs(amplitude) / FULL
            axis.vlines(np.asarray(line.onsets_s), -y - height, -y + height, color=colour, linewidth=1.0)
    axis.set_yticks(ticks, labels, fontsize=SMALLEST_PT)
    axis.tick_params(axis="y", length=0.0, pad=1.0)
    axis.set(xlabel="Time (s)", ylim=(-rows - 0.6, 0.2), xlim=(-0.01 * longest, 1.01 * longest))
    axis.grid(visible=False, axis="y")
    axis.spines["left"].set_visible(False)


# sources below this part of the largest (-) are drawn together
SMALL = 0.2
# an axis ends at this multiple of the typical combined uncertainty (-); a triangle marks what lies beyond
MOST_SHOWN = 3.5
TYPE_COLOURS = {"A": COLOURS["recommended"], "B": "#e69f00", "combined": "#4b4b4b"}


def draw_budgets(files, chosen) -> Iterator[tuple[str, Figure]]:
    """Uncertainty budget of each of the ``names``: experiments, and the dummy's foot."""
    contributions = CONTRIBUTIONS.read(files.uncertainty)
    own = budgeted(ESTIMATES.read(files.estimates), chosen.foot_pathway)
    for name in chosen.names:
        budgets = relative_budgets(contributions, own.get(name, []), OF_BUDGETS)
        yield f"figure_budget_{name}", plot_budgets(budgets)


def bars_of(budget: RelativeBudget) -> list[tuple[str, str, np.ndarray]]:
    """Label, type and percentages of every trial (%) of the bars: combined, Type A, then Type B by size.

    Small sources of Type B are one bar.
    """
    largest = max(float(np.nanmedian(x)) for x in budget.percent.values())
    bars = [("combined", "combined", budget.combined)]
    if SCATTER in budget.percent:
        bars.append((source_words(SCATTER), "A", budget.type_a))
    of_type_b = [name for name in budget.by_size if name != SCATTER]
    large = [name for name in of_type_b if float(np.nanmedian(budget.percent[name])) >= SMALL * largest]
    small = [name for name in of_type_b if name not in large]
    if len(small) == 1:
        large, small = [*large, *small], []
    bars += [(source_words(name), "B", budget.percent[name]) for name in large]
    if small:
        squares = [np.nan_to_num(budget.percent[name]) ** 2 for name in small]
        bars.append((f"{len(small)} further sources", "B", np.sqrt(np.sum(squares, axis=0))))
    return bars


@in_style
def plot_budgets(budgets: dict[str, RelativeBudget]) -> Figure:
    """Standard uncertainty of every source, median over trials and range (% of the estimate).

    Without any budget, because nothing is recommended, the figure says so.
    """
    if not budgets:
        figure, axes = new_figure(1, 1, 0.9)
        axes.set_axis_off()
        axes.text(0.5, 0.5, "No estimate is recommended: no budget.", ha="center", va="center")
        return figure
    drawn = {quantity: bars_of(budget) for quantity, budget in budgets.items()}
    most = max(len(bars) for bars in drawn.values())
    figure, axes = new_figure(1, len(drawn), 0.9 + 0.25 * most, squeeze=False)
    for axis, (quantity, bars) in zip(axes[0], drawn.items(), strict=True):
        most_shown = MOST_SHOWN * float(np.nanmedian(bars[0][2]))
        for place, (_, kind, percent) in enumerate(bars):
            low, middle, high = (f(percent) for f in (np.nanmin, np.nanmedian, np.nanmax))
            axis.barh(place, middle, 0.62, color=TYPE_COLOURS[kind])
            axis.plot([low, min(high, most_shown)], [place, place], color="#1b1b1b", linewidth=0.9)
            if high > most_shown:
                axis.plot(most_shown, place, ">", color="#1b1b1b", markersize=4.0, clip_on=False)
        axis.set_yticks(range(len(bars)), [fill(label, 24) for label, _, _ in bars], linespacing=0.9)
        axis.invert_yaxis()
        name = f"${quantity}$" if len(quantity) == 1 else quantity
        axis.set_xlabel(f"Uncertainty of {name} (%)", loc="right")
        axis.grid(axis="y", visible=False)
        axis.set_axisbelow(True)
        axis.set_xlim(0.0, min(most_shown, 1.05 * max(float(np.nanmax(x)) for _, _, x in bars)))
    kinds = {"A": "Type A: shrinks with more data", "B": "Type B: does not"}
    handles = [axes[0, 0].barh([0], [0], color=TYPE_COLOURS[k], label=label) for k, label in kinds.items()]
    figure.legend(handles=handles, loc="outside lower center", ncols=2)
    return figure


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


def draw_participants(files, chosen) -> Iterator[tuple[str, Figure]]:
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


MOST_PANELS = 8
TEXT = {"condition": str, "flags": str}
ROOM = 1.5  # beyond the 98 % quantile of what is drawn


def draw_coverage(files, chosen) -> Iterator[tuple[str, Figure]]:
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
