"""Figures of TEP-SIPE on the ankle dummy (thesis Figures 2-9, 3-3, 4-4).

Its parameters by pathway, from the leg and beside those from the foot, and the specification curve: I, B, K
by every combination of choices (thesis Appendix A).
"""

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from itertools import cycle

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tepsipe.drawing.names import PROFILES, short_name, words
from tepsipe.drawing.style import COLOURS, CYCLE, in_style, legend_above, new_figure, plot_matrix
from tepsipe.experiments.dummy.specification_curve import (
    AS_PRINTED,
    CHOICES,
    FILTERED,
    NONE,
    RECOMMENDED,
    REFERENCES,
    SPECIFICATIONS,
    TORQUES,
    WHOLE_TRIAL,
    WINDOWS,
    Specification,
)
from tepsipe.identification.estimators import ESTIMATORS, JOINT_LIKELIHOOD, OUTPUT_ERROR
from tepsipe.io.estimates import RECOVERIES
from tepsipe.io.result import Result, read_result
from tepsipe.mechanics.impedance_model import PARAMETERS, UNITS
from tepsipe.quantities import unit_symbol

COMMAND = {"color": COLOURS["command"], "linewidth": 0.8, "linestyle": "--", "zorder": 1}


def draw_dummy(files, chosen) -> Iterator[tuple[str, Figure]]:
    """Figures of the fits of all trials, of the specification curve and of the cross-validation."""
    names = list(chosen.conditions)
    results = {name: read_result(path) for name, path in zip(names, files.fits, strict=True)}
    matrices = read_result(files.matrices).arrays
    example, printed = chosen.example, chosen.as_printed
    colours = _colours(results[example].facts["estimators"], matrices, printed, chosen.recommended)
    shown = {name: colours[name] for name in dict.fromkeys([printed, chosen.recommended])}
    labels, axes = [short_name(name) for name in names], ("Parameters from", "Data of")
    yield "figure_2_9", plot_perturbations(results)
    yield "figure_3_3", plot_window(results[example], example, printed)
    truth = {pathway: true_parameters(files.recovery, names, pathway) for pathway in colours}
    yield "figure_4_4", plot_parameter_boxes(results, printed, truth[printed])
    yield "figure_pathways", plot_pathways(results, colours, truth)
    yield "figure_torque", plot_torque(results[example], example, shown)
    specified = SPECIFICATIONS.read(files.specification)
    _, _, quoted = results[specified[0].condition].arrays[f"{chosen.quoted}/mean_and_interval"][0]
    yield "figure_specification", plot_specification(specified, float(quoted))
    yield "figure_dummy_cross_validation", plot_matrix(matrices[printed], labels, "VAF (%)", axes)


def true_parameters(
    recovery: Sequence[str], conditions: Sequence[str], pathway: str
) -> dict[str, np.ndarray]:
    """True values of a pathway of the dummy, NaN where they are not known.

    recovery: the comparison with the truth first; empty without one.
    conditions: order of the values.
    pathway: pathway in whose windows the truth holds.
    Returns: quantity -> its values (N·m·s²/rad, N·m·s/rad, N·m/rad); empty if no condition has a truth.
    """
    rows = RECOVERIES.read(recovery[0]) if recovery else []
    own = [r for r in rows if (r.experiment, r.pathway) == ("dummy", pathway)]
    known = {(r.condition, r.quantity): r.truth for r in own}
    if not known:
        return {}
    return {q: np.array([known.get((c, q), np.nan) for c in conditions]) for q in PARAMETERS}


def _colours(
    estimators: Mapping[str, str], pathways: Iterable[str], printed: str, recommended: str
) -> dict[str, str]:
    """Pathway -> name of its colour."""
    special = {OUTPUT_ERROR: "compensated", JOINT_LIKELIHOOD: "joint likelihood"}
    colours = {name: special.get(estimators[name], "other") for name in pathways}
    return colours | {printed: "as printed", recommended: "recommended"}


