"""Figures of the position-controlled manipulator.

Its trials; the impedance against the operating point, which is the mean torque and angle of several trials;
and impedance that changes within trials.
"""

from collections.abc import Iterator
from itertools import cycle

import matplotlib
import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from tepsipe.drawing.style import COLOURS, CYCLE, PHASE_TICKS, in_style, new_figure
from tepsipe.experiments.position_manipulator.diagnostics import SHOWN_TRIALS
from tepsipe.experiments.position_manipulator.operating_points import LITERATURE_SLOPE, STIFFNESS
from tepsipe.experiments.position_manipulator.time_varying import VARYING_ROWS, VaryingRow
from tepsipe.io.result import Result, read_result
from tepsipe.quantities import unit_symbol

# group of the diagnostics in a result
OWN = "diagnostics/"
# number of trials in a figure with small panels, and in one with a row for each
DRAWN, DRAWN_ROWS = 6, 4
# length of the torque that is shown (s), and every how many samples of a whole record
SHOWN_S = 3.0
THINNED = 5
# the slow part of the residual is its mean over so long (s)
SLOW_S = 1.0
BAND = {"color": "0.8", "linewidth": 0.0}
RESPONSES = (
    "intrinsic_lag",
    "intrinsic_response",
    "time",
    "response",
    "response_low",
    "response_high",
    "muscle_response",
    "delay",
    "delay_vaf",
)


def draw_position_manipulator(files, chosen) -> Iterator[tuple[str, Figure]]:
    """Figures of the fits of all trials."""
    results = {name: read_result(path) for name, path in zip(chosen.conditions, files.fits, strict=True)}
    yield "figure_position_manipulator_impedance", plot_impedance(results)
    yield "figure_position_manipulator_prediction", plot_held_out(results)
    yield "figure_position_manipulator_responses", plot_responses(results)
    yield "figure_position_manipulator_stationarity", plot_stationarity(results)
    yield "figure_position_manipulator_residual", plot_residual(results)


