"""Figures of a person standing on the treadmill (thesis Figures 4-13 and 4-14, and their continuation)."""

from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from tepsipe.drawing.names import words
from tepsipe.drawing.style import COLOURS, CYCLE, example_and_panels, in_style, new_figure
from tepsipe.io.result import Result, read_result

TASK_COLOURS = ("#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#4b4b4b")
DETECTOR_STYLES = {"threshold": ":", "teager-kaiser": "--", "changepoint": "-"}


def draw_standing(files, chosen) -> Iterator[tuple[str, Figure]]:
    """Figures of the ``example`` trial, of the ``trials`` of one person, and of the ``tasks``."""
    example = read_result(files.example)
    trials = dict(zip(chosen.conditions, map(read_result, files.trials), strict=True))
    tasks = dict(zip(chosen.tasks, map(read_result, files.tasks), strict=True))
    pathway, estimator = chosen.recommended["pathway"], chosen.recommended["estimator"]
    yield "figure_4_13", plot_processed(example)
    yield "figure_4_14", plot_activity(example)
    yield "figure_standing_activity", plot_ensembles(trials, chosen.groups, chosen.muscles)
    yield "figure_standing_latency", plot_latencies(tasks, chosen.detector)
    yield "figure_standing_response", plot_torque_parts(tasks, chosen.active)
    estimators = [estimator, *chosen.active]
    yield "figure_standing_stiffness", plot_stiffness(trials, tasks, chosen.task_of, pathway, estimators)
    yield "figure_standing_window", plot_windows(tasks, chosen.window_s, pathway, estimator)
    yield "figure_standing_joints", plot_joints(tasks)


def _task_colours(tasks: list[str]) -> dict[str, str]:
    return {task: TASK_COLOURS[k % len(TASK_COLOURS)] for k, task in enumerate(tasks)}


def _nothing(figure: Figure, sentence: str) -> Figure:
    """A figure with the reason why it shows no data."""
    figure.text(0.5, 0.5, sentence, ha="center", va="center", wrap=True)
    return figure


@in_style
def plot_processed(result: Result) -> Figure:
    """Ankle angle, velocity, acceleration and torque of a whole trial: Figure 4-13 (s, rad, N·m)."""
    figure, axes = new_figure(4, 1, 3.5, sharex=True)
    arrays = result.arrays
    time = arrays["processed/time"]
    rows = (
        ("ankle", r"$\theta_A$ (rad)"),
        ("ankle_d", r"$\dot{\theta}_A$ (rad/s)"),
        ("ankle_dd", r"$\ddot{\theta}_A$ (rad/s$^2$)"),
    )
    for axis, (key, label) in zip(axes, rows, strict=False):
        axis.plot(time, arrays[f"processed/{key}"], color=COLOURS["measured"], linewidth=0.6, rasterized=True)
        axis.set(ylabel=label)
    torques = result.facts["torques"]
    printed = zip(torques["as_printed"], arrays["processed/torque_as_printed"], strict=True)
    # the wide line shows beside the recommended torque, which hides a thin one where they agree
    styles = ((COLOURS["as printed"], 1.6), (COLOURS["other"], 0.6))
    for (pathway, torque), (colour, width) in zip(printed, styles, strict=False):
        axes[3].plot(time, torque, color=colour, linewidth=width, label=words(pathway), rasterized=True)
    recommended, label = arrays["processed/torque_recommended"], words(torques["recommended"])
    axes[3].plot(time, recommended, color=COLOURS["recommended"], linewidth=0.6, label=label, rasterized=True)
    axes[3].set(ylabel=r"$\tau_A$ (N·m)", xlabel="Time (s)")
    axes[3].legend(loc="lower center", bbox_to_anchor=(0.5, 0.97), ncols=3)
    for axis in axes:
        axis.margins(x=0.0)
    figure.align_ylabels()
    return figure


