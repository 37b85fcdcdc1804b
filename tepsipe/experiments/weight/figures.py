"""Figures of the weight experiment and of the treadmill's models (thesis Figures 4-5, 4-6, 5-1)."""

from collections.abc import Iterator

import numpy as np
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure

from tepsipe.drawing.names import short_name, words
from tepsipe.drawing.style import COLOURS, MODEL_COLOURS, in_style, new_figure
from tepsipe.experiments.weight.calibrate import USUAL_ONLY
from tepsipe.io.result import Result, read_result
from tepsipe.treadmill.calibration import ALL_EMPTY, BOTH, MODEL_SCORES, ModelScore

PROFILE_COLOURS = {"S": "#0072b2", "M": "#d55e00"}


def draw_weight(files, chosen) -> Iterator[tuple[str, Figure]]:
    """Figures of the fits with and without a weight, and of the treadmill's models (``plate``)."""
    weight = dict(zip(chosen.weight, map(read_result, files.weight), strict=True))
    empty = dict(zip(chosen.empty, map(read_result, files.empty), strict=True))
    plate, scores = read_result(files.plate), MODEL_SCORES.read(files.scores)
    first_hz, last_hz = chosen.cutoffs_hz[0], chosen.cutoffs_hz[-1]
    yield "figure_4_5", plot_added_forces(empty, weight, f"{first_hz:g} Hz", list(weight))
    yield "figure_4_6", plot_masses(weight, chosen.mass_kg)
    yield "figure_5_1", plot_added_forces(empty, weight, f"{last_hz:g} Hz", list(chosen.coarse))
    yield "figure_plate_models", plot_model_scores(scores, "Fy", first_hz)
    yield "figure_plate_responses", plot_model_responses(plate, chosen.example, plate.facts["models"])


def _shades(names: list[str]) -> dict[str, tuple]:
    """One colour per profile, darker with amplitude; other names have shades of grey in their order."""
    groups: dict[str, list[str]] = {}
    for name in names:
        groups.setdefault(PROFILE_COLOURS.get(short_name(name)[:1], COLOURS["measured"]), []).append(name)
    shades = {}
    for colour, group in groups.items():
        for k, name in enumerate(group):
            weight = 0.3 + 0.7 * (k + 1) / len(group)
            shades[name] = tuple(1.0 - weight * (1.0 - part) for part in to_rgb(colour))
    return shades


@in_style
def plot_added_forces(
    empty: dict[str, Result], weight: dict[str, Result], filter_name: str, shown: list[str]
) -> Figure:
    """Mean force of the empty belt, and mean belt-induced force under a weight (ms, N).

    ``shown`` names the conditions.
    """
    figure, axes = new_figure(1, 2, 2.2)
    panels = ((empty, r"empty belt $F_{y0}$"), (weight, r"weight $\Delta F_y = F_y - \hat{F}_y$"))
    for axis, (results, title) in zip(axes, panels, strict=True):
        names = [name for name in results if name in shown]
        shades = _shades(names)
        for name in names:
            mean = results[name].arrays[f"{filter_name}/added_force"].mean(axis=0)
            time = 1e3 * np.arange(mean.size) / results[name].facts["rate_hz"]
            axis.plot(time, mean, color=shades[name], label=short_name(name), linewidth=1.0)
        axis.set(title=title, xlabel="Time from the onset (ms)", ylabel="Force (N)")
        axis.margins(x=0.0)
    figure.legend(*axes[1].get_legend_handles_labels(), loc="outside right upper", handlelength=1.2)
    return figure


@in_style
def plot_masses(results: dict[str, Result], mass_kg: float) -> Figure:
    """Estimated mass of the weight over all perturbations (kg)."""
    figure, axes = new_figure(height_in=2.1)
    names = [short_name(name) for name in results]
    axes.axhline(mass_kg, color=COLOURS["other"], linewidth=0.8, linestyle="--", label="weighed")
    axes.boxplot(
        [result.arrays["masses"] for result in results.values()],
        tick_labels=names,
        widths=0.55,
        medianprops={"color": COLOURS["model"]},
        flierprops={"markersize": 3},
    )
    axes.set(xlabel="Perturbation profile and velocity amplitude", ylabel=r"Estimated mass $\hat{m}_w$ (kg)")
    axes.grid(axis="x", visible=False)
    axes.legend(loc="upper right")
    return figure