@in_style
def plot_impedance(results: dict[str, Result]) -> Figure:
    """Impedance with confidence bands, that of the models, and coherence (Hz, N·m/rad), by trial."""
    names, columns, heights = list(results)[:DRAWN], min(3, len(results)), (1.6, 1.1, 0.8)
    rows = -(-len(names) // columns)
    figure, axes = new_figure(
        3 * rows, columns, 0.5 + 3.6 * rows, sharex=True, squeeze=False, height_ratios=heights * rows
    )
    for place in range(rows * columns):
        block, column = divmod(place, columns)
        own = axes[3 * block : 3 * block + 3, column]
        if place < len(names):
            _draw_impedance(own, results[names[place]], names[place])
        else:
            for axis in own:
                axis.set_visible(False)
    for block in range(rows):
        for axis, label in zip(
            axes[3 * block :, 0], ("Gain (N·m/rad)", "Phase (rad)", "Coherence (–)"), strict=False
        ):
            axis.set_ylabel(label)
    for axis in axes[-1]:
        axis.set_xlabel("Frequency (Hz)")
    axes[0, 0].legend(loc="upper left", handlelength=1.6)
    figure.align_ylabels()
    return figure


def _draw_impedance(axes, result: Result, name: str) -> None:
    """Gain, phase and coherence of one trial."""
    found = {key.removeprefix(OWN): values for key, values in result.arrays.items() if key.startswith(OWN)}
    f, response, factor = found["frequency"], found["impedance"], np.minimum(found["gain_factor"], 1e3)
    gain, phase, half = np.abs(response), _phase(response), found["phase_half_width"]
    axes[0].fill_between(f, gain / factor, gain * factor, **BAND)
    axes[0].loglog(f, gain, color=COLOURS["measured"], label="measured, 95 % band")
    axes[1].fill_between(f, phase - np.radians(half), phase + np.radians(half), **BAND)
    axes[1].semilogx(f, phase, color=COLOURS["measured"])
    models = (
        (found["model_frequency"], found["model_impedance"], "recommended", "-", "parallel cascade"),
        (result.arrays["frequency"], result.arrays["impedance_model"], "model", "--", "I, B, K only"),
    )
    for at, modelled, colour, line, label in models:
        shown = (at >= f[0]) & (at <= found["model_frequency"][-1])
        look = {"color": COLOURS[colour], "linestyle": line}
        axes[0].loglog(at[shown], np.abs(modelled[shown]), label=label, **look)
        axes[1].semilogx(at[shown], _phase(modelled[shown]), **look)
    axes[2].semilogx(f, found["coherence"], color=COLOURS["measured"])
    axes[2].semilogx(f, found["coherence_level"], ":", color=COLOURS["model"], label="95 % level")
    low = found["coherence"] <= found["coherence_level"]
    for axis in axes:
        axis.fill_between(
            f, 0.0, 1.0, where=low, transform=axis.get_xaxis_transform(), color="0.92", linewidth=0.0
        )
    axes[0].set_ylim(0.6 * gain.min(), 1.5 * gain.max() * (gain.max() / gain.min()) ** 0.35)
    axes[0].set_title(name)
    axes[1].set_ylim(-0.5 * np.pi, 1.25 * np.pi)
    ticks = {at: text for at, text in PHASE_TICKS.items() if at > -0.6 * np.pi}
    axes[1].set_yticks(list(ticks), ticks.values())
    axes[2].set(ylim=(0.0, 1.05), xlim=(f[0], f[-1]))
    ticks = [x for x in (0.1, 0.2, 0.5, 1, 2, 5, 10, 20, 50, 100) if f[0] <= x <= f[-1]]
    axes[2].set_xticks(ticks, [f"{x:g}" for x in ticks])
    axes[2].minorticks_off()
    axes[2].legend(loc="lower right")


def _phase(response: np.ndarray) -> np.ndarray:
    """Phase from -pi/2 to 3/2 pi (rad): the phase of a joint lies between 0 and pi."""
    return (np.angle(response) + 0.5 * np.pi) % (2.0 * np.pi) - 0.5 * np.pi


@in_style
def plot_held_out(results: dict[str, Result]) -> Figure:
    """Start of the held-out part: torque measured and predicted, and both pathways (s, N·m), by trial."""
    names = list(results)[:SHOWN_TRIALS]
    height = min(2.9 * len(names), 7.6)
    figure, axes = new_figure(
        2 * len(names), 1, 0.6 + height, squeeze=False, height_ratios=(1.5, 1.2) * len(names)
    )
    for k, name in enumerate(names):
        result = results[name]
        _draw_held_out(*axes[2 * k : 2 * k + 2, 0], result)
        axes[2 * k, 0].set_title(name)
    axes[-1, 0].set_xlabel("Time (s)")
    figure.align_ylabels()
    return figure


def _draw_held_out(above, below, result: Result) -> None:
    arrays, start = result.arrays, result.facts["held_out_from_s"]
    time = arrays["time"]
    shown = (time >= start) & (time <= start + SHOWN_S)
    alone, both = (facts["vaf_held_out_percent"] for facts in (result.facts, result.facts["reflex"]))
    predicted, reflex = (arrays[f"reflex/{key}"] for key in ("predicted_torque", "reflex_torque"))
    intrinsic = predicted - reflex
    curves = (
        (above, arrays["torque"], "measured", "-", "measured"),
        (above, arrays["predicted_torque"], "model", "--", f"I, B, K only, VAF {alone:.1f} %"),
        (above, predicted, "recommended", "-", f"parallel cascade, VAF {both:.1f} %"),
        (below, intrinsic - intrinsic.mean(), "command", "-", "intrinsic (mean removed)"),
        (below, reflex, "compensated", "-", "reflex"),
        (below, arrays["torque"] - predicted, "I", "-", "residual"),
    )
    for axis, values, colour, line, label in curves:
        if label != "reflex" or result.facts["reflex"]["direction"]:
            axis.plot(time[shown], values[shown], line, color=COLOURS[colour], label=label)
    for axis in (above, below):
        axis.set_ylabel("Torque (N·m)")
        axis.margins(x=0.0, y=0.05)
        low, high = axis.get_ylim()
        axis.set_ylim(low, high + 0.28 * (high - low))
        axis.legend(loc="upper left", ncols=3, columnspacing=1.2, handlelength=1.6)
    above.tick_params(labelbottom=False)


@in_style
def plot_stationarity(results: dict[str, Result]) -> Figure:
    """Torque over the whole record, and intrinsic stiffness of its thirds (s, N·m, N·m/rad), by trial."""
    names = list(results)[:DRAWN_ROWS]
    figure, axes = new_figure(
        len(names), 2, 0.5 + 1.65 * len(names), squeeze=False, width_ratios=(2.6, 1.0), sharex="col"
    )
    for (left, right), name in zip(axes, names, strict=True):
        _draw_record(left, results[name])
        left.set_title(name)
        arrays = results[name].arrays
        stiffness, half = arrays[f"{OWN}part_stiffness"], arrays[f"{OWN}part_stiffness_half_width"]
        right.errorbar([1, 2, 3], stiffness, half, fmt="o", color="#0072b2", markersize=4, capsize=3)
        right.set(ylabel="$K$ (N·m/rad)", xlim=(0.5, 3.5), xticks=[1, 2, 3])
        right.set_ylim(
            min(0.0, 1.15 * float((stiffness - half).min())), 1.15 * float((stiffness + half).max())
        )
    axes[0, 0].legend(loc="upper right", ncols=3, columnspacing=1.2, handlelength=1.4)
    axes[-1, 0].set_xlabel("Time (s)")
    axes[-1, 1].set_xlabel("Third of the record")
    figure.align_ylabels()
    return figure


def _draw_record(axis, result: Result) -> None:
    """Torque of a record with its level by thirds, and the slow part of what the model does not predict."""
    arrays = result.arrays
    time, torque, predicted = (arrays[key] for key in ("time", "torque", "reflex/predicted_torque"))
    axis.plot(time[::THINNED], torque[::THINNED], color="0.75", linewidth=0.5, label="torque")
    size = max(1, round(SLOW_S / float(time[1] - time[0])))
    slow = np.convolve(torque - predicted, np.full(size, 1.0 / size), "valid") + torque.mean()
    axis.plot(
        time[size // 2 :][: slow.size][::THINNED],
        slow[::THINNED],
        color=COLOURS["compensated"],
        linewidth=0.9,
        label="slow part of the residual",
    )
    level, half = (arrays[f"{OWN}part_level{part}"] for part in ("", "_half_width"))
    for k, ends in enumerate(arrays[f"{OWN}part_ends"]):
        axis.fill_between(
            ends, level[k] - half[k], level[k] + half[k], color="#0072b2", alpha=0.4, linewidth=0.0
        )
        axis.plot(ends, [level[k]] * 2, color="#0072b2", linewidth=1.2, label="level" if k == 0 else None)
    axis.axvline(result.facts["held_out_from_s"], color=COLOURS["model"], linewidth=0.9, linestyle="--")
    axis.set_ylabel("Torque (N·m)")
    axis.margins(x=0.0)
    low, high = axis.get_ylim()
    axis.set_ylim(low, high + 0.25 * (high - low))


@in_style
def plot_residual(results: dict[str, Result]) -> Figure:
    """Power spectra of torque and residual, and cumulative power of the residual (Hz), held-out parts."""
    figure, (left, right) = new_figure(1, 2, 2.9, width_ratios=(1.2, 1.0))
    for colour, (name, result) in zip(cycle(CYCLE), list(results.items())[:DRAWN], strict=False):
        found = {key.removeprefix(OWN): x for key, x in result.arrays.items() if key.startswith(OWN)}
        facts = result.facts["diagnostics"]
        shown = found["psd_frequency"] <= 1.25 * facts["recording"]["cutoff_hz"]
        at = found["psd_frequency"][shown]
        left.loglog(at[1:], found["psd_torque"][shown][1:], color=colour, linewidth=0.8, alpha=0.55)
        left.loglog(at[1:], found["psd_residual"][shown][1:], color=colour, label=name, linewidth=1.4)
        right.plot(found["white_frequency"], found["white_cumulative"], color=colour)
    at = found["white_frequency"]
    straight, limit = np.linspace(0.0, 1.0, at.size), facts["residual"]["white_limit"]
    right.fill_between(at, straight - limit, straight + limit, color="0.85", label="white noise, 95 %")
    left.set(xlabel="Frequency (Hz)", ylabel="Power ((N·m)²/Hz)", title="Torque (thin) and residual (thick)")
    right.set(xlabel="Frequency (Hz)", ylabel="Fraction (–)", title="Cumulative power of the residual")
    right.set(xlim=(0.0, at[-1]), ylim=(0.0, 1.02))
    left.legend(loc="lower left")
    right.legend(loc="lower right")
    return figure


@in_style
def plot_responses(results: dict[str, Result]) -> Figure:
    """Intrinsic and reflex pathway, and cross-validated VAF against the delay (rad, s, N·m/rad, %).

    Of the intrinsic pathway the stiffness against the size of a movement, if a trial has short-range
    stiffness, else the impulse response.
    """
    facts = [result.facts["reflex"] for result in results.values()]
    short = any(own["short_range"] for own in facts)
    if any(own["direction"] for own in facts):
        figure, axes = new_figure(1, 3, 2.9, width_ratios=[1.0, 1.25, 0.8])
    else:
        figure, axis = new_figure(1, 1, 2.5)
        axes = [axis]
    longest = 0.0
    for colour, (name, result) in zip(cycle(CYCLE), list(results.items())[:DRAWN], strict=False):
        found = {key: result.arrays.get(f"reflex/{key}") for key in RESPONSES}
        facts = result.facts["reflex"]
        if short:
            _draw_stiffness(axes[0], result, colour)
        else:
            axes[0].plot(1e3 * found["intrinsic_lag"], 1e-3 * found["intrinsic_response"], color=colour)
        axes[-1 if len(axes) == 1 else 1].plot([], [], color=colour, label=name)
        if not facts["direction"]:
            continue
        longest = max(longest, facts["delay_s"] + facts["duration_s"])
        _draw_reflex(axes[1], axes[2], found, facts["delay_s"], colour)
    if short:
        axes[0].set(xlabel="Peak-to-peak angle (rad)", ylabel="$K$ (N·m/rad)", title="Intrinsic stiffness")
        axes[0].set_ylim(bottom=0.0)
    else:
        axes[0].set(xlabel="Lag (ms)", ylabel="$h/T$ (1000 N·m/rad/s)", title="Intrinsic response")
    if len(axes) == 1:
        axes[0].legend(loc="upper right")
        return figure
    axes[1].set(xlabel="Time after the stretch (ms)", ylabel="$g$ (N·m/rad)", title="Reflex response")
    axes[1].set_xlim(0.0, 1.25e3 * longest)
    axes[1].plot([], [], "--", color=COLOURS["measured"], linewidth=0.9, label="muscle model")
    axes[1].legend(loc="upper right")
    axes[2].set(xlabel="Delay (ms)", ylabel="VAF relative to its maximum (%)", title="Delay")
    return figure


def _draw_stiffness(axis, result: Result, colour: str) -> None:
    """Range of the torque of intrinsic stiffness and stop elements over the range of a slow movement."""
    radii, weights = (result.arrays[f"reflex/stop_{key}"] for key in ("radius", "stiffness"))
    about = result.facts["diagnostics"]["recording"]
    size = np.geomspace(1e-3, about["highest_angle_rad"] - about["lowest_angle_rad"], 60)
    beyond = result.facts["diagnostics"]["stiffness_Nm_per_rad"]
    reached = np.minimum(1.0, 2.0 * radii / size[:, None]) if radii.size else np.zeros((size.size, 0))
    axis.semilogx(size, beyond + reached @ weights[: radii.size], color=colour)


def _draw_reflex(axis, beside, found: dict, delay_s: float, colour: str) -> None:
    """Reflex response with its interval and the muscle model, and the VAF against the delay."""
    time = 1e3 * found["time"]
    axis.plot(time, found["response"], color=colour)
    axis.fill_between(
        time, found["response_low"], found["response_high"], color=colour, alpha=0.15, linewidth=0.0
    )
    axis.plot(time, found["muscle_response"], "--", color=colour, linewidth=0.9)
    less = found["delay_vaf"] - found["delay_vaf"].max()
    chosen = np.argmin(np.abs(found["delay"] - delay_s))
    beside.plot(1e3 * found["delay"], less, ".-", color=colour, markersize=3.5)
    beside.plot(1e3 * found["delay"][chosen], less[chosen], "o", color=colour, fillstyle="none")


SHOWN = {STIFFNESS: "Stiffness $K$", "B": "Damping $B$", "reflex_gain": "Reflex gain"}
BEYOND = 0.08
# narrowest axis of angles (rad) and of torques (N·m)
NARROWEST = (0.05, 2.0)


def draw_operating_points(files, chosen) -> Iterator[tuple[str, Figure]]:
    """Figure of the tables of operating points and of the lines through them."""
    text = {"participant": str, "condition": str}
    points, relations = (
        pd.read_csv(path, dtype=text, keep_default_na=False, na_values=[""])
        for path in (files.points, files.relations)
    )
    yield "figure_operating_points", plot_operating_points(points, relations)


@in_style
def plot_operating_points(points: pd.DataFrame, relations: pd.DataFrame) -> Figure:
    """K, B and reflex gain against mean torque (N·m) and angle (rad), with lines and the literature's slopes.

    ``points`` and ``relations`` are the tables of operating points and of lines of K against torque (units in
    their columns).
    """
    shown = [q for q in SHOWN if (points.quantity == q).any()] or [STIFFNESS]
    figure, axes = new_figure(
        len(shown), 2, 0.8 + 1.9 * len(shown), squeeze=False, sharex="col", sharey="row"
    )
    people = list(dict.fromkeys(points.participant.fillna("")))
    for colour, person in zip(cycle(CYCLE), people, strict=False):
        own = points[points.participant.fillna("") == person]
        for row, quantity in zip(axes, shown, strict=True):
            of = own[own.quantity == quantity]
            for axis, x in zip(row, (of.torque_Nm, of.angle_rad), strict=True):
                bars = np.array(
                    [of.value - of.ci_low.fillna(of.value), of.ci_high.fillna(of.value) - of.value]
                )
                label = person or "trials"
                # an interval of a bootstrap may leave out the value itself
                axis.errorbar(
                    x, of.value, np.maximum(bars, 0.0), fmt="o", color=colour, markersize=3.5, capsize=2.0,
                    label=label,
                )  # fmt: skip
        for line in relations[relations.participant.fillna("") == person].itertuples():
            _line(axes[0, 0], line, own[own.quantity == STIFFNESS].torque_Nm.to_numpy(), colour)
    for row, quantity in zip(axes, shown, strict=True):
        of = points[points.quantity == quantity]
        unit = unit_symbol(of.unit.iloc[0]) if len(of) else "-"
        row[0].set_ylabel(f"{SHOWN[quantity]} ({unit})")
    for axis, least in zip(axes[0], NARROWEST[::-1], strict=True):
        low, high = axis.get_xlim()
        more = max(0.0, 0.5 * (least - (high - low)))
        axis.set_xlim(low - more, high + more)
    axes[-1, 0].set_xlabel("Mean torque (N·m)")
    axes[-1, 1].set_xlabel("Mean angle (rad)")
    if len(people) > 1 or len(relations):
        axes[0, 0].legend(*_once(axes[0, 0]), loc="best")
    figure.align_ylabels()
    return figure


def _line(axis, line, torque: np.ndarray, colour: str) -> None:
    """Line of one person and direction, and slopes of the literature from its value at rest (N·m/rad)."""
    sign = 1.0 if line.torque == "positive" else -1.0
    own = np.abs(torque[sign * torque >= 0.0])
    x = np.array([0.0, (1.0 + BEYOND) * own.max()])
    axis.plot(sign * x, line.at_rest_Nm_per_rad + line.slope_per_rad * x, "--", color=colour, linewidth=0.9)
    low, high = (line.at_rest_Nm_per_rad + slope * x for slope in LITERATURE_SLOPE)
    axis.fill_between(
        sign * x, low, high, color=colour, alpha=0.12, linewidth=0.0, label="slopes of the literature"
    )


def _once(axis) -> tuple[list, list]:
    """Handles and labels of a legend, each label once."""
    found = dict(zip(*reversed(axis.get_legend_handles_labels()), strict=True))
    return list(found.values()), list(found)


PANELS = {
    "K": "$K$ (N·m/rad)",
    "B": "$B$ (N·m·s/rad)",
    "reflex_gain_ratio": "Reflex gain\n(rel. to trial)",
    "torque": "Mean torque\n(N·m)",
}
AXES = {"time": "Time (s)", "time after the trigger": "Time after the trigger (s)", "schedule": "Schedule"}
# more trials are drawn without a legend
IN_LEGEND = 18


def draw_time_varying(files, chosen) -> Iterator[tuple[str, Figure]]:
    """Figure of the table of impedance within trials."""
    yield "figure_time_varying", plot_time_varying(VARYING_ROWS.read(files.table))


@in_style
def plot_time_varying(rows: list[VaryingRow]) -> Figure:
    """K, B, reflex gain and mean torque with intervals, one column per kind of axis (units in the rows)."""
    kinds = [kind for kind in AXES if any(row.over == kind for row in rows)]
    panels = [p for p in PANELS if p == "torque" or any(row.quantity == p for row in rows)]
    if not kinds:
        figure, axis = new_figure(1, 1, 1.2)
        axis.axis("off")
        axis.text(0.5, 0.5, "all trials are too short for windows", ha="center", va="center")
        return figure
    figure, axes = new_figure(
        len(panels), len(kinds), 0.7 + 1.35 * len(panels), squeeze=False, sharex="col", sharey="row"
    )
    colours = _colours(list(dict.fromkeys(row.condition for row in rows)))
    for column, kind in zip(axes.T, kinds, strict=True):
        for condition, colour in colours.items():
            own = [row for row in rows if row.over == kind and row.condition == condition]
            for axis, panel in zip(column, panels, strict=True):
                if own:
                    _draw(axis, own, panel, colour)
        column[-1].set_xlabel(AXES[kind])
    if len(colours) <= IN_LEGEND:
        for condition, colour in colours.items():
            axes[0, 0].plot([], [], ".-", color=colour, label=condition)
        figure.legend(loc="outside upper center", ncols=6, columnspacing=1.2, handlelength=1.4)
    for axis, panel in zip(axes[:, 0], panels, strict=True):
        axis.set_ylabel(PANELS[panel])
    figure.align_ylabels()
    return figure


def _colours(conditions: list[str]) -> dict[str, object]:
    """A colour per trial: those of the report, of many trials a scale."""
    if len(conditions) <= len(CYCLE):
        return dict(zip(conditions, CYCLE, strict=False))
    return dict(
        zip(conditions, matplotlib.colormaps["turbo"](np.linspace(0.05, 0.95, len(conditions))), strict=True)
    )


def _draw(axis, rows: list[VaryingRow], panel: str, colour) -> None:
    if panel == "torque":
        rows = [row for row in rows if row.quantity == "K"]
        axis.plot([row.at for row in rows], [row.torque_Nm for row in rows], ".-", color=colour)
        return
    rows = [row for row in rows if row.quantity == panel]
    at = [row.at for row in rows]
    axis.fill_between(
        at, [r.ci_low for r in rows], [r.ci_high for r in rows], color=colour, alpha=0.15, linewidth=0.0
    )
    axis.plot(at, [row.value for row in rows], ".-", color=colour)
