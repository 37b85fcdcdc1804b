"""Figures of the position-controlled manipulator."""

from itertools import cycle

import numpy as np
from matplotlib.figure import Figure

from tepsipe.io.result import Result
from tepsipe.reporting.figures.style import COLOURS, CYCLE, in_style, new_figure

BAND_HZ = (0.5, 40.0)
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


@in_style
def plot_impedance(results: dict[str, Result]) -> Figure:
    """Spectral estimate of the impedance and fitted model, with coherence (Hz, N·m/rad)."""
    figure, axes = new_figure(3, 1, 3.7, sharex=True, height_ratios=[1.7, 1.1, 0.8])
    for colour, (name, result) in zip(cycle(CYCLE), results.items(), strict=False):
        frequency = result.arrays["frequency"]
        shown = (frequency >= BAND_HZ[0]) & (frequency <= BAND_HZ[1])
        f = frequency[shown]
        for key, line, label in (
            ("impedance", "-", f"{name}, estimate"),
            ("impedance_model", "--", f"{name}, $Is^2+Bs+K$"),
        ):
            response = result.arrays[key][shown]
            axes[0].loglog(f, np.abs(response), line, color=colour, label=label)
            axes[1].semilogx(f, np.degrees(np.unwrap(np.angle(response))), line, color=colour)
        axes[2].semilogx(f, result.arrays["coherence"][shown], color=colour, label=name)
    axes[0].set_ylabel("Impedance (N·m/rad)")
    axes[1].set_ylabel("Phase (degrees)")
    axes[2].set(ylabel="Coherence (-)", ylim=(0.0, 1.05), xlabel="Frequency (Hz)")
    axes[2].set_xticks([0.5, 1, 2, 5, 10, 20, 40], ["0.5", "1", "2", "5", "10", "20", "40"])
    axes[2].minorticks_off()
    axes[0].legend(loc="upper left", ncols=2)
    axes[0].margins(y=0.15)
    figure.align_ylabels()
    return figure


@in_style
def plot_held_out(results: dict[str, Result]) -> Figure:
    """Torque at the start of the held-out part, measured and predicted by both models (s, N·m)."""
    figure, axes = new_figure(len(results), 1, 0.7 + 2.3 * len(results), squeeze=False)
    for axis, (name, result) in zip(axes[:, 0], results.items(), strict=True):
        time = result.arrays["time"]
        start = result.facts["held_out_from_s"]
        shown = (time >= start) & (time <= start + 4.0)

        def draw(key: str, colour: str, label: str, *, axis=axis, time=time, shown=shown, result=result):
            axis.plot(time[shown], result.arrays[key][shown], color=COLOURS[colour], label=label)

        alone, both = (facts["vaf_held_out_percent"] for facts in (result.facts, result.facts["reflex"]))
        draw("torque", "measured", "measured")
        draw("predicted_torque", "model", f"I, B, K: held-out VAF {alone:.1f} %")
        draw("reflex/predicted_torque", "recommended", f"parallel cascade: {both:.1f} %")
        if result.facts["reflex"]["direction"]:
            draw("reflex/reflex_torque", "compensated", "reflex torque")
        axis.set(ylabel="Torque (N·m)", title=name)
        axis.margins(x=0.0, y=0.05)
        low, high = axis.get_ylim()
        axis.set_ylim(low, high + 0.3 * (high - low))
        axis.legend(loc="upper left", ncols=4, columnspacing=1.2, handlelength=1.4)
    axes[-1, 0].set_xlabel("Time (s)")
    return figure


@in_style
def plot_responses(results: dict[str, Result]) -> Figure:
    """Impulse responses of both pathways, and cross-validated VAF against the delay (s, N·m/rad, %)."""
    figure, axes = new_figure(1, 3, 2.9, width_ratios=[1.0, 1.35, 0.8])
    for colour, (name, result) in zip(cycle(CYCLE), results.items(), strict=False):
        found = {key: result.arrays.get(f"reflex/{key}") for key in RESPONSES}
        axes[0].plot(1e3 * found["intrinsic_lag"], 1e-3 * found["intrinsic_response"], color=colour)
        axes[1].plot([], [], color=colour, label=name)
        if not result.facts["reflex"]["direction"]:
            continue
        time = 1e3 * found["time"]
        axes[1].plot(time, found["response"], color=colour)
        axes[1].fill_between(
            time, found["response_low"], found["response_high"], color=colour, alpha=0.15, linewidth=0.0
        )
        axes[1].plot(time, found["muscle_response"], "--", color=colour, linewidth=0.9)
        best = found["delay_vaf"].max()
        chosen = np.argmin(np.abs(found["delay"] - result.facts["reflex"]["delay_s"]))
        axes[2].plot(1e3 * found["delay"], found["delay_vaf"] - best, ".-", color=colour, markersize=3.5)
        axes[2].plot(
            1e3 * found["delay"][chosen],
            found["delay_vaf"][chosen] - best,
            "o",
            color=colour,
            fillstyle="none",
        )
    axes[0].set(xlabel="Lag (ms)", ylabel="$h/T$ (1000 N·m/rad/s)", title="Intrinsic response")
    axes[1].set(xlabel="Time after the stretch (ms)", ylabel="$g$ (N·m/rad)", title="Reflex response")
    axes[1].set_xlim(left=0.0)
    axes[1].plot([], [], "--", color=COLOURS["measured"], linewidth=0.9, label="muscle model")
    axes[1].legend(loc="upper right")
    axes[2].set(xlabel="Delay (ms)", ylabel="VAF below its maximum (%)", title="Selection of the delay")
    return figure
