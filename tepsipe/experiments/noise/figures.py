"""Figures of the noise study (thesis Figures 2-12 and 4-12)."""

from collections.abc import Iterator

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tepsipe.drawing.names import short_name, words
from tepsipe.drawing.style import COLOURS, Drawing, in_style, new_figure
from tepsipe.experiments.noise.rows import NOISE_ROWS, NoiseRow
from tepsipe.mechanics.impedance_model import PARAMETERS, UNITS
from tepsipe.quantities import unit_symbol

TARGETS = {"tau": r"noise on $\tau$", "theta": r"noise on $\theta$", "both": "noise on both"}
PROCESSINGS = {
    "as-printed": ("#d55e00", "o"),
    "as-tabulated": ("#e69f00", "s"),
    "recommended-regression": ("#7fb2d9", "^"),
    "recommended": ("#0072b2", "D"),
}


def draw_noise(files, chosen) -> Iterator[tuple[str, Figure | Drawing]]:
    """Figures of the rows of all trials of the noise study."""
    rows, joint = NOISE_ROWS.read(*files.noise), chosen.joint
    stiffness = joint["stiffness_Nm_per_rad"]
    others = (joint["inertia_Nms2_per_rad"], joint["damping_Nms_per_rad"])
    level, conditions = float(chosen.table_snr_db), list(chosen.conditions)
    yield "figure_2_12", Drawing(files.drawings[0], chosen.protocol)
    yield "figure_4_12", plot_estimates(rows, conditions, level, (*others, stiffness[-1]))
    yield "figure_noise", plot_usable(rows, (*others, stiffness[0]))


@in_style
def plot_estimates(
    rows: list[NoiseRow], conditions: list[str], snr_db: float, truth: tuple[float, float, float]
) -> Figure:
    """Mean and spread of I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad) over the draws at one SNR (dB)."""
    figure, axes = new_figure(3, 3, 4.0, sharex=True, sharey="row")
    x = np.arange(len(conditions))
    shown = [name for name in PROCESSINGS if any(row.estimator == name for row in rows)]
    for column, (target, title) in enumerate(TARGETS.items()):
        axes[0, column].set_title(title)
        for k, quantity in enumerate(PARAMETERS):
            axis = axes[k, column]
            line = {"color": COLOURS["measured"], "linewidth": 1.0, "zorder": 4, "label": "true"}
            axis.axhline(truth[k], **line)
            own = {
                (row.estimator, row.condition): row
                for row in rows
                if (row.noise_on, row.snr_db, row.quantity) == (target, snr_db, quantity)
                and row.stiffness_Nm_per_rad == truth[2]
            }
            some = next(iter(own.values()))
            axis.axhline(
                some.apparent,
                color=COLOURS["as printed"],
                linewidth=0.8,
                linestyle=":",
                label="apparent, printed equation without noise",
            )
            for shift, name in zip(np.linspace(-0.24, 0.24, len(shown)), shown, strict=True):
                colour, mark = PROCESSINGS[name]
                cells = [own[name, condition] for condition in conditions]
                axis.errorbar(
                    x + shift,
                    [cell.mean for cell in cells],
                    yerr=[cell.sd for cell in cells],
                    fmt=mark,
                    markersize=3.6,
                    markerfacecolor="white",
                    capsize=1.6,
                    linewidth=0.8,
                    color=colour,
                    label=words(name),
                )
            if column == 0:
                axis.set_ylabel(f"${quantity}$ ({unit_symbol(UNITS[quantity])})")
            axis.margins(y=0.12)
    for axis in axes[2]:
        axis.set_xticks(x, [short_name(name) for name in conditions])
    _explain(axes[2, 2], truth[2], some.apparent, [own[shown[0], name] for name in conditions])
    handles, names = axes[0, 0].get_legend_handles_labels()
    figure.legend(handles, names, loc="outside lower center", ncols=3, fontsize=7.8)
    figure.align_ylabels()
    return figure


