"""Figures of the forward simulations (thesis Figures 2-10, 2-11, 4-7 to 4-11 and Appendix B).

Figures B-1 to B-12, one per trial, are drawn by `draw_simulation_trial`.
"""

from collections.abc import Callable, Iterable, Iterator

import numpy as np
import scipy
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from tepsipe.drawing.names import ESTIMATED_SETS, PARAMETER_SETS, THESIS_SETS, compared_sets, short_name
from tepsipe.drawing.style import (
    COLOURS,
    WIDTH_IN,
    Drawing,
    draw_vafs,
    example_and_panels,
    in_style,
    new_figure,
)
from tepsipe.experiments.forward.scores import EQUATIONS, FORWARD_SCORES, ForwardScore
from tepsipe.io.result import Result, read_result

LINES = {
    "wristalyzer": ("#d55e00", "-."),
    "tep": ("#009e73", "--"),
    "corrected": ("#0072b2", ":"),
    "joint-likelihood": (COLOURS["joint likelihood"], (0, (5, 2))),
    "thesis-wristalyzer": ("#d55e00", "-."),
    "thesis-without-handle": ("#e69f00", ":"),
    "thesis-tep": ("#009e73", "--"),
}
GROUPS = {"numbers of the thesis": THESIS_SETS, "estimates of this run": ESTIMATED_SETS}
ENVELOPE_S = 0.7  # half a period of the slowest swing in the thesis
# larger swings leave the panel, where the measured one would be too small to see
LARGEST_SWING = 4.0  # of the largest measured one
# small panels in a row
COLUMNS = 4
QUANTITIES = {
    "theta": r"angle $\theta_A$",
    "tau": r"torque $\tau_A$ as printed",
    "tau_consistent": r"torque $\tau_A$, consistent",
}


def draw_simulation(files, chosen) -> Iterator[tuple[str, Figure | Drawing]]:
    """Figures of the simulations (``fits``) and of their scores (``forward``)."""
    names = list(chosen.conditions)
    results = {name: read_result(path) for name, path in zip(names, files.fits, strict=True)}
    scores = FORWARD_SCORES.read(files.forward)
    yield "figure_2_10", Drawing(files.drawings[0], {"geometry": chosen.geometry})
    sets = dict.fromkeys(PARAMETER_SETS[score.parameter_set] for score in scores)
    yield "figure_2_11", Drawing(files.drawings[0], {"sets": list(sets), "trials": len(names)})
    yield "figure_4_7", plot_angles(results[chosen.frequent])
    yield "figure_4_8", plot_angles(results[chosen.rare])
    yield "figure_4_9", plot_torques(results[chosen.frequent])
    yield "figure_4_10", plot_scores(scores, names, "vaf_perturbation")
    yield "figure_4_11", plot_scores(scores, names, "vaf_trial")
    yield "figure_b", plot_all_angles(results)
    yield "figure_b_13", plot_all_torques(results)


