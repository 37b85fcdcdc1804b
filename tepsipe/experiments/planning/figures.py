"""Figures of planned experiments: needed perturbations, best pulses, filters, and sets for several joints."""

from collections.abc import Iterator

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from tepsipe.drawing.style import COLOURS, CYCLE, in_style, new_figure
from tepsipe.experiments.planning.plan import COVERAGE, Plan
from tepsipe.experiments.planning.pulses import STEP_S

_TICKS = (0.001, 0.01, 0.1, 1.0, 10.0, 100.0)
_STYLES = ("-", "--", ":")


def draw_planning(files, chosen) -> Iterator[tuple[str, Figure]]:
    """Figures of the tables of designs, pulses and filters."""
    filters = pd.read_csv(files.filters)
    yield "figure_needed", plot_needed(pd.read_csv(files.plan))
    yield "figure_pulses", plot_pulses(pd.read_csv(files.shapes))
    yield "figure_filters", plot_filters(filters)
    yield "figure_treadmill_filters", plot_treadmill_filters(filters)


def _percent_axis(axis, low: float) -> None:
    ticks = [tick for tick in _TICKS if tick >= 0.5 * low]
    axis.set_yticks(ticks, [f"{tick:g}" for tick in ticks])
    axis.set_ylim(bottom=0.7 * low)
    axis.minorticks_off()
    axis.set_xticks([1, 10, 100, 1000], ["1", "10", "100", "1000"])


@in_style
def plot_plan(plans: dict[str, Plan]) -> Figure:
    """Half width of the 95 % interval of K (%) over the number of perturbations, and the belt's pulses (m/s).

    ``plans`` are the plans by name; dashed lines are Type A alone.
    """
    figure, (left, right) = new_figure(1, 2, 3.0)
    numbers = np.unique(np.geomspace(1, 1000, 120).round().astype(int))
    lowest = np.inf
    for colour, (name, plan) in zip(CYCLE * (1 + len(plans)), plans.items(), strict=False):
        scale = 100.0 * COVERAGE / plan.design.parameters[2]
        widths = [scale * plan.with_number(int(n))[2] for n in numbers]
        left.loglog(numbers, widths, color=colour, label=name)
        of_noise = [scale * plan.type_a_with(int(n))[2] for n in numbers]
        left.loglog(numbers, of_noise, color=colour, linewidth=0.7, linestyle="--")
        lowest = min(lowest, of_noise[-1])
        elapsed = 1e3 * STEP_S * np.arange(plan.motion.pulse_velocity.size)
        right.plot(elapsed, plan.motion.pulse_velocity, color=colour)
    left.axhline(10.0, color=COLOURS["other"], linewidth=0.7)
    _percent_axis(left, lowest)
    left.set(xlabel="perturbations", ylabel="half width of the 95 % interval of K (%)")
    right.set(xlabel="time from the onset (ms)", ylabel="velocity of the belt (m/s)", xlim=(0.0, 250.0))
    figure.legend(loc="outside upper center", ncols=3)
    return figure


