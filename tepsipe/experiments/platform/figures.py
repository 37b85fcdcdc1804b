"""Figures of a person on a moving platform."""

from collections.abc import Iterator, Mapping, Sequence
from itertools import cycle

import numpy as np
from matplotlib.figure import Figure

from tepsipe.drawing.style import COLOURS, CYCLE, in_style, new_figure
from tepsipe.io.estimates import ESTIMATES, Estimate
from tepsipe.io.result import Result, read_result

SHOWN_S = 12.0
TICKS_HZ = (0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0)
KINDS = {"K_": "at once", "K_reflex_": "reflex", "K_static_": "static", "K_mode_": "slow mode"}


def draw_platform(files, chosen) -> Iterator[tuple[str, Figure]]:
    """Figures of the fits and estimates of all trials."""
    names = list(chosen.conditions)
    results = {name: read_result(path) for name, path in zip(names, files.fits, strict=True)}
    estimates = {name: ESTIMATES.read(path) for name, path in zip(names, files.estimates, strict=True)}
    yield "figure_platform_responses", plot_responses(results)
    yield "figure_platform_quantities", plot_quantities(results, estimates)
    yield "figure_platform_prediction", plot_prediction(results)


@in_style
def plot_responses(results: Mapping[str, Result]) -> Figure:
    """Responses of angles and torques to the platform, and coherence (Hz, units of the result)."""
    joints = next(iter(results.values())).facts["joints"]
    figure, axes = new_figure(3, len(joints), 4.6, sharex=True, sharey="row", squeeze=False)
    for colour, (name, result) in zip(cycle(CYCLE), results.items(), strict=False):
        f, facts = result.arrays["frequency"], result.facts
        for k, joint in enumerate(joints):
            axes[0, k].loglog(
                f, np.abs(result.arrays["angle_response"][:, k]), ".", ms=3, color=colour, label=name
            )
            axes[1, k].loglog(f, np.abs(result.arrays["torque_response"][:, k]), ".", ms=3, color=colour)
            axes[1, k].loglog(f, np.abs(result.arrays["torque_response_model"][:, k]), color=colour, lw=0.9)
            coherence = result.arrays["coherence"]
            axes[2, k].semilogx(f, coherence[:, k], color=colour)
            axes[2, k].semilogx(f, coherence[:, len(joints) + k], "--", color=colour, lw=0.9)
            axes[2, k].axhline(facts["coherence_threshold"], color=COLOURS["other"], lw=0.7)
            axes[0, k].set_title(joint.capitalize())
            axes[2, k].set(xlabel="Frequency (Hz)", ylim=(0.0, 1.05))
            _plain_ticks(axes[:, k], f)
    unit = next(iter(results.values())).facts["platform_unit"].replace("s2", "s²")
    axes[0, 0].set_ylabel(f"Angle (rad per {unit})")
    axes[1, 0].set_ylabel(f"Torque (N·m per {unit})")
    axes[2, 0].set_ylabel("Coherence (–)")
    axes[0, 0].legend(loc="best")
    for style, label in (("-", "angle"), ("--", "torque")):
        axes[2, 0].plot([], [], style, color=COLOURS["measured"], label=label)
    axes[2, 0].legend(loc="lower left")
    figure.align_ylabels()
    return figure


def _plain_ticks(axes, frequency: np.ndarray) -> None:
    """Few ticks on logarithmic axes (Hz), in plain numbers."""
    ticks = [x for x in TICKS_HZ if frequency[0] <= 1.1 * x and x <= 1.1 * frequency[-1]]
    axes[-1].set_xticks(ticks, [f"{x:g}" for x in ticks])
    axes[-1].minorticks_off()
    for axis in axes[:2]:
        axis.yaxis.set_minor_formatter("")