def _around(result: Result, index: int, before_s: float, after_s: float) -> tuple[slice, np.ndarray]:
    """Samples around one perturbation, and their time from its onset (s)."""
    time = result.arrays["time"]
    rate = 1.0 / (time[1] - time[0])
    start = int(result.arrays["windows"][index, 0])
    shown = slice(max(0, start - round(before_s * rate)), start + round(after_s * rate))
    return shown, time[shown] - time[start]


@in_style
def plot_perturbations(results: dict[str, Result]) -> Figure:
    """Commanded and actual belt velocity of every condition, one perturbation each (ms, m/s)."""
    groups = {
        profile: [name for name in results if name.startswith(profile) and not name.endswith("s")]
        for profile in PROFILES
    }
    groups = {profile: names for profile, names in groups.items() if names} or {"": list(results)}
    figure, axes = new_figure(1, len(groups), 2.4, sharey=True, squeeze=False)
    for axis, (profile, names) in zip(axes[0], groups.items(), strict=True):
        for colour, name in zip(cycle(CYCLE), names, strict=False):
            result = results[name]
            shown, time = _around(result, 0, 0.06, 0.22)
            axis.plot(1e3 * time, result.arrays["belt_velocity"][shown], color=colour, label=short_name(name))
            if "belt_command" in result.arrays:
                command = result.arrays["belt_command"][shown]
                axis.plot(1e3 * time, command, **COMMAND)
        if "belt_command" in results[names[0]].arrays:
            axis.plot([], [], label="command", **COMMAND)
        axis.set(xlabel="Time from the detected onset (ms)", title=PROFILES.get(profile, ""))
        axis.set_xlim(-70.0, 300.0)  # room for the legend beside the curves
        axis.legend(loc="upper right")
    axes[0, 0].set_ylabel("Belt velocity (m/s)")
    return figure


@in_style
def plot_window(result: Result, name: str, pathway: str) -> Figure:
    """One perturbation and the window that is fitted: belt, angle and torque (s, m/s, rad, N·m)."""
    figure, axes = new_figure(3, 1, 3.0, sharex=True)
    index = len(result.arrays["windows"]) // 2
    shown, time = _around(result, index, 0.3, 0.9)
    start, stop = result.arrays["windows"][index]
    length = result.arrays["time"][stop] - result.arrays["time"][start]
    signals = (
        (result.arrays["belt_velocity"], "Belt (m/s)"),
        (result.arrays[f"{pathway}/regressors"][:, 2], r"$\theta_A-\theta_\mathrm{ref}$ (rad)"),
        (result.arrays[f"{pathway}/torque"], r"$\tau_A$ (N·m)"),
    )
    for axis, (values, label) in zip(axes, signals, strict=True):
        axis.axvspan(0.0, length, color=COLOURS["window"], label=f"window of {1e3 * length:.0f} ms")
        axis.plot(time, values[shown], color=COLOURS["measured"], label=f"measured, {short_name(name)}")
        axis.set_ylabel(label)
    if "belt_command" in result.arrays:
        command = result.arrays["belt_command"][shown]
        axes[0].plot(time, command, color=COLOURS["command"], linestyle=":", label="command")
    legend_above(figure, axes[0], 3)
    axes[2].set_xlabel("Time from the detected onset (s)")
    figure.align_ylabels()
    return figure


