"""Figures of a treadmill's calibration: prediction, size of the filter, ripple of the rollers."""

from collections.abc import Iterator

import numpy as np
from matplotlib.figure import Figure

from tepsipe.drawing.names import words
from tepsipe.drawing.style import COLOURS, MODEL_COLOURS, in_style, new_figure
from tepsipe.io.result import Result, read_result
from tepsipe.quantities import unit_symbol
from tepsipe.treadmill.calibration import MODEL_SCORES, ModelScore

# length of the calibration that is drawn (s), and points of a curve with narrow lines
SHOWN_S, POINTS = 6.0, 900


def draw_belt(files, chosen) -> Iterator[tuple[str, Figure]]:
    """Figures of a treadmill's calibration (``fit``) and of the scores of its models."""
    result, scores = read_result(files.fit), MODEL_SCORES.read(files.scores)
    yield "figure_belt_prediction", plot_calibration(result, scores, chosen.model)
    yield "figure_belt_cutoff", plot_cutoffs(scores, result.facts["recordings"][0])
    yield "figure_belt_ripple", plot_ripple(result)


@in_style
def plot_calibration(result: Result, scores: list[ModelScore], chosen: str) -> Figure:
    """Measured, predicted and compensated load of the first test recording (s, unit of the load)."""
    facts = result.facts
    name, unit = facts["recordings"][0], unit_symbol(facts["unit"])
    count = round(SHOWN_S * facts["rate_hz"])
    time, measured, predicted, velocity = (
        result.arrays[f"{name}/{key}"][:count] for key in ("time", "measured", chosen, "belt_velocity")
    )
    r2 = next(
        s.r2 for s in scores if s.model == chosen and s.test == name and s.cutoff_hz == facts["cutoff_hz"]
    )
    figure, axes = new_figure(3, 1, 3.9, sharex=True, height_ratios=[1, 1.4, 1.4])
    axes[0].plot(time, velocity, color=COLOURS["measured"])
    axes[0].set_ylabel("Belt velocity\n(m/s)")
    axes[1].plot(time, measured, color=COLOURS["measured"], label="measured")
    axes[1].plot(
        time,
        predicted,
        color=MODEL_COLOURS[chosen],
        linestyle="--",
        label=f"predicted by {words(chosen)}, $R^2$ = {r2:.3f} over the recording",
    )
    axes[2].plot(time, measured, color=COLOURS["other"], linewidth=0.8, label="measured")
    axes[2].plot(time, measured - predicted, color=MODEL_COLOURS[chosen], label="compensated")
    for axis in axes[1:]:
        axis.set_ylabel(f"Load ({unit})")
        axis.margins(y=0.28)
        axis.legend(loc="upper left", ncols=2)
    axes[2].set_xlabel(f"Time in recording {name} (s)")
    axes[2].margins(x=0.0)
    figure.align_ylabels()
    return figure


@in_style
def plot_cutoffs(scores: list[ModelScore], test: str) -> Figure:
    """RMS before and after compensation, and R2 with its limit, against the filter's cutoff (Hz)."""
    rows = [s for s in scores if s.test == test]
    unit = unit_symbol(rows[0].unit)
    cutoffs = sorted({s.cutoff_hz for s in rows})
    models = list(dict.fromkeys(s.model for s in rows))
    figure, axes = new_figure(1, 2, 3.4)

    def of(model: str, key: str) -> list[float]:
        by_cutoff = {s.cutoff_hz: getattr(s, key) for s in rows if s.model == model}
        return [by_cutoff[cutoff] for cutoff in cutoffs]

    axes[0].plot(cutoffs, of(models[0], "rms_before"), color=COLOURS["measured"], label="not compensated")
    for model in models:
        axes[0].plot(cutoffs, of(model, "rms_after"), color=MODEL_COLOURS[model])
        axes[1].plot(
            cutoffs,
            of(model, "r2"),
            color=MODEL_COLOURS[model],
            linestyle=":" if model == "ripple-tracking" else "-",
            label=words(model),
        )
    if "ripple-tracking" in models:
        axes[0].lines[-1].set_linestyle(":")
    axes[1].plot(
        cutoffs, of(models[0], "r2_limit"), "--", color=COLOURS["other"], label="limit of a linear model"
    )
    axes[0].set(xlabel="Cutoff of the low-pass (Hz)", ylabel=f"RMS of the load ({unit})", ylim=(0, None))
    axes[1].set(xlabel="Cutoff of the low-pass (Hz)", ylabel="$R^2$ (-)")
    figure.legend(loc="outside lower center", ncols=3, fontsize=7.8)
    return figure


@in_style
def plot_ripple(result: Result) -> Figure:
    """Amplitude spectrum of the residual over cycles per metre, without and with tracking (1/m)."""
    figure, axes = new_figure(height_in=2.9)
    if "ripple/order" not in result.arrays:
        axes.text(
            0.5, 0.5, "Ripple was not analysed, or the belt travels too little.", ha="center", va="center"
        )
        axes.set_axis_off()
        return figure
    order, tracked = result.arrays["ripple/order"], result.arrays["ripple/tracked_orders"]
    limits = (0.5, 1.15 * max(tracked.max(initial=0.0), 10.0))
    for key, colour, label in (
        ("untracked", COLOURS["model"], "residual of the acceleration model"),
        ("tracked", COLOURS["recommended"], "residual with ripple tracking"),
    ):
        x, y = _envelope(order, result.arrays[f"ripple/{key}"], limits)
        axes.semilogy(x, y, color=colour, linewidth=0.8, label=label)
    low, high = axes.get_ylim()
    axes.plot(
        tracked,
        np.full(tracked.size, 2.0 * high),
        "v",
        color=COLOURS["measured"],
        markersize=4,
        label="tracked orders",
    )
    axes.set(
        xlabel="Cycles per metre of belt (1/m)",
        ylabel=f"Amplitude ({unit_symbol(result.facts['unit'])})",
        xlim=limits,
        ylim=(max(low, 1e-5 * high), 12.0 * high),
    )
    axes.legend(loc="upper right", ncols=3, fontsize=7.8)
    return figure


def _envelope(x: np.ndarray, y: np.ndarray, limits: tuple[float, float]) -> tuple[np.ndarray, np.ndarray]:
    """Largest value in each of a number of equal parts, which keeps the height of lines in a small figure."""
    inside = (x >= limits[0]) & (x <= limits[1])
    x, y = x[inside], y[inside]
    width = max(1, x.size // POINTS)
    kept = x.size // width * width
    groups = y[:kept].reshape(-1, width)
    at = groups.argmax(axis=1) + width * np.arange(groups.shape[0])
    return x[at], y[at]
