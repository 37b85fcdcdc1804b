"""Figures of the Wristalyzer experiment (thesis Figures 2-4, 3-1, 4-1, 4-2, 4-3).

K and B against the amplitude of the motion are drawn with the terms of the fit to all trials.
"""

from collections.abc import Iterator, Mapping, Sequence
from itertools import cycle
from typing import Annotated

import numpy as np
from matplotlib.figure import Figure

from tepsipe.drawing.style import COLOURS, CYCLE, PHASE_TICKS, in_style, legend_above, new_figure, plot_matrix
from tepsipe.experiments.wristalyzer.averaging import AVERAGED_FITS, AveragedFit
from tepsipe.experiments.wristalyzer.names import AS_PRINTED, PERIODS
from tepsipe.io.estimates import ESTIMATES, RECOVERIES, Estimate
from tepsipe.io.result import Result, read_result
from tepsipe.mechanics.impedance_model import admittance

LOWEST_HZ = 0.5
# lengths of the recordings that are drawn (s)
PERTURBATION_S, PREDICTION_S = 2.5, 10.0


def draw_wristalyzer(files, chosen) -> Iterator[tuple[str, Figure]]:
    """Figures of the fits of all trials and of their cross-validation (``matrix``)."""
    names = list(chosen.conditions)
    results = {name: read_result(path) for name, path in zip(names, files.fits, strict=True)}
    matrix = read_result(files.matrix).arrays["vaf"]
    best, band = chosen.best, tuple(chosen.fit_band_hz)
    vaf = float(np.diag(matrix)[names.index(best)])
    axes = ("Parameters from scale factor", "Data of scale factor")
    yield "figure_2_4", plot_perturbation(results)
    yield "figure_3_1", plot_spectral_estimate(results[best], best, band)
    yield "figure_4_1", plot_admittance_fit(results[best], best, band)
    yield "figure_4_2", plot_prediction(results[best], best, vaf)
    yield "figure_4_3", plot_matrix(matrix, names, "VAF (%)", axes)
    yield "figure_starting_values", plot_starting_values(results, chosen.start_stiffness)
    yield "figure_averaging", plot_averaging(results[best], best, band)
    swept = AVERAGED_FITS.read(files.averaging)
    yield "figure_averaged_bins", plot_averaged_bins(swept, best, dict(chosen.printed))


@in_style
def plot_perturbation(results: dict[str, Result]) -> Figure:
    """Segment of the torque perturbation with the lowest and the highest scale factor (s, N·m)."""
    figure, axes = new_figure(height_in=2.1)
    names = sorted(results, key=lambda name: results[name].arrays["torque"].std())
    shown = {names[-1]: ("--", COLOURS["model"]), names[0]: ("-", COLOURS["measured"])}
    for name, (line, colour) in shown.items():
        facts = results[name].facts
        start = facts["kept_samples"][0]
        torque = results[name].arrays["torque"]
        count = min(round(PERTURBATION_S * facts["rate_hz"]), torque.size - start)
        time = (start + np.arange(count)) / facts["rate_hz"]
        axes.plot(time, torque[start : start + count], line, color=colour, label=f"scale factor {name}")
    axes.set(xlabel="Time from the trigger (s)", ylabel=r"Torque $\tau_P$ (N·m)")
    legend_above(figure, axes, 2)
    return figure


def _gain_phase_coherence(axes, frequency, response, coherence, **keywords) -> None:
    axes[0].loglog(frequency, np.abs(response), **keywords)
    # from -3/2 pi to 1/2 pi: the joint's phase runs from 0 to -pi
    phase = (np.angle(response) - 0.5 * np.pi) % (2.0 * np.pi) - 1.5 * np.pi
    axes[1].semilogx(frequency, phase, **keywords)
    if coherence is not None:
        axes[2].semilogx(frequency, coherence, **keywords)


def _label_frequency_axes(axes, limits: tuple[float, float]) -> None:
    axes[0].set_ylabel("Gain\n(rad/(N·m))")
    axes[1].set_ylabel("Phase\n(rad)")
    axes[1].set_yticks(list(PHASE_TICKS), PHASE_TICKS.values())
    axes[1].set_ylim(-1.5 * np.pi - 0.2, 0.5 * np.pi + 0.2)
    axes[2].set(ylabel="Coherence\n(-)", ylim=(0.0, 1.05), xlabel="Frequency (Hz)", xlim=limits)
    wanted = (0.5, 1, 2, 3, 4, 5, 7, 9) if limits[1] < 15.0 else (0.5, 1, 2, 5, 10, 20, 50)
    ticks = [tick for tick in wanted if limits[0] <= tick <= limits[1]]
    axes[2].set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axes[2].minorticks_off()
    axes[0].yaxis.set_minor_formatter("")
    axes[0].figure.align_ylabels()


