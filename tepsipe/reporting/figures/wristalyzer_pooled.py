"""Stiffness and damping of the joint in the manipulator against the amplitude of the motion."""

from collections.abc import Iterator
from typing import Annotated

import numpy as np
from matplotlib.figure import Figure

from tepsipe.experiments.wristalyzer.names import PERIODS
from tepsipe.io.estimates import ESTIMATES, RECOVERIES, Estimate
from tepsipe.io.result import read_result
from tepsipe.reporting.figures.style import COLOURS, in_style, new_figure

# groups of terms, added one to the other
LAYERS = (
    ("small", "small movements", ":", COLOURS["other"]),
    ("softening", "with softening of the rubber", "-", COLOURS["recommended"]),
    ("hardening", "with hardening", "-.", COLOURS["compensated"]),
    ("friction", "with friction", "--", COLOURS["model"]),
)


def draw(files, chosen) -> Iterator[tuple[str, Figure]]:
    """Figure of the fit to all trials (``pooled``), of those to each trial, and of the truth, if any."""
    pooled = read_result(files.pooled)
    names = list(pooled.facts["conditions"])
    rows = {
        (row.condition, row.quantity): row
        for row in ESTIMATES.read(*files.estimates)
        if row.estimator == PERIODS
    }
    fitted = {q: np.array([_with_interval(rows[name, q]) for name in names]).T for q in ("B", "K")}
    shares = {
        name.removeprefix("shares/"): values
        for name, values in pooled.arrays.items()
        if name.startswith("shares/")
    }
    truth = _truth(files.recovery[0], names) if files.recovery else None
    figure = plot_amplitudes(pooled.arrays["rms_angle"], shares, fitted, truth)
    yield "figure_wristalyzer_amplitudes", figure


def _with_interval(row: Estimate) -> tuple[float, float, float]:
    return row.value, row.ci_low, row.ci_high


def _truth(recovery: str, names: list[str]) -> dict[str, np.ndarray] | None:
    """Quantity -> truth of every trial, from the comparison with the truth; None if a trial has none."""
    true = {
        (row.condition, row.quantity): row.truth
        for row in RECOVERIES.read(recovery)
        if row.experiment == "wristalyzer" and row.estimator == PERIODS
    }
    if not all((name, "K") in true for name in names):
        return None
    return {quantity: np.array([true[name, quantity] for name in names]) for quantity in ("B", "K")}


@in_style
def plot_amplitudes(
    rms_angle: Annotated[np.ndarray, "(n,)", "rad"],
    shares: dict[str, np.ndarray],
    fitted: dict[str, np.ndarray],
    truth: dict[str, np.ndarray] | None = None,
) -> Figure:
    """K and B of each trial, and what the terms of the pooled fit add to them.

    shares: group of terms -> what it adds to I, B, K (N·m·s²/rad, N·m·s/rad, N·m/rad).
    fitted: B and K of the trials: value, low and high end of the interval (N·m·s/rad, N·m/rad).
    truth: B and K that a linear fit of the true torque finds (same units).
    """
    figure, axes = new_figure(1, 2, 2.6)
    order = np.argsort(rms_angle)
    angle = rms_angle[order]
    for axis, quantity, column, label in (
        (axes[0], "K", 2, "$K$ (N·m/rad)"),
        (axes[1], "B", 1, "$B$ (N·m·s/rad)"),
    ):
        total = np.zeros(angle.size)
        for name, text, line, colour in LAYERS:
            if name in shares:
                total = total + shares[name][order, column]
                axis.plot(angle, total, line, color=colour, label=text)
        value, low, high = fitted[quantity][:, order]
        axis.errorbar(
            angle,
            value,
            yerr=np.maximum(0.0, [value - low, high - value]),
            fmt="o",
            markersize=3.5,
            capsize=2.0,
            linewidth=0.8,
            color=COLOURS["measured"],
            label="linear fit to one trial",
        )
        if truth is not None:
            axis.plot(angle, truth[quantity][order], "x", color="#cc79a7", label="linear fit, true torque")
        axis.set(xlabel="RMS angle (rad)", ylabel=label)
        axis.margins(y=0.12)
    handles, names = axes[0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside upper center", ncols=3, fontsize=7.5)
    return figure