@in_style
def plot_parameter_boxes(results: dict[str, Result], pathway: str, truth: Mapping[str, np.ndarray]) -> Figure:
    """I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad) of every perturbation as boxes, one per condition.

    ``truth`` maps quantities to true values, condition by condition; empty without any.
    """
    figure, axes = new_figure(3, 1, 3.6, sharex=True)
    for k, (axis, quantity) in enumerate(zip(axes, PARAMETERS, strict=True)):
        values = [result.arrays[f"{pathway}/parameters"][:, k] for result in results.values()]
        mean = float(np.mean([v.mean() for v in values]))
        axis.boxplot(
            values,
            manage_ticks=False,
            widths=0.55,
            medianprops={"color": COLOURS[quantity]},
            boxprops={"linewidth": 0.8},
            whiskerprops={"linewidth": 0.8},
            flierprops={"marker": ".", "markersize": 4},
        )
        axis.axhline(mean, color=COLOURS["other"], linewidth=0.8, linestyle="--")
        # on the same axis the truth would press the boxes together
        true = f", true {np.nanmean(truth[quantity]):#.3g}" if truth else ""
        title = f"mean ${quantity}$ = {mean:#.3g}{true} {unit_symbol(UNITS[quantity])}"
        axis.set_title(title.replace("-", "\N{MINUS SIGN}"), loc="right", fontsize=8.5)
        axis.set_ylabel(f"${quantity}$ ({unit_symbol(UNITS[quantity])})")
        axis.margins(y=0.1)
    axes[2].set_xticks(1 + np.arange(len(results)), [short_name(name) for name in results])
    axes[2].set_xlabel("Perturbation profile and velocity amplitude")
    figure.align_ylabels()
    return figure


@in_style
def plot_torque(result: Result, name: str, pathways: dict[str, str]) -> Figure:
    """Torque of each pathway and its prediction during one perturbation (s, N·m).

    ``pathways`` maps names of pathways to names of colours.
    """
    figure, axes = new_figure(1, len(pathways), 2.5, squeeze=False)
    index = len(result.arrays["windows"]) // 2
    shown, time = _around(result, index, 0.1, 0.4)
    start, stop = result.arrays["windows"][index]
    length = result.arrays["time"][stop] - result.arrays["time"][start]
    entries: dict = {}
    for axis, (pathway, colour) in zip(axes[0], pathways.items(), strict=True):
        axis.axvspan(0.0, length, color=COLOURS["window"], label="fitted window")
        axis.plot(
            time,
            result.arrays[f"{pathway}/torque"][shown],
            color=COLOURS["measured"],
            label=f"torque, {short_name(name)}",
        )
        axis.plot(
            time,
            result.arrays[f"{pathway}/predicted_torque"][shown],
            color=COLOURS[colour],
            linestyle="--",
            label=f"prediction, {words(pathway)}",
        )
        vaf = result.arrays[f"{pathway}/vaf_per_perturbation"][index]
        axis.set(xlabel="Time from the onset (s)", title=f"{words(pathway)}: VAF {vaf:.2f} % in the window")
        entries |= dict(zip(*axis.get_legend_handles_labels()[::-1], strict=True))
    figure.legend(entries.values(), entries, loc="outside lower center", ncols=4)
    axes[0, 0].set_ylabel(r"Torque $\tau_A$ (N·m)")
    return figure


# of the recommended pathway of the leg, then of those of the foot; further ones have the last
FOOT_COLOURS = (
    "recommended",
    "as printed",
    "other",
    "other too",
    "compensated too",
    "compensated",
    "command",
)


def draw_foot(files, chosen) -> Iterator[tuple[str, Figure]]:
    """Figure of the fits from the ``leg`` and from the ``foot`` of every trial."""
    results = {}
    for name, leg, foot in zip(chosen.conditions, files.leg, files.foot, strict=True):
        of_leg, of_foot = read_result(leg), read_result(foot)
        results[name] = Result({**of_leg.arrays, **of_foot.arrays}, {}, of_foot.facts)
    pathways = [chosen.recommended, *of_foot.facts["pathways"]]
    colours = dict.fromkeys(pathways, FOOT_COLOURS[-1]) | dict(zip(pathways, FOOT_COLOURS, strict=False))
    truth = {name: true_parameters(files.recovery, chosen.conditions, name) for name in pathways}
    usable = [p for p in pathways if p == chosen.recommended or p in chosen.usable]
    yield "figure_foot", plot_pathways(results, colours, truth, usable)


# an axis goes beyond the values that it must show by this part of their range (-)
MARGIN = 0.35