@in_style
def plot_spectral_estimate(result: Result, name: str, band_hz: tuple[float, float]) -> Figure:
    """Spectral estimate, phase and coherence far beyond the fitted band (Hz, rad/(N·m), rad)."""
    figure, axes = new_figure(3, 1, 3.5, sharex=True)
    choices = (
        (AS_PRINTED, COLOURS["other"], f"estimate, scale factor {name}"),
        ("tapered", COLOURS["measured"], "the same, ends tapered"),
    )
    for estimate, colour, label in choices:
        frequency = result.arrays[f"{estimate}/frequency"]
        shown = (frequency >= LOWEST_HZ) & (frequency <= 50.0)
        coherence = result.arrays[f"{estimate}/coherence"][shown]
        response = result.arrays[f"{estimate}/response"][shown]
        _gain_phase_coherence(
            axes,
            frequency[shown],
            np.where(coherence > 0.2, response, np.nan),
            coherence,
            color=colour,
            label=label,
        )
    for axis in axes:
        axis.axvspan(*band_hz, color=COLOURS["window"], zorder=0, label="fitted band")
    _label_frequency_axes(axes, (LOWEST_HZ, 50.0))
    gain = np.abs(result.arrays[f"{AS_PRINTED}/response"])
    excited = (frequency >= band_hz[0]) & (frequency <= 2.0 * band_hz[1])
    axes[0].set_ylim(0.05 * gain[excited].min(), 5.0 * gain[excited].max())
    legend_above(figure, axes[0], 3)
    return figure


@in_style
def plot_admittance_fit(result: Result, name: str, band_hz: tuple[float, float]) -> Figure:
    """Spectral estimate beside the fitted model in the fitted band (Hz, rad/(N·m), rad)."""
    figure, axes = new_figure(3, 1, 3.5, sharex=True)
    frequency = result.arrays[f"{AS_PRINTED}/frequency"]
    shown = (frequency >= band_hz[0]) & (frequency <= band_hz[1])
    _gain_phase_coherence(
        axes,
        frequency[shown],
        result.arrays[f"{AS_PRINTED}/response"][shown],
        result.arrays[f"{AS_PRINTED}/coherence"][shown],
        color=COLOURS["measured"],
        label=f"estimate, scale factor {name}",
    )
    fine = np.geomspace(*band_hz, 300)
    model = admittance(result.arrays[f"{AS_PRINTED}/parameters"], fine)
    _gain_phase_coherence(axes, fine, model, None, color=COLOURS["model"], linestyle="--", label="model")
    _label_frequency_axes(axes, band_hz)
    legend_above(figure, axes[0], 2)
    return figure


@in_style
def plot_prediction(result: Result, name: str, vaf_percent: float) -> Figure:
    """Measured and predicted angle (s, rad)."""
    figure, axes = new_figure(height_in=2.2)
    rate, (start, stop) = result.facts["rate_hz"], result.facts["kept_samples"]
    middle = (start + stop) // 2
    count = min(round(PREDICTION_S * rate), stop - middle)
    time = (middle + np.arange(count)) / rate
    shown = slice(middle, middle + count)
    axes.plot(
        time, result.arrays["angle"][shown], color=COLOURS["measured"], label=f"measured, scale factor {name}"
    )
    axes.plot(
        time,
        result.arrays["predicted_angle"][shown],
        color=COLOURS["model"],
        linestyle="--",
        label=f"predicted, VAF {vaf_percent:.0f} %",
    )
    axes.set(xlabel="Time from the trigger (s)", ylabel=r"Angle $\theta_A$ (rad)")
    legend_above(figure, axes, 2)
    return figure


@in_style
def plot_starting_values(results: dict[str, Result], start_stiffness: float) -> Figure:
    """Result of the fit for other starting values of K, and the profile of K (N·m/rad, -)."""
    figure, axes = new_figure(1, 3, 2.5)
    markers = dict(zip(results, cycle("os^vD<>P*X"), strict=False))
    for name, result in results.items():
        start = result.arrays["tried/stiffness"]
        for axis, column in ((axes[0], 2), (axes[1], 1)):
            for fit, kind, label in (
                ("modulus", "as printed", "modulus as residual"),
                ("smooth", "recommended", "complex residual"),
            ):
                axis.plot(
                    start,
                    result.arrays[f"tried/{fit}"][:, column],
                    color=COLOURS[kind],
                    marker=markers[name],
                    markersize=3.5,
                    linewidth=0.6,
                    label=label,
                )
        profile = result.arrays["profile/cost"] / result.facts["profile_limit"]
        axes[2].plot(result.arrays["profile/stiffness"], profile, label=name, linewidth=0.9)
    for axis, ylabel in ((axes[0], "Fitted $K$ (N·m/rad)"), (axes[1], "Fitted $B$ (N·m·s/rad)")):
        axis.axvline(start_stiffness, color=COLOURS["other"], linewidth=0.7, linestyle=":")
        axis.set(xlabel="Starting $K$ (N·m/rad)", ylabel=ylabel)
    handles, names = axes[0].get_legend_handles_labels()
    figure.legend(handles[:2], names[:2], loc="outside upper left", ncols=2)
    axes[2].axhline(1.0, color=COLOURS["other"], linewidth=0.7, linestyle=":")
    axes[2].set(xlabel="Held $K$ (N·m/rad)", ylabel="Cost / limit of 95 % interval", ylim=(0.85, 2.6))
    shown = [
        result.arrays["profile/stiffness"][
            result.arrays["profile/cost"] < 2.6 * result.facts["profile_limit"]
        ]
        for result in results.values()
    ]
    low, high = min(map(np.min, shown)), max(map(np.max, shown))
    axes[2].set_xlim(low, high + 0.45 * (high - low))  # room for the legend
    axes[2].legend(
        title="scale factor", fontsize=7.5, title_fontsize=7.5, loc="upper right", handlelength=1.2
    )
    return figure


