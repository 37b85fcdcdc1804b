"""Figures of the forward simulations (thesis Figures 2-10, 2-11, 4-7 to 4-11 and Appendix B)."""

from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tepsipe.experiments.forward.scores import FORWARD_SCORES, ForwardScore
from tepsipe.io.result import Result, read_result
from tepsipe.reporting.figures.flow_charts import draw_evaluation
from tepsipe.reporting.figures.names import PARAMETER_SETS, short_name
from tepsipe.reporting.figures.schematics import draw_simulation_model
from tepsipe.reporting.figures.style import COLOURS, example_and_panels, in_style, new_figure

LINES = {"wristalyzer": ("#c8371b", "-."), "tep": ("#2f8f4e", "--"), "corrected": ("#1668a8", ":")}
# small panels in a row
COLUMNS = 4
QUANTITIES = {
    "theta": r"angle $\theta_A$",
    "tau": r"torque $\tau_A$ as printed",
    "tau_consistent": r"torque $\tau_A$, consistent",
}


def draw(files, chosen) -> Iterator[tuple[str, Figure]]:
    """Figures of the simulations (``fits``) and of their scores (``forward``)."""
    names = list(chosen.conditions)
    results = {name: read_result(path) for name, path in zip(names, files.fits, strict=True)}
    scores = FORWARD_SCORES.read(files.forward)
    yield "figure_2_10", draw_simulation_model(chosen.geometry)
    sets = dict.fromkeys(PARAMETER_SETS[score.parameter_set] for score in scores)
    yield "figure_2_11", draw_evaluation(list(sets), len(names))
    yield "figure_4_7", plot_angles(results[chosen.frequent])
    yield "figure_4_8", plot_angles(results[chosen.rare])
    yield "figure_4_9", plot_torques(results[chosen.frequent])
    yield "figure_4_10", plot_scores(scores, names, "vaf_perturbation")
    yield "figure_4_11", plot_scores(scores, names, "vaf_trial")
    yield "figure_b", plot_all_angles(results)
    # Figures B-1 to B-12, and no more: the thesis's B-13 is another one
    for number, name in enumerate(names[:12], start=1):
        yield f"figure_b_{number}", plot_angles(results[name])
    yield "figure_b_13", plot_all_torques(results)