@in_style
def plot_needed(plan: pd.DataFrame) -> Figure:
    """Half width of the 95 % interval of K (%) over the number, by design, and predicted against drawn.

    ``plan`` is the table of the designs (units in its columns).
    """
    figure, (left, right) = new_figure(1, 2, 3.8)
    of_k = plan[plan.quantity == "K"]
    numbers = np.unique(np.geomspace(1, 1000, 120).round().astype(int))
    lowest = np.inf
    for k, row in enumerate(of_k.itertuples()):
        style = {"color": CYCLE[k % len(CYCLE)], "linestyle": _STYLES[k // len(CYCLE) % len(_STYLES)]}
        scale = 100.0 * COVERAGE / row.value
        fixed = row.of_rest**2 + row.u_type_b**2
        falling = (row.predicted_u**2 - row.of_rest**2) * row.n_perturbations / numbers
        widths = scale * np.sqrt(falling + fixed)
        left.loglog(numbers, widths, label=row.design, **style)
        lowest = min(lowest, widths[-1])
    left.axhline(10.0, color=COLOURS["other"], linewidth=0.8)
    _percent_axis(left, lowest)
    left.set(xlabel="perturbations", ylabel="half width of the 95 % interval of K (%)")
    names = list(of_k.design)
    right.axvspan(-10.0, 10.0, color=COLOURS["window"], linewidth=0.0)
    for quantity, beside in (("I", -0.22), ("B", 0.0), ("K", 0.22)):
        own = plan[plan.quantity == quantity]
        ratio = 100.0 * (own.monte_carlo_u / own.predicted_u - 1.0)
        right.errorbar(
            ratio,
            np.arange(len(own)) + beside,
            xerr=196.0 * own.monte_carlo_error,
            fmt="o",
            markersize=3.0,
            linewidth=0.8,
            color=COLOURS[quantity],
            label=quantity,
        )
    right.set_yticks(range(len(names)), names)
    right.set(xlabel="Monte Carlo over prediction, less 1 (%)", ylim=(len(names) - 0.4, -0.6))
    right.legend(loc="lower right", ncols=3, frameon=True, fontsize=7.5, borderpad=0.2, columnspacing=0.8)
    figure.legend(*left.get_legend_handles_labels(), loc="outside upper center", ncols=4)
    return figure


@in_style
def plot_pulses(shapes: pd.DataFrame) -> Figure:
    """Velocity of the belt (m/s) in reference pulses and in the best ones, one panel per reference.

    ``shapes`` is the table of the pulses (s, m/s).
    """
    references = list(dict.fromkeys(shapes.reference))
    figure, axes = new_figure(1, len(references), 3.2, squeeze=False, sharey=True)
    for axis, reference in zip(axes.flat, references, strict=True):
        own = shapes[shapes.reference == reference]
        for k, ((limits, belt), one) in enumerate(own.groupby(["limits", "belt"], sort=False)):
            known = limits == "reference"
            axis.plot(
                1e3 * one.time_s,
                one.velocity_m_per_s,
                color=COLOURS["measured"] if known else CYCLE[(k - 1) % len(CYCLE)],
                linewidth=1.6 if known else 1.1,
                label="reference" if known else f"{limits}, {belt}",
            )
        axis.set_title(reference, loc="left")
        axis.set(xlabel="time from the onset (ms)", xlim=(0.0, 200.0))
    axes.flat[0].set_ylabel("velocity of the belt (m/s)")
    handles, labels = axes.flat[0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=3)
    return figure


def _lines(axis, rows: pd.DataFrame, column: str, groups: list[str]) -> None:
    for k, (key, own) in enumerate(rows.groupby(groups, sort=False)):
        ordered = own.sort_values("cutoff_hz")
        name = " ".join(map(str, key))
        axis.plot(
            ordered.cutoff_hz,
            ordered[column],
            marker="o",
            markersize=2.5,
            color=CYCLE[k % len(CYCLE)],
            label=name,
        )


@in_style
def plot_filters(filters: pd.DataFrame) -> Figure:
    """Predicted bias and standard deviation of K and B (%) of the torque from the leg, by filter.

    ``filters`` is the table of the filters (units in its columns).
    """
    figure, axes = new_figure(2, 3, 4.4, sharex=True)
    predicted = filters[(filters.source == "predicted") & (filters.pathway == "leg")]
    alike, one = predicted[predicted.filtered == "alike"], predicted[predicted.filtered != "alike"]
    one = one[one.order == 4]
    for row, quantity in zip(axes, ("K", "B"), strict=True):
        own = alike[alike.quantity == quantity]
        _lines(row[0], own, "sd_percent", ["kind", "order"])
        _lines(row[1], own, "bias_percent", ["kind", "order"])
        _lines(row[2], one[one.quantity == quantity], "bias_percent", ["filtered", "kind"])
        row[0].set_yscale("log")
        row[0].set_ylabel(f"{quantity} (%)")
        row[2].set_yscale("symlog", linthresh=10.0)
    for axis, title in zip(
        axes[0], ("SD of one window", "bias by noise, all alike", "one side only"), strict=True
    ):
        axis.set_title(title, loc="left")
    for axis in axes[1]:
        axis.set(xlabel="cutoff (Hz)")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=5)
    axes[0, 2].legend(fontsize=7.5)
    return figure


@in_style
def plot_treadmill_filters(filters: pd.DataFrame) -> Figure:
    """Error of K (N·m/rad) and B (N·m·s/rad) in simulated trials, by filter and origin of the torque.

    ``filters`` is the table of the filters (units in its columns). Lines are trials, bars SD over windows.
    """
    simulated = filters[filters.source != "predicted"]
    pathways = list(dict.fromkeys(simulated.pathway))
    figure, axes = new_figure(2, len(pathways), 4.4, sharex=True, squeeze=False)
    kinds = (("zero-lag", 4, "-", "o"), ("one-sided", 2, "--", "s"))
    for column, pathway in enumerate(pathways):
        for axis, quantity in zip(axes[:, column], ("K", "B"), strict=True):
            own = simulated[(simulated.pathway == pathway) & (simulated.quantity == quantity)]
            for k, (source, trial) in enumerate(own.groupby("source", sort=False)):
                for kind, order, line, marker in kinds:
                    shown = trial[(trial.kind == kind) & (trial.order == order)].sort_values("cutoff_hz")
                    axis.errorbar(
                        shown.cutoff_hz,
                        shown.bias,
                        yerr=shown.sd_of_window if kind == "zero-lag" else None,
                        color=CYCLE[k % len(CYCLE)],
                        linestyle=line,
                        marker=marker,
                        markersize=2.5,
                        linewidth=0.9,
                        elinewidth=0.5,
                        label=f"{source}, {kind}",
                    )
            axis.axhline(0.0, color=COLOURS["measured"], linewidth=0.6)
        axes[0, column].set_title(pathway, loc="left")
        axes[1, column].set(xlabel="cutoff (Hz)")
    axes[0, 0].set_ylabel("error of K (N·m/rad)")
    axes[1, 0].set_ylabel("error of B (N·m·s/rad)")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside upper center", ncols=4)
    return figure


_TICKS_OF_NEED = (1.0, 10.0, 100.0, 1e3, 1e4, 1e5, 1e6)


def draw_several_joints(files, chosen) -> Iterator[tuple[str, Figure]]:
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
    ticks = [tick for tick in _TICKS_OF_NEED if 0.5 * low <= tick <= 2.0 * high]
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