@in_style
def plot_averaging(result: Result, name: str, band_hz: tuple[float, float]) -> Figure:
    """Averaging over neighbouring frequencies against averaging over periods (Hz, rad/(N·m))."""
    figure, axes = new_figure(3, 1, 3.5, sharex=True)
    choices = [(AS_PRINTED, "neighbouring frequencies", COLOURS["as printed"])]
    if f"{PERIODS}/frequency" in result.arrays:
        choices.append((PERIODS, "whole periods", COLOURS["recommended"]))
    for estimator, label, colour in choices:
        frequency = result.arrays[f"{estimator}/frequency"]
        shown = (frequency >= band_hz[0]) & (frequency <= band_hz[1])
        _gain_phase_coherence(
            axes,
            frequency[shown],
            result.arrays[f"{estimator}/response"][shown],
            result.arrays[f"{estimator}/coherence"][shown],
            color=colour,
            marker="o",
            markersize=2.0,
            linewidth=0.7,
            label=f"averaged over {label}",
        )
    _label_frequency_axes(axes, band_hz)
    legend_above(figure, axes[0], 2, title=f"scale factor {name}")
    return figure


@in_style
def plot_averaged_bins(fits: Sequence[AveragedFit], best: str, printed: Mapping) -> Figure:
    """Error, SEM of K and lowest coherence against the number of averaged frequencies.

    best: condition whose lowest coherence the thesis states.
    printed: ``error`` and ``SEM_K`` of Table 4-1 by condition, ``coherence_minimum``, and
    ``eigenfrequency_hz``; empty without a comparison.
    Returns: four panels; one colour for each condition.
    """
    figure, axes = new_figure(2, 2, 4.1, sharex=True)
    panels = (
        ("error", "Error, eq (3-6)", printed.get("error", {})),
        ("K_sem_as_printed", "SEM of $K$, eq (3-2)", printed.get("SEM_K", {})),
        ("lowest_coherence", "Lowest coherence", {best: printed.get("coherence_minimum")}),
        ("lowest_coherence_Hz", "Its frequency (Hz)", {best: printed.get("eigenfrequency_hz")}),
    )
    conditions = list(dict.fromkeys(fit.condition for fit in fits))
    bins = sorted({fit.averaged_bins for fit in fits})
    for axis, (name, label, values) in zip(axes.flat, panels, strict=True):
        for condition, colour in zip(conditions, cycle(CYCLE), strict=False):
            own = [fit for fit in fits if fit.condition == condition]
            x, y = [fit.averaged_bins for fit in own], [getattr(fit, name) for fit in own]
            axis.plot(x, y, "o-", color=colour, markersize=3.0, linewidth=0.9, label=condition)
            if values.get(condition) is not None:
                axis.axhline(values[condition], color=colour, linewidth=0.8, linestyle=":")
            if name == "lowest_coherence":
                linear = [fit.linear_coherence for fit in own]
                axis.plot(
                    x, linear, "s--", color=colour, markersize=3.0, linewidth=0.6, markerfacecolor="white"
                )
        axis.set(ylabel=label, xscale="log")
        axis.set_xticks(bins, [str(n) for n in bins])
        axis.minorticks_off()
    axes[0, 0].set_yscale("log")
    axes[0, 1].set_ylim(bottom=0.0)
    for axis in axes[1]:
        axis.set_xlabel("Frequencies averaged into one")
    legend_above(figure, axes[0, 0], len(conditions), title="scale factor")
    figure.align_ylabels()
    return figure


# groups of terms, added one to the other
LAYERS = (
    ("small", "small movements", ":", COLOURS["other"]),
    ("softening", "with softening of the rubber", "-", COLOURS["recommended"]),
    ("hardening", "with hardening", "-.", COLOURS["compensated"]),
    ("friction", "with friction", "--", COLOURS["model"]),
)


def draw_wristalyzer_pooled(files, chosen) -> Iterator[tuple[str, Figure]]:
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
