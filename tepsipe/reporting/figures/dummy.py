"""Figures of TEP-SIPE on the ankle dummy (thesis Figures 2-9, 3-3, 4-4)."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import cycle

import numpy as np
from matplotlib.figure import Figure

from tepsipe.experiments.dummy.specification_curve import SPECIFICATIONS
from tepsipe.identification.estimators import JOINT_LIKELIHOOD, OUTPUT_ERROR
from tepsipe.io.estimates import RECOVERIES
from tepsipe.io.result import Result, read_result
from tepsipe.mechanics.impedance_model import PARAMETERS, UNITS
from tepsipe.reporting.figures.matrix import plot_matrix
from tepsipe.reporting.figures.names import PROFILES, short_name, unit_symbol, words
from tepsipe.reporting.figures.pathways import draw_truth, plot_pathways
from tepsipe.reporting.figures.specification_curve import plot_specification
from tepsipe.reporting.figures.style import COLOURS, CYCLE, in_style, legend_above, new_figure

COMMAND = {"color": COLOURS["command"], "linewidth": 0.8, "linestyle": "--", "zorder": 1}


def draw(files, chosen) -> Iterator[tuple[str, Figure]]:
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
    truth = true_parameters(files.recovery, names, chosen.recommended)
    yield "figure_4_4", plot_parameter_boxes(results, printed, truth)
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
        axis.axhline(mean, color=COLOURS["other"], linewidth=0.8, linestyle="--", label="mean estimate")
        if truth:
            draw_truth(axis, 1.0 + np.arange(len(results)), truth[quantity])
        axis.set_title(
            f"mean ${quantity}$ = {mean:#.3g} {unit_symbol(UNITS[quantity])}".replace("-", "\N{MINUS SIGN}"),
            loc="right",
            fontsize=8.5,
        )
        axis.set_ylabel(f"${quantity}$ ({unit_symbol(UNITS[quantity])})")
        axis.margins(y=0.1)
    axes[2].set_xticks(1 + np.arange(len(results)), [short_name(name) for name in results])
    axes[2].set_xlabel("Perturbation profile and velocity amplitude")
    if truth:
        legend_above(figure, axes[0], 2)
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