def draw_truth(
    axis: Axes, x: np.ndarray, values: np.ndarray, half_width: float = 0.36, label: str | None = "true"
) -> None:
    """A short line at every true value (unit of the axis)."""
    look = {"color": COLOURS["measured"], "linewidth": 1.3, "zorder": 4}
    axis.hlines(values, x - half_width, x + half_width, label=label, **look)


@in_style
def plot_pathways(
    results: dict[str, Result],
    colours: dict[str, str],
    truth: Mapping[str, Mapping[str, np.ndarray]],
    usable: Collection[str] | None = None,
) -> Figure:
    """Mean I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad) of every pathway with 95 % intervals.

    results: condition -> its result.
    colours: pathway -> name of its colour.
    truth: pathway -> quantity -> its true values, condition by condition (unit of the quantity). Pathways
    differ in their truth: windows have other lengths, the torque from the foot excludes the inertia of the
    leg, and output error finds constants for small movements.
    usable: pathways whose values determine the axes, by default all; a triangle marks a value beyond them.
    Returns: A panel for each quantity.
    """
    figure, axes = new_figure(3, 1, 3.9, sharex=True)
    x = np.arange(len(results))
    shifts = np.linspace(-0.36, 0.36, max(2, len(colours)))
    for k, (axis, quantity) in enumerate(zip(axes, PARAMETERS, strict=True)):
        chosen = usable or colours
        true = [truth[p][quantity] for p in chosen if truth.get(p)]
        shown = _shown_range(results, chosen, k, np.concatenate(true) if true else None)
        named = "true"
        for shift, pathway in zip(shifts, colours, strict=False):
            intervals = [result.arrays[f"{pathway}/mean_and_interval"] for result in results.values()]
            value, low, high = np.array(intervals)[:, :, k].T
            look = {"color": COLOURS[colours[pathway]], "markersize": 3.4}
            for beyond, edge, mark in ((value < shown[0], shown[0], "v"), (value > shown[1], shown[1], "^")):
                axis.plot((x + shift)[beyond], np.full(beyond.sum(), edge), mark, **look)
            error = [value - low, high - value]
            label = words(pathway)
            axis.errorbar(x + shift, value, error, fmt="o", linewidth=0.9, capsize=1.8, label=label, **look)
            if truth.get(pathway):
                draw_truth(axis, x + shift, truth[pathway][quantity], 0.5 * (shifts[1] - shifts[0]), named)
                named = None
        axis.set_ylabel(f"${quantity}$ ({unit_symbol(UNITS[quantity])})")
        axis.set_ylim(shown[0] - 0.03 * np.ptp(shown), shown[1] + 0.03 * np.ptp(shown))
        axis.set_xticks(np.arange(len(results) + 1) - 0.5, minor=True)
        axis.grid(axis="x", visible=False)
        axis.grid(axis="x", which="minor", color="#d4d4d4", linewidth=0.5)
        axis.tick_params(axis="x", which="both", length=0.0)
    handles, names = axes[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=3)
    axes[2].set_xticks(x, [short_name(name) for name in results])
    axes[2].set_xlabel("Perturbation profile and velocity amplitude")
    figure.align_ylabels()
    return figure


def _shown_range(
    results: dict[str, Result], pathways: Collection[str], k: int, truth: np.ndarray | None
) -> tuple[float, float]:
    """Ends of an axis with all values of some pathways and the true ones (unit of the quantity)."""
    values = [float(r.arrays[f"{p}/mean_and_interval"][0, k]) for r in results.values() for p in pathways]
    values += [] if truth is None else [float(value) for value in truth if np.isfinite(value)]
    margin = MARGIN * (max(values) - min(values))
    return min(values) - margin, max(values) + margin


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
_ROLES = {RECOMMENDED: "consistent least squares"}
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
        6.7,
        sharex=True,
        height_ratios=[2.4, 1.3, 0.19 * sum(1.35 + len(names) for names in levels.values())],
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
        y += 0.35 if k else 0.0  # a gap before each group but the first
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