@in_style
def plot_activity(result: Result) -> Figure:
    """Electromyograms after every perturbation, and fore-aft force: Figure 4-14 (ms, uV, N)."""
    muscles, arrays = result.facts["muscles"], result.arrays
    responses = arrays["envelope"].shape[0]
    if not responses:
        return _nothing(new_figure()[0], result.facts["left_out"][0])
    height_in = 0.7 + 0.54 * (len(muscles) + 1)
    figure, axes = new_figure(len(muscles) + 1, 1, height_in, sharex=True, squeeze=False)
    axes = axes[:, 0]
    time = 1e3 * arrays["time"]
    shown = (time >= -100.0) & (time <= 600.0)
    rows = [(arrays["envelope"][:, shown, k], f"{m}\n(\N{MICRO SIGN}V)") for k, m in enumerate(muscles)]
    rows.append((arrays["perturbed/f_y"][:, shown], "$F_y$\n(N)"))
    for axis, (values, label) in zip(axes, rows, strict=True):
        axis.plot(time[shown], values.T, color=COLOURS["other"], linewidth=0.5)
        axis.plot(time[shown], values.mean(axis=0), color=COLOURS["recommended"], linewidth=1.4)
        axis.axvline(0.0, color=COLOURS["measured"], linewidth=0.6)
        axis.set(ylabel=label)
        axis.margins(x=0.0)
    axes[0].plot([], [], color=COLOURS["other"], linewidth=0.5, label=f"each of {responses} perturbations")
    axes[0].plot([], [], color=COLOURS["recommended"], linewidth=1.4, label="mean")
    axes[0].legend(loc="lower center", bbox_to_anchor=(0.5, 0.97), ncols=2)
    axes[-1].set(xlabel="Time from the onset of the perturbation (ms)")
    figure.align_ylabels()
    return figure


@in_style
def plot_ensembles(trials: dict[str, Result], groups: dict[str, list[str]], muscles: list[str]) -> Figure:
    """Rectified electromyograms, mean and standard deviation over the perturbations of each trial (ms, uV).

    ``groups`` holds the conditions of every column, by its title; ``muscles`` are the rows.
    """
    columns = len(groups)
    figure, example, axes = example_and_panels(
        columns * len(muscles), columns, 1.8 + 0.56 * len(muscles), example=1.9, sharey="row"
    )
    for column, (title, conditions) in enumerate(groups.items()):
        axes[0, column].set_title(_forwards_or_backwards(title), fontsize=8.5)
        axes[-1, column].set(xlabel="Time (ms)")
        for row, muscle in enumerate(muscles):
            _draw_ensemble(axes[row, column], trials, conditions, muscle, CYCLE[column % len(CYCLE)])
    for row, muscle in enumerate(muscles):
        axes[row, 0].set(ylabel=f"{muscle}\n(\N{MICRO SIGN}V)")
    title, conditions = next(iter(groups.items()))
    _draw_ensemble(example, trials, conditions, muscles[0], CYCLE[0])
    _explain_ensemble(example, trials[conditions[-1]], muscles[0], len(conditions))
    example.set_title(f"{muscles[0]}, {_forwards_or_backwards(title)}", fontsize=8.5)
    example.set(xlabel="Time from the onset (ms)", ylabel=f"{muscles[0]} (\N{MICRO SIGN}V)")
    return figure


def _forwards_or_backwards(title: str) -> str:
    """Task and profile in words, for example "relax, first backwards" for relax, negative-sine."""
    task, comma, profile = title.rpartition(", ")
    if not comma:
        return title
    return f"{task}, first {'backwards' if profile.startswith('negative-') else 'forwards'}"


def _draw_ensemble(
    axis: Axes, trials: dict[str, Result], conditions: list[str], muscle: str, base: str
) -> None:
    """Mean of every trial, darker with the amplitude, and the standard deviation of the last (ms, uV)."""
    for k, condition in enumerate(conditions):
        shade = 0.3 + 0.7 * (k + 1) / len(conditions)
        colour = tuple(1.0 - shade * (1.0 - part) for part in to_rgb(base))
        arrays = trials[condition].arrays
        if f"activity/{muscle}" not in arrays:
            continue
        time = 1e3 * arrays["mean/time"]
        shown = (time >= -50.0) & (time <= 400.0)
        mean, sd = arrays[f"activity/{muscle}"][:, shown]
        axis.plot(time[shown], mean, color=colour, linewidth=0.9)
        if k == len(conditions) - 1:
            axis.fill_between(time[shown], mean - sd, mean + sd, color=colour, alpha=0.2, linewidth=0.0)
    axis.axvline(0.0, color=COLOURS["measured"], linewidth=0.6)
    axis.margins(x=0.0)