def _explain(axis: Axes, true: float, apparent: float, cells: list[NoiseRow]) -> None:
    """The annotated panel: what lines, marks and bars are (N·m/rad)."""
    low, high = min(apparent, true), max(apparent, true)
    span = (high - low) or 1.0
    for text, at, y in (
        ("simulated joint", true, high - 0.25 * span),
        ("printed equation, no noise", apparent, low + 0.35 * span),
    ):
        axis.annotate(
            text, (0.5, at), (0.3, y), fontsize=7.5, va="center", arrowprops={"arrowstyle": "-", "lw": 0.5}
        )


def _usable_from(axis: Axes, rows: list[NoiseRow], truth: tuple[float, float, float]) -> None:
    """The annotated panel: from which SNR (dB) on the recommended K is within 10 % at all amplitudes."""
    errors: dict[float, float] = {}
    for row in rows:
        wanted = (row.noise_on, row.quantity, row.estimator, row.stiffness_Nm_per_rad)
        if wanted == ("theta", "K", "recommended", truth[2]):
            error = 100.0 * float(np.hypot(row.mean - truth[2], row.sd)) / truth[2]
            errors[row.snr_db] = max(error, errors.get(row.snr_db, 0.0))
    usable = [level for level in errors if all(errors[x] <= 10.0 for x in errors if x >= level)]
    if usable:
        level = min(usable)
        axis.annotate(
            f"{words('recommended')}: within 10 %\nfrom {level:g} dB on",
            (level, errors[level]),
            (0.2, 0.88),
            textcoords="axes fraction",
            fontsize=7.5,
            va="center",
            arrowprops={"arrowstyle": "-", "lw": 0.5},
        )


@in_style
def plot_usable(rows: list[NoiseRow], truth: tuple[float, float, float]) -> Figure:
    """Root mean square error of I, B, K over the draws, relative to the truth, against the SNR (%, dB)."""
    figure, axes = new_figure(3, 3, 3.8, sharex=True, sharey=True)
    shown = [name for name in PROCESSINGS if any(row.estimator == name for row in rows)]
    for column, (target, title) in enumerate(TARGETS.items()):
        axes[0, column].set_title(title)
        for k, quantity in enumerate(PARAMETERS):
            axis = axes[k, column]
            axis.axhspan(1e-3, 10.0, color="#e7f3ea", zorder=0)
            for name in shown:
                chosen = (target, quantity, name, truth[2])
                levels, low, middle, high = _errors_by_level(rows, chosen, truth[k])
                colour, mark = PROCESSINGS[name]
                axis.fill_between(levels, low, high, color=colour, alpha=0.15, linewidth=0.0)
                axis.semilogy(levels, middle, color=colour, marker=mark, markersize=2.6, label=words(name))
            axis.set_ylim(3e-2, 1e4)
            if column == 0:
                axis.set_ylabel(f"RMS error\nof ${quantity}$ (%)")
    _usable_from(axes[2, 1], rows, truth)
    for axis in axes[2]:
        axis.set_xlabel("SNR (dB)")
    handles, names = axes[0, 0].get_legend_handles_labels()
    handles.append(axes[0, 0].fill_between([], [], [], color="#e7f3ea"))
    figure.legend(handles, [*names, "within 10 %"], loc="outside lower center", ncols=5, fontsize=7.8)
    return figure


def _errors_by_level(
    rows: list[NoiseRow], chosen: tuple[str, str, str, float], truth: float
) -> tuple[list[float], list[float], list[float], list[float]]:
    """SNR (dB), and least, median and largest error over the trials (%).

    ``chosen`` names the noisy signal, the quantity, the estimator and the stiffness (N·m/rad).
    """
    errors: dict[float, list[float]] = {}
    for row in rows:
        if (row.noise_on, row.quantity, row.estimator, row.stiffness_Nm_per_rad) == chosen:
            error = 100.0 * np.hypot(row.mean - truth, row.sd) / truth
            errors.setdefault(row.snr_db, []).append(error)
    levels = sorted(errors)
    low, middle, high = ([float(f(errors[level])) for level in levels] for f in (np.min, np.median, np.max))
    return levels, low, middle, high