def _around(result: Result, seconds: float) -> slice:
    """Part of the trial that starts shortly before the middle perturbation (s)."""
    start = int(result.arrays["windows"][len(result.arrays["windows"]) // 2, 0])
    rate = 1.0 / float(result.arrays["time"][1] - result.arrays["time"][0])
    return slice(max(0, start - round(0.2 * rate)), start + round(seconds * rate))


def _marked(name: str, engine: str) -> str:
    """A set of parameters as figures name it (no unit), with an asterisk if the equations moved the leg."""
    return PARAMETER_SETS[name] + ("*" if engine == EQUATIONS else "")


def _label(result: Result, name: str) -> str:
    i, b, k = result.arrays[f"{name}/parameters"]
    softens = ", softens" if name in result.facts["softens"] else ""
    text = f"{_marked(name, result.facts['engines'][name])}: I {i:.3f}, B {b:.3g}, K {k:.2f}{softens}"
    return text.replace("-0", "\N{MINUS SIGN}0")


def _draw(
    axis: Axes,
    result: Result,
    signal: str,
    measured: str,
    part: slice,
    names: Iterable[str],
    *,
    label: bool = False,
    onset_s: float = 0.0,
) -> None:
    time = result.arrays["time"][part] - onset_s
    axis.plot(
        time, result.arrays[measured][part], color=COLOURS["measured"], label="measured" if label else None
    )
    for name in names:
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


def _envelope(result: Result, angle: np.ndarray) -> np.ndarray:
    """Largest abs(angle) between perturbations (rad) within `ENVELOPE_S`, up to a fall."""
    size = np.abs(angle[np.isfinite(angle)])
    for start, stop in result.arrays["windows"]:
        size[start:stop] = 0.0
    rate_hz = 1.0 / float(result.arrays["time"][1] - result.arrays["time"][0])
    return scipy.ndimage.maximum_filter1d(size, 1 + round(ENVELOPE_S * rate_hz))


def _draw_swings(axis: Axes, result: Result, names: Iterable[str]) -> None:
    """Envelope of the measured and simulated swing over the trial (s, rad)."""
    time, part = result.arrays["time"], slice(None, None, 8)
    measured = _envelope(result, result.arrays["theta"])
    axis.fill_between(time[part], measured[part], color=COLOURS["other too"], linewidth=0.0)
    highest = measured.max()
    for name in names:
        envelope = _envelope(result, result.arrays[f"{name}/theta"])
        colour, line = LINES[name]
        axis.plot(time[: envelope.size][part], envelope[part], color=colour, linestyle=line, linewidth=1.0)
        highest = max(highest, envelope.max(initial=0.0))
    axis.margins(x=0.0)
    axis.set_ylim(0.0, 1.05 * min(highest, LARGEST_SWING * measured.max()))


@in_style
def plot_angles(result: Result) -> Figure:
    """Swing over the trial, and angle after one perturbation, measured and simulated (s, rad)."""
    known = result.facts["parameter_sets"]
    groups = {title: [n for n in names if n in known] for title, names in GROUPS.items()}
    groups = {title: names for title, names in groups.items() if names}
    figure = Figure(figsize=(WIDTH_IN, 2.2 * len(groups)), layout="constrained")
    FigureCanvasAgg(figure)
    rows = figure.subfigures(len(groups), 1, squeeze=False)[:, 0]
    for row, (title, names) in zip(rows, groups.items(), strict=True):
        whole, near = row.subplots(1, 2, width_ratios=[1.2, 1.0])
        _draw_swings(whole, result, names)
        _draw(near, result, "theta", "theta", _around(result, 3.6), names, label=True)
        whole.set(title=f"whole trial, {title}", ylabel=r"swing of $\theta_A$ (rad)", xlabel="Time (s)")
        near.set(title="one perturbation", ylabel=r"$\theta_A$ (rad)", xlabel="Time (s)")
        row.legend(loc="outside lower center", ncols=2)
    return figure


@in_style
def plot_torques(result: Result) -> Figure:
    """Torques and fore-aft force, measured and simulated, and the belt-induced force (s, N·m, N)."""
    has_force = "f_y" in result.arrays
    figure, axes = new_figure(1 + has_force, 2, 4.2 if has_force else 2.3, sharex=True, squeeze=False)
    part, names = _around(result, 0.6), compared_sets(result.facts["parameter_sets"])
    for axis, quantity, title in zip(
        axes[0], ("tau", "tau_consistent"), ("inverse dynamics as printed", "consistent"), strict=True
    ):
        _draw(axis, result, "tau", quantity, part, names, label=axis is axes[0, 0])
        axis.set(title=title, ylabel=r"Torque $\tau_A$ (N·m)")
    if has_force:
        force, induced = axes[1]
        _draw(force, result, "f_y", "f_y", part, names)
        force.set(title="force of the belt on the foot", ylabel="$F_y$ (N)")
        for name in names:
            colour, line = LINES[name]
            difference = result.arrays["f_y"][part] - result.arrays[f"{name}/f_y"][part]
            induced.plot(result.arrays["time"][part], difference, color=colour, linestyle=line, linewidth=1.0)
        induced.margins(x=0.0)
        induced.set(title="belt-induced force (measured minus simulated)", ylabel=r"$\Delta F_y$ (N)")
        induced.sharey(force)
    for axis in axes[-1]:
        axis.set_xlabel("Time (s)")
    figure.legend(loc="outside lower center", ncols=2, fontsize=7.8)
    return figure


@in_style
def plot_scores(scores: list[ForwardScore], conditions: list[str], key: str) -> Figure:
    """VAF of angle and torque for every parameter set and condition, as numbers on a map (%)."""
    names = [name for name in PARAMETER_SETS if any(s.parameter_set == name for s in scores)]
    height_in = 0.7 + 0.17 * len(QUANTITIES) * (len(names) + 1.6)
    figure, axes = new_figure(len(QUANTITIES), 1, height_in, sharex=True)
    found = {(s.quantity, s.parameter_set, s.condition): getattr(s, key) for s in scores}
    engines = {s.parameter_set: s.engine for s in scores}
    labels = [_marked(name, engines[name]) for name in names]
    of_run = sum(name in ESTIMATED_SETS for name in names)
    for axis, (quantity, title) in zip(axes, QUANTITIES.items(), strict=True):
        vafs = [[found.get((quantity, name, c), np.nan) for c in conditions] for name in names]
        draw_vafs(axis, np.array(vafs, dtype=float))
        axis.set_title(f"VAF of the {title} (%)")
        axis.set_yticks(range(len(names)), labels, fontsize=8.0)
        axis.axhline(of_run - 0.5, color="white", linewidth=3.0)
        axis.spines[:].set_visible(False)
    axes[-1].set_xticks(range(len(conditions)), [short_name(name) for name in conditions])
    return figure


def _all(
    results: dict[str, Result], signal: str, seconds: float, label: str, small: Callable, small_label: str
) -> tuple[Figure, Axes]:
    """One perturbation of the first condition, large, above all conditions, drawn by ``small``.

    Returns the figure and its large panel.
    """
    rows = -(-len(results) // COLUMNS)
    figure, example, axes = example_and_panels(len(results), COLUMNS, 0.86 * (rows + 2.0) + 0.5, example=2.0)
    for axis, (name, result) in zip(axes.flat, results.items(), strict=False):
        small(axis, result, compared_sets(result.facts["parameter_sets"]))
        axis.set_title(short_name(name), fontsize=8.5)
        axis.locator_params(axis="y", nbins=3)
    first, result = next(iter(results.items()))
    part, names = _around(result, seconds), compared_sets(result.facts["parameter_sets"])
    _draw(example, result, signal, signal, part, names, label=True, onset_s=_onset(result))
    example.set(title=short_name(first), xlabel="Time from the onset (s)", ylabel=label)
    start, stop = result.arrays["windows"][len(result.arrays["windows"]) // 2]
    length = float(result.arrays["time"][int(stop)] - result.arrays["time"][int(start)])
    example.axvspan(0.0, length, color=COLOURS["window"], zorder=0)
    for axis in axes[:, 0]:
        axis.set_ylabel(small_label)
    for axis in axes[-1]:
        axis.set_xlabel("Time (s)")
    handles, labels = example.get_legend_handles_labels()
    labels = [label.split(":")[0] for label in labels]
    figure.legend(handles, labels, loc="outside lower center", ncols=4, fontsize=7.8)
    return figure, example


def _onset(result: Result) -> float:
    """Time of the onset of the middle perturbation (s)."""
    windows = result.arrays["windows"]
    return float(result.arrays["time"][int(windows[len(windows) // 2, 0])])


def _note(axis: Axes, text: str, at: tuple[float, float], beside: tuple[float, float]) -> None:
    axis.annotate(text, at, beside, fontsize=8.0, va="center", arrowprops={"arrowstyle": "-", "lw": 0.6})


@in_style
def plot_all_angles(results: dict[str, Result]) -> Figure:
    """Swing over every trial, and the angle after one perturbation, measured and simulated (s, rad)."""
    figure, example = _all(results, "theta", 3.6, r"$\theta_A$ (rad)", _draw_swings, "swing (rad)")
    result = next(iter(results.values()))
    part = _around(result, 3.6)
    time, angle = result.arrays["time"][part] - _onset(result), result.arrays["theta"][part]
    largest = LARGEST_SWING * float(np.abs(angle).max())
    lowest, highest = np.clip(example.dataLim.intervaly, -largest, largest)
    pulse = float(time[angle.argmin()])
    _note(
        example,
        "the belt moves (shaded),\nthe leg lags",
        (pulse, float(angle.min())),
        (pulse + 0.25, 0.75 * lowest),
    )
    swing = angle - angle[time > pulse].mean()
    crossing = np.flatnonzero((time[1:] > 0.2) & (swing[:-1] < 0.0) & (swing[1:] >= 0.0))
    if crossing.size > 2:
        begin, end = (float(time[k]) for k in crossing[1:3])
        height = 1.2 * highest
        example.annotate("", (begin, height), (end, height), arrowprops={"arrowstyle": "<->", "lw": 0.7})
        text = f"one period, {end - begin:.2f} s: stiffness over inertia"
        example.text(end + 0.05, height, text, fontsize=8.0, va="center")
    _note(
        example,
        "decay: damping",
        (float(time[-1]) * 0.93, 0.5 * highest),
        (float(time[-1]) * 0.75, 0.6 * lowest),
    )
    example.set_ylim(1.1 * lowest, 1.45 * highest)
    return figure


def _draw_torque(axis: Axes, result: Result, names: Iterable[str]) -> None:
    """Torque as printed and simulated torque during one perturbation (s, N·m)."""
    _draw(axis, result, "tau", "tau", _around(result, 0.5), names, onset_s=_onset(result))


@in_style
def plot_all_torques(results: dict[str, Result]) -> Figure:
    """Torque as printed and simulated torque during one perturbation of every condition (s, N·m)."""
    label = r"$\tau_A$ (N·m)"
    figure, example = _all(results, "tau", 0.5, label, _draw_torque, label)
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


def draw_simulation_trial(files, chosen) -> Iterator[tuple[str, Figure]]:
    """Swing and angle of one trial (``fit``)."""
    yield "figure_b_trial", plot_angles(read_result(files.fit))