def _explain_ensemble(axis: Axes, last: Result, muscle: str, trials: int) -> None:
    """Notes in the large panel: onset of the belt, largest response, spread (ms, uV)."""
    if f"activity/{muscle}" not in last.arrays:
        return
    time = 1e3 * last.arrays["mean/time"]
    shown = (time >= 0.0) & (time <= 400.0)
    mean, sd = last.arrays[f"activity/{muscle}"][:, shown]
    peak, at = float(mean.max()), float(time[shown][mean.argmax()])
    line = {"arrowstyle": "-", "lw": 0.6}
    which = "largest amplitude" if trials > 1 else "mean"
    for text, point, place in (
        ("the belt\nstarts", (0.0, 0.5 * peak), (-45.0, 0.75 * peak)),
        (f"{which}: {peak:.0f} \N{MICRO SIGN}V after {at:.0f} ms", (at, peak), (at + 60.0, 0.95 * peak)),
        (
            "band: standard deviation over its perturbations",
            (at + 8.0, float(np.interp(at + 8.0, time[shown], mean - 0.5 * sd))),
            (at + 60.0, 0.6 * peak),
        ),
    ):
        axis.annotate(text, point, place, fontsize=8.0, va="center", arrowprops=line)


@in_style
def plot_latencies(results: dict[str, Result], detector: str) -> Figure:
    """Mean rectified electromyograms from the start of the stretch, and latencies of muscles (ms, uV)."""
    latencies = {task: result.facts["latencies"] for task, result in results.items()}
    order = next(iter(results.values())).facts["muscles"]
    muscles = [muscle for muscle in order if any(muscle in found for found in latencies.values())]
    if not muscles:
        return _nothing(new_figure()[0], "no muscle responds in any task")
    figure, axes = new_figure(
        len(muscles), len(results), 0.9 + 0.56 * len(muscles), sharex=True, squeeze=False
    )
    for column, (task, result) in enumerate(results.items()):
        for row, muscle in enumerate(muscles):
            axis = axes[row, column]
            if column == 0:
                axis.set(ylabel=f"{muscle}\n(\N{MICRO SIGN}V)")
            if muscle not in latencies[task]:
                axis.text(0.5, 0.5, "left out", ha="center", va="center", transform=axis.transAxes)
                continue
            time = 1e3 * result.arrays[f"latency/{muscle}/time"]
            shown = (time >= -50.0) & (time <= 120.0)
            rectified = result.arrays[f"latency/{muscle}/rectified"]
            axis.plot(time[shown], rectified[shown], color=COLOURS["measured"], linewidth=0.9)
            for name, style in DETECTOR_STYLES.items():
                found = latencies[task][muscle][name]
                if found["latency_s"] is not None:
                    axis.axvline(
                        1e3 * found["latency_s"], color=COLOURS["model"], linestyle=style, linewidth=1.0
                    )
            chosen = latencies[task][muscle][detector]
            if chosen["interval_s"]:
                axis.axvspan(*(1e3 * np.array(chosen["interval_s"])), color=COLOURS["window"], linewidth=0.0)
            axis.set_ylim(bottom=0.0)
            axis.margins(x=0.0)
        axes[0, column].set(title=task)
        axes[-1, column].set(xlabel="Time from the start of the stretch (ms)")
    _explain_latency(axes[0, 0], next(iter(latencies.values())).get(muscles[0]), detector)
    handles = [
        axes[0, 0].plot([], [], style, color=COLOURS["model"], linewidth=1.0, label=words(name))[0]
        for name, style in DETECTOR_STYLES.items()
    ]
    handles.append(
        axes[0, 0].fill([], [], color=COLOURS["window"], label=f"95 % interval, {words(detector)}")[0]
    )
    figure.legend(handles=handles, loc="outside lower center", ncols=4)
    figure.align_ylabels()
    return figure


