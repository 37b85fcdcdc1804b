"""Time lines of the trials, counterparts of Figures 2-8, 2-11, 2-12 and 2-14 of the thesis."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from tepsipe.reporting.figures.style import COLOURS, SMALLEST_PT, in_style, new_figure

TITLES = {
    "wristalyzer": "Wristalyzer",
    "dummy": "Dummy",
    "weight": "Weight",
    "empty": "Empty belt",
    "standing": "Standing person",
}
# amplitude (m/s) whose tick is as high as its row
FULL = 0.5


@dataclass(frozen=True)
class TimeLine:
    """One trial of a protocol."""

    label: str
    """How the figure calls it."""
    duration_s: float
    """Duration of the trial."""
    onsets_s: Sequence[float] | None
    """Beginning of every perturbation (s); None if the perturbation lasts for the whole trial."""
    amplitude: float | None = None
    """Peak belt velocity (m/s), negative for pulses that begin backwards; None if unknown."""


@in_style
def draw_protocol(protocol: Mapping[str, Sequence[TimeLine]]) -> Figure:
    """The trials of every experiment, a row each, with a tick at every perturbation.

    ``protocol`` maps experiments to their trials; the height of a tick is the amplitude (m/s, full row: 0.5).
    """
    shown = [name for name in TITLES if protocol.get(name)]
    sizes = np.cumsum([len(protocol[name]) + 2 for name in shown])
    split = int(np.argmin(np.abs(sizes - 0.5 * sizes[-1]))) + 1
    columns = [column for column in (shown[:split], shown[split:]) if column]
    rows = max(sum(len(protocol[name]) + 2 for name in column) for column in columns)
    figure, axes = new_figure(1, len(columns), 0.122 * rows + 0.6, squeeze=False)
    for axis, column in zip(axes[0], columns, strict=True):
        _column(axis, [(TITLES[name], protocol[name]) for name in column], rows)
    return figure


def _column(axis: Axes, groups: list[tuple[str, Sequence[TimeLine]]], rows: int) -> None:
    y, ticks, labels = 0.0, [], []
    longest = max(line.duration_s for _, lines in groups for line in lines)
    for title, lines in groups:
        y += 1.7
        axis.text(0.0, -y + 0.2, title, fontsize=8.5, weight="bold", va="center")
        for line in lines:
            y += 1.0
            ticks.append(-y)
            labels.append(line.label)
            axis.plot([0.0, line.duration_s], [-y, -y], color="#bbbbbb", linewidth=0.6)
            if line.onsets_s is None:
                axis.fill_between([0.0, line.duration_s], -y - 0.25, -y + 0.25, color=COLOURS["recommended"])
                continue
            amplitude = FULL if line.amplitude is None else line.amplitude
            colour = COLOURS["recommended"] if amplitude >= 0.0 else COLOURS["model"]
            height = 0.45 * abs(amplitude) / FULL
            axis.vlines(np.asarray(line.onsets_s), -y - height, -y + height, color=colour, linewidth=1.0)
    axis.set_yticks(ticks, labels, fontsize=SMALLEST_PT)
    axis.tick_params(axis="y", length=0.0, pad=1.0)
    axis.set(xlabel="Time (s)", ylim=(-rows - 0.6, 0.2), xlim=(-0.01 * longest, 1.01 * longest))
    axis.grid(visible=False, axis="y")
    axis.spines["left"].set_visible(False)
