"""Figures of the position-controlled manipulator."""

from itertools import cycle

import numpy as np
from matplotlib.figure import Figure

from tepsipe.figures.style import COLOURS, CYCLE, new_figure
from tepsipe.result_file import Result

BAND_HZ = (0.5, 40.0)


def plot_impedance(results: dict[str, Result]) -> Figure:
    """Spectral estimate of the impedance beside the fitted model, with its coherence (Hz, Nm/rad)."""
    figure, axes = new_figure(3, 1, 4.8, sharex=True)
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
    axes[0].set_ylabel("Impedance (Nm/rad)")
    axes[1].set_ylabel("Phase (degrees)")
    axes[2].set(ylabel="Coherence (-)", ylim=(0.0, 1.05), xlabel="Frequency (Hz)")
    axes[2].set_xticks([0.5, 1, 2, 5, 10, 20, 40], ["0.5", "1", "2", "5", "10", "20", "40"])
    axes[2].minorticks_off()
    axes[0].legend(loc="upper left", ncols=2)
    axes[0].margins(y=0.15)
    figure.align_ylabels()
    return figure


def plot_held_out(results: dict[str, Result]) -> Figure:
    """Measured and predicted torque at the start of the held-out part (s, Nm)."""
    figure, axes = new_figure(len(results), 1, 0.7 + 2.0 * len(results), squeeze=False)
    for axis, (name, result) in zip(axes[:, 0], results.items(), strict=True):
        time = result.arrays["time"]
        start = result.facts["held_out_from_s"]
        shown = (time >= start) & (time <= start + 4.0)
        axis.plot(time[shown], result.arrays["torque"][shown], color=COLOURS["measured"], label="measured")
        axis.plot(
            time[shown],
            result.arrays["predicted_torque"][shown],
            color=COLOURS["model"],
            linestyle="--",
            label=f"predicted, held-out VAF {result.facts['vaf_held_out_percent']:.1f} %",
        )
        axis.set(ylabel="Torque (Nm)", title=name)
        axis.margins(y=0.25)
        axis.legend(loc="upper right", ncols=2)
    axes[-1, 0].set_xlabel("Time (s)")
    return figure