def _explain_latency(axis: Axes, found: dict | None, detector: str) -> None:
    """Note in the first panel: the latency that is used (ms)."""
    latency = None if found is None else found[detector]["latency_s"]
    if latency is None:
        return
    axis.annotate(
        f"onset after {1e3 * latency:.0f} ms",
        (1e3 * latency, 0.75 * axis.get_ylim()[1]),
        (-45.0, 0.75 * axis.get_ylim()[1]),
        fontsize=8.0,
        va="center",
        arrowprops={"arrowstyle": "-|>", "lw": 0.6},
    )


@in_style
def plot_torque_parts(results: dict[str, Result], estimators: list[str]) -> Figure:
    """Mean torque after perturbations, and its intrinsic and active parts (ms, N·m)."""
    there = [
        name
        for name in estimators
        if all(f"curve/{name}/torque" in result.arrays for result in results.values())
    ]
    if not there:
        return _nothing(new_figure()[0], "no estimator of the active torque could be used in every task")
    figure, axes = new_figure(len(there), len(results), 0.6 + 1.35 * len(there), sharex="row", squeeze=False)
    for row, name in enumerate(there):
        for column, (task, result) in enumerate(results.items()):
            axis, arrays = axes[row, column], result.arrays
            # the trial with the largest response shows the parts best
            k = int(np.ptp(arrays[f"curve/{name}/torque"], axis=1).argmax())
            time = 1e3 * arrays[f"curve/{name}/time"]
            torque, intrinsic, active = (
                arrays[f"curve/{name}/{part}"][k] for part in ("torque", "intrinsic", "active")
            )
            axis.plot(time, torque, color=COLOURS["measured"], linewidth=1.6, label="measured")
            axis.plot(time, intrinsic + active, color=COLOURS["model"], label="model")
            axis.plot(time, intrinsic, "--", color=COLOURS["recommended"], label="intrinsic part")
            axis.plot(time, active, "--", color=COLOURS["compensated"], label="active part")
            axis.set(title=f"{task}, {words(name)}")
            axis.margins(x=0.0)
            if column == 0:
                axis.set(ylabel="Change of torque\n" + r"$\tau_A$ (N·m)")
            axis.set(xlabel="Time from the onset (ms)")
    handles, labels = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=4)
    return figure


@in_style
def plot_stiffness(
    trials: dict[str, Result],
    tasks: dict[str, Result],
    task_of: dict[str, str],
    pathway: str,
    estimators: list[str],
) -> Figure:
    """Ankle stiffness against ankle rotation, with 95 % intervals (mrad, N·m/rad)."""
    figure, axes = new_figure(1, len(estimators), 2.4, sharey=True, squeeze=False)
    colours = _task_colours(list(tasks))
    critical_stiffness = next(iter(tasks.values())).facts["critical_stiffness_Nm_per_rad"]
    for axis, estimator in zip(axes[0], estimators, strict=True):
        key = f"K/{pathway}/{estimator}"
        for condition, result in trials.items():
            if key not in result.arrays:
                continue
            value, low, high = result.arrays[key]
            rotation = 1e3 * float(result.arrays[f"rotation/{pathway}/{estimator}"])
            error = [[max(0.0, value - low)], [max(0.0, high - value)]]
            axis.errorbar(
                rotation,
                value,
                error,
                fmt="o",
                color=colours[task_of[condition]],
                markersize=3.5,
                linewidth=0.9,
            )
        for task, result in tasks.items():
            if key in result.arrays:
                value, low, high = result.arrays[key]
                axis.axhspan(low, high, color=colours[task], alpha=0.16, linewidth=0.0)
                axis.axhline(value, color=colours[task], linewidth=0.9)
        axis.axhline(critical_stiffness, color=COLOURS["measured"], linewidth=0.8, linestyle="--")
        axis.set(title=words(estimator), xlabel="Rotation of the ankle (mrad)")
        axis.set_ylim(bottom=min(0.0, axis.get_ylim()[0]))
    axes[0, 0].set(ylabel="$K$ (N·m/rad)")
    handles = [
        axes[0, 0].plot([], [], "o-", color=colour, markersize=3.5, label=task)[0]
        for task, colour in colours.items()
    ]
    handles.append(
        axes[0, 0].plot([], [], "--", color=COLOURS["measured"], linewidth=0.8, label="$m g h$")[0]
    )
    figure.legend(handles=handles, loc="outside lower center", ncols=4)
    return figure