@in_style
def plot_model_scores(scores: list[ModelScore], load: str, cutoff_hz: float) -> Figure:
    """R2 of every model on held-out trials, by the recordings of its fit (-)."""
    chosen = [s for s in scores if s.load == load and s.cutoff_hz == cutoff_hz]
    tests = list(dict.fromkeys(s.test for s in chosen))
    models = list(dict.fromkeys(s.model for s in chosen))
    trains = list(dict.fromkeys(s.train for s in chosen))
    marks = dict(zip(trains, "os^Dv", strict=False))
    figure, axes = new_figure(1, len(tests), 3.1, sharey=True, squeeze=False)
    for axis, test in zip(axes[0], tests, strict=True):
        rows = [s for s in chosen if s.test == test]
        limit = rows[0].r2_limit
        axis.axvline(limit, color=COLOURS["other"], linewidth=0.8, linestyle="--")
        for s in rows:
            axis.plot(
                max(s.r2, -1.0),
                models.index(s.model),
                marks[s.train] if s.r2 >= -1.0 else "<",
                color=MODEL_COLOURS[s.model],
                markersize=5.5,
            )
        axis.set(title=test, xlabel="$R^2$", xlim=(-1.08, 1.08), xticks=[-0.5, 0.0, 0.5, 1.0])
        axis.axvline(0.0, color="#c4c4c4", linewidth=0.6)
    axes[0, 0].set_yticks(range(len(models)), [words(name) for name in models])
    axes[0, 0].invert_yaxis()
    figure.suptitle("evaluated on held-out trials of", fontsize=9.5)
    # with further weights, the frames have a fit without them, too
    meant = {ALL_EMPTY: "all trials of the empty belt"}
    if any(s.train == USUAL_ONLY for s in chosen):
        meant[BOTH] = "empty, all weights"
    handles = [
        axes[0, 0].plot(
            *([], [], mark),
            color=COLOURS["measured"],
            markersize=5.5,
            label=f"fitted to {meant.get(train, train)}",
        )[0]
        for train, mark in marks.items()
    ]
    handles.append(
        axes[0, 0].plot([], [], "--", color=COLOURS["other"], linewidth=0.8, label="limit of a linear model")[
            0
        ]
    )
    figure.legend(handles=handles, loc="outside lower center", ncols=3, fontsize=7.8)
    return figure


@in_style
def plot_model_responses(result: Result, condition: str, models: list[str]) -> Figure:
    """Belt-induced force under the weight, measured and predicted, mean over perturbations (ms, N)."""
    figure, axes = new_figure(1, 2, 2.2)
    measured = result.arrays[f"{condition}/measured"]
    time = 1e3 * np.arange(measured.size) / result.facts["rate_hz"]
    axes[0].plot(time, measured, color=COLOURS["measured"], linewidth=1.6, label="measured")
    for model in [m for m in models if f"{condition}/{m}" in result.arrays]:
        predicted = result.arrays[f"{condition}/{model}"]
        axes[0].plot(time, predicted, color=MODEL_COLOURS[model], label=words(model), linewidth=1.0)
        axes[1].plot(time, measured - predicted, color=MODEL_COLOURS[model], linewidth=1.0)
    axes[1].plot(time, measured, color=COLOURS["measured"], linewidth=1.6)
    axes[0].set(title="measured and predicted", xlabel="Time from the onset (ms)", ylabel=r"$\Delta F_y$ (N)")
    axes[1].set(
        title="measured, and residuals of the models", xlabel="Time from the onset (ms)", ylabel="Force (N)"
    )
    low = min(axis.get_ylim()[0] for axis in axes)
    high = max(axis.get_ylim()[1] for axis in axes)
    for axis in axes:
        axis.set_ylim(low, high)
        axis.margins(x=0.0)
    figure.legend(loc="outside lower center", ncols=4, fontsize=7.8)
    return figure