@in_style
def plot_quantities(results: Mapping[str, Result], estimates: Mapping[str, Sequence[Estimate]]) -> Figure:
    """Stiffness of every model with its interval; what is not identified has a cross (N·m/rad)."""
    first = next(iter(results.values()))
    joints, models = first.facts["joints"], first.facts["order"]
    labels = {joint: _labels(joint, joints, estimates) for joint in joints}
    tall = max(map(len, labels.values()))
    figure, axes = new_figure(1, len(joints), 1.3 + 0.42 * tall, squeeze=False)
    marks = dict(zip(models, "osD", strict=False))
    for axis, joint in zip(axes[0], joints, strict=True):
        names = labels[joint]
        spread = 0.7 / max(1, len(models) * len(results))
        for t, (colour, (condition, rows)) in enumerate(zip(cycle(CYCLE), estimates.items(), strict=False)):
            for m, model in enumerate(models):
                offset = spread * (t * len(models) + m - 0.5 * (len(models) * len(results) - 1))
                _draw_model(axis, rows, model, names, offset, (colour, marks[model]), results[condition])
        axis.axvline(0.0, color=COLOURS["other"], linewidth=0.7)
        axis.set_yticks(range(len(names)), list(names.values()))
        axis.set(ylim=(len(names) - 0.4, -0.6), xlabel=f"Stiffness of the {joint} (N·m/rad)")
    handles = [
        axes[0, 0].plot([], [], marks[m], color=COLOURS["measured"], ms=4, label=m.replace("-", " "))[0]
        for m in models
    ]
    handles.append(axes[0, 0].plot([], [], "x", color=COLOURS["other"], ms=5, label="not identified")[0])
    if len(results) > 1:
        handles += [
            axes[0, 0].plot([], [], color=colour, label=condition)[0]
            for colour, condition in zip(cycle(CYCLE), results, strict=False)
        ]
    figure.legend(handles=handles, loc="outside upper center", ncols=4)
    return figure


def _labels(joint: str, joints: Sequence[str], estimates: Mapping[str, Sequence[Estimate]]) -> dict[str, str]:
    """Stiffness of a joint -> its label: kind, and whose angle."""
    there = {row.quantity for rows in estimates.values() for row in rows}
    found = {}
    for start, kind in KINDS.items():
        for name in (joint,) if start == "K_mode_" else [f"{joint}_{other}" for other in joints]:
            if f"{start}{name}" in there:
                found[f"{start}{name}"] = kind if start == "K_mode_" else f"{kind}, {name.split('_')[1]}"
    return found


def _draw_model(axis, rows, model: str, names: dict[str, str], offset: float, style, result: Result) -> None:
    """Values of one model in one trial, pale if it is rejected."""
    colour, mark = style
    pale = 0.35 if result.facts["models"][model]["rejected"] else 1.0
    own = {row.quantity: row for row in rows if row.estimator == f"iv-{model}"}
    for k, name in enumerate(names):
        row = own.get(name)
        if row is None:
            continue
        if not np.isfinite(row.value):
            axis.plot(0.0, k + offset, "x", color=COLOURS["other"], ms=5)
            continue
        axis.plot([row.ci_low, row.ci_high], [k + offset] * 2, color=colour, alpha=pale)
        axis.plot(row.value, k + offset, mark, color=colour, alpha=pale, ms=4)


@in_style
def plot_prediction(results: Mapping[str, Result]) -> Figure:
    """Torques at the start of the held-out part, measured and predicted by the recommended model (s, N·m)."""
    joints = next(iter(results.values())).facts["joints"]
    figure, axes = new_figure(
        len(results) * len(joints), 1, 0.6 + 1.7 * len(results) * len(joints), squeeze=False
    )
    rows = iter(axes[:, 0])
    for name, result in results.items():
        time, start = result.arrays["time"], result.facts["held_out_from_s"]
        shown = (time >= start) & (time <= start + SHOWN_S)
        for k, joint in enumerate(joints):
            axis = next(rows)
            axis.plot(
                time[shown], result.arrays["torque"][shown, k], color=COLOURS["measured"], label="measured"
            )
            predicted = result.arrays["predicted_torque"]
            axis.plot(time[shown], predicted[shown, k], color=COLOURS["recommended"], label="predicted")
            axis.set(ylabel="Torque (N·m)", title=f"{name}, {joint}")
            axis.margins(x=0.0, y=0.1)
    axes[0, 0].legend(loc="upper right", ncols=2)
    axes[-1, 0].set_xlabel("Time (s)")
    return figure