def _around(result: Result, seconds: float) -> slice:
    """Part of the trial that starts shortly before the middle perturbation (s)."""
    start = int(result.arrays["windows"][len(result.arrays["windows"]) // 2, 0])
    rate = 1.0 / float(result.arrays["time"][1] - result.arrays["time"][0])
    return slice(max(0, start - round(0.2 * rate)), start + round(seconds * rate))


def _label(result: Result, name: str) -> str:
    i, b, k = result.arrays[f"{name}/parameters"]
    state = result.facts["states"][name]
    return f"{PARAMETER_SETS[name]}: I {i:.3f}, B {b:.3f}, K {k:.2f}" + (
        "" if state == "settles" else f" ({state})"
    )


def _draw(
    axis: Axes,
    result: Result,
    signal: str,
    measured: str,
    part: slice,
    *,
    label: bool = False,
    onset_s: float = 0.0,
) -> None:
    time = result.arrays["time"][part] - onset_s
    axis.plot(
        time, result.arrays[measured][part], color=COLOURS["measured"], label="measured" if label else None
    )
    for name in result.facts["parameter_sets"]:
        colour, line = LINES[name]
        axis.plot(
            time,
            result.arrays[f"{name}/{signal}"][part],
            color=colour,
            linestyle=line,
            linewidth=1.0,
            label=_label(result, name) if label else None,
        )
    axis.margins(x=0.0)


@in_style
def plot_angles(result: Result) -> Figure:
    """Measured and simulated angle over the trial and after one perturbation (s, rad)."""
    figure, axes = new_figure(1, 2, 2.3, width_ratios=[1.3, 1.0], sharey=True)
    _draw(axes[0], result, "theta", "theta", slice(None, None, 4))
    _draw(axes[1], result, "theta", "theta", _around(result, 3.6), label=True)
    axes[0].set(xlabel="Time (s)", ylabel=r"Angle $\theta_A$ from rest (rad)")
    axes[1].set(xlabel="Time (s)")
    figure.legend(loc="outside lower center", ncols=2, fontsize=7.8)
    return figure


@in_style
def plot_torques(result: Result) -> Figure:
    """Torque by inverse dynamics, as printed and consistent, and simulated torque (s, N·m)."""
    figure, axes = new_figure(1, 2, 2.3)
    part = _around(result, 0.6)
    for axis, quantity, title in zip(
        axes, ("tau", "tau_consistent"), ("inverse dynamics as printed", "consistent"), strict=True
    ):
        _draw(axis, result, "tau", quantity, part, label=axis is axes[0])
        axis.set(title=title, xlabel="Time (s)", ylabel=r"Torque $\tau_A$ (N·m)")
    figure.legend(loc="outside lower center", ncols=2, fontsize=7.8)
    return figure


@in_style
def plot_scores(scores: list[ForwardScore], conditions: list[str], key: str) -> Figure:
    """VAF of angle and torque for every parameter set and condition (%)."""
    figure, axes = new_figure(len(QUANTITIES), 1, 3.3, sharex=True)
    x = np.arange(len(conditions))
    shifts = np.linspace(-0.26, 0.26, len(PARAMETER_SETS))
    for axis, (quantity, title) in zip(axes, QUANTITIES.items(), strict=True):
        for shift, (name, label) in zip(shifts, PARAMETER_SETS.items(), strict=True):
            colour, _ = LINES[name]
            by_condition = {
                s.condition: getattr(s, key)
                for s in scores
                if s.parameter_set == name and s.quantity == quantity
            }
            values = np.array([by_condition[condition] for condition in conditions])
            axis.bar(x + shift, np.maximum(values, 0.0), 0.24, color=colour, label=label)
            below = values < 0.0
            axis.plot((x + shift)[below], np.full(below.sum(), 3.0), "v", color=colour, markersize=4)
        axis.set(ylabel="VAF (%)", title=title, ylim=(0.0, 105.0))
        axis.grid(axis="x", visible=False)
    axes[-1].set_xticks(x, [short_name(name) for name in conditions])
    handles, labels = axes[0].get_legend_handles_labels()
    handles.append(axes[0].plot([], [], "v", color=COLOURS["other"], markersize=4)[0])
    figure.legend(handles, [*labels, "below 0 %"], loc="outside lower center", ncols=4, fontsize=7.8)
    return figure


def _all(
    results: dict[str, Result], signal: str, measured: str, seconds: float, label: str
) -> tuple[Figure, Axes]:
    """One perturbation of every condition, the first one also large; the figure and its large panel."""
    rows = -(-len(results) // COLUMNS)
    figure, example, axes = example_and_panels(len(results), COLUMNS, 0.86 * (rows + 1.5) + 0.5)
    for axis, (name, result) in zip(axes.flat, results.items(), strict=False):
        _draw(axis, result, signal, measured, _around(result, seconds), onset_s=_onset(result))
        axis.set_title(short_name(name), fontsize=8.5)
        axis.locator_params(axis="y", nbins=3)
    first, result = next(iter(results.items()))
    _draw(example, result, signal, measured, _around(result, seconds), label=True, onset_s=_onset(result))
    example.set(title=short_name(first), xlabel="Time from the onset (s)", ylabel=label)
    start, stop = result.arrays["windows"][len(result.arrays["windows"]) // 2]
    length = float(result.arrays["time"][int(stop)] - result.arrays["time"][int(start)])
    example.axvspan(0.0, length, color=COLOURS["window"], zorder=0)
    for axis in axes[:, 0]:
        axis.set_ylabel(label)
    for axis in axes[-1]:
        axis.set_xlabel("Time (s)")
    handles, names = example.get_legend_handles_labels()
    figure.legend(
        handles, [n.split(":")[0] for n in names], loc="outside lower center", ncols=4, fontsize=7.8
    )
    return figure, example


def _onset(result: Result) -> float:
    """Time of the onset of the middle perturbation (s)."""
    windows = result.arrays["windows"]
    return float(result.arrays["time"][int(windows[len(windows) // 2, 0])])


def _note(axis: Axes, text: str, at: tuple[float, float], beside: tuple[float, float]) -> None:
    axis.annotate(text, at, beside, fontsize=8.0, va="center", arrowprops={"arrowstyle": "-", "lw": 0.6})


@in_style
def plot_all_angles(results: dict[str, Result]) -> Figure:
    """Measured and simulated angle after one perturbation of every condition (s, rad)."""
    figure, example = _all(results, "theta", "theta", 3.6, r"$\theta_A$ (rad)")
    result = next(iter(results.values()))
    part = _around(result, 3.6)
    time, angle = result.arrays["time"][part] - _onset(result), result.arrays["theta"][part]
    lowest, highest = float(angle.min()), float(angle.max())
    pulse = float(time[angle.argmin()])
    _note(example, "the belt moves (shaded),\nthe leg lags", (pulse, lowest), (pulse + 0.25, 0.75 * lowest))
    swing = angle - angle[time > pulse].mean()
    crossing = np.flatnonzero((time[1:] > 0.2) & (swing[:-1] < 0.0) & (swing[1:] >= 0.0))
    if crossing.size > 2:
        begin, end = (float(time[k]) for k in crossing[1:3])
        height = 1.25 * highest
        example.annotate("", (begin, height), (end, height), arrowprops={"arrowstyle": "<->", "lw": 0.7})
        text = f"one period, {end - begin:.2f} s: stiffness over inertia"
        example.text(end + 0.05, height, text, fontsize=8.0, va="center")
    _note(
        example,
        "decay: damping",
        (float(time[-1]) * 0.93, 0.5 * highest),
        (float(time[-1]) * 0.75, 0.6 * lowest),
    )
    example.set_ylim(1.1 * lowest, 1.6 * highest)
    return figure


@in_style
def plot_all_torques(results: dict[str, Result]) -> Figure:
    """Torque as printed and simulated torque during one perturbation of every condition (s, N·m)."""
    figure, example = _all(results, "tau", "tau", 0.5, r"$\tau_A$ (N·m)")
    result = next(iter(results.values()))
    part = _around(result, 0.5)
    time, torque = result.arrays["time"][part] - _onset(result), result.arrays["tau"][part]
    peak = int(np.abs(torque).argmax())
    _note(
        example,
        f"printed torque, peak {torque[peak]:.2f} N·m".replace("-", "\N{MINUS SIGN}"),
        (float(time[peak]), float(torque[peak])),
        (float(time[peak]) + 0.12, 0.85 * float(torque[peak])),
    )
    lowest = float(torque.min())
    _note(
        example,
        "the belt moves (shaded); only here is the torque fitted",
        (0.0, 0.7 * lowest),
        (0.16, 0.7 * lowest),
    )
    return figure