@in_style
def plot_windows(results: dict[str, Result], window_s: float, pathway: str, estimator: str) -> Figure:
    """Ankle stiffness against the length of the window, without and with a free reflex torque (ms, N·m/rad).

    results: task -> its result.
    window_s: window of the estimate.
    pathway, estimator: the recommended ones, whose combined interval is shown.
    """
    figure, axis = new_figure(height_in=2.3)
    for (task, result), colour in zip(results.items(), _task_colours(list(results)).values(), strict=True):
        length = 1e3 * result.arrays["windows/length"]
        if not length.size:
            continue
        value, low, high = result.arrays["windows/K"].T
        axis.fill_between(length, low, high, color=colour, alpha=0.2, linewidth=0.0)
        axis.plot(length, value, "o-", color=colour, markersize=3.5, label=task)
        if f"budget/{estimator}/windows" in result.arrays:
            tried = result.arrays[f"budget/{estimator}/windows"]
            label = f"{task}, {words(estimator)}"
            axis.plot(1e3 * tried[:, 0], tried[:, 2], "--", color=colour, linewidth=2.0, label=label)
        if f"K/{pathway}/{estimator}" in result.arrays:
            best, low, high = result.arrays[f"K/{pathway}/{estimator}"]
            error = [[max(0.0, best - low)], [max(0.0, high - best)]]
            axis.errorbar(1e3 * window_s, best, error, fmt="s", color=colour, markersize=4.5, capsize=3.0)
    axis.axvline(1e3 * window_s, color=COLOURS["other"], linestyle="--", label="window of the estimate")
    axis.axhline(0.0, color=COLOURS["measured"], linewidth=0.5)
    axis.set(xlabel="Length of the window from the onset (ms)", ylabel="$K$ (N·m/rad)")
    axis.legend(loc="upper right")
    return figure


@in_style
def plot_joints(results: dict[str, Result]) -> Figure:
    """Rotation of shank, thigh and knee after a perturbation, equal for one rigid body (ms, mrad)."""
    shown = {task: result for task, result in results.items() if "mean/time" in result.arrays}
    if not shown:
        return _nothing(new_figure()[0], "no trial has usable responses")
    figure, axes = new_figure(1, len(shown), 2.1, sharey=True, squeeze=False)
    for axis, (task, result) in zip(axes[0], shown.items(), strict=True):
        arrays = result.arrays
        time = 1e3 * arrays["mean/time"]
        inside = (time >= -50.0) & (time <= 400.0)
        k = int(np.ptp(arrays["mean/shank"], axis=1).argmax())
        for colour, (segment, label) in zip(
            CYCLE, (("shank", "shank"), ("thigh", "thigh"), ("knee", "knee")), strict=False
        ):
            axis.plot(
                time[inside],
                1e3 * arrays[f"mean/{segment}"][k][inside],
                color=colour,
                label=label,
                linewidth=1.2,
            )
        axis.set(title=task, xlabel="Time from the onset (ms)")
        axis.margins(x=0.0)
    axes[0, 0].set(ylabel="Mean rotation (mrad)")
    axes[0, 0].legend(loc="upper right")
    return figure


def draw_standing_trials(files, chosen) -> Iterator[tuple[str, Figure]]:
    """Two figures of the responses of a trial."""
    result = read_result(files.responses)
    yield "4_13", plot_processed(result)
    yield "4_14", plot_activity(result)
