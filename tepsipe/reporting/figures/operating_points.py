"""Figure of the impedance against the operating point: mean torque and angle of several trials."""

from collections.abc import Iterator
from itertools import cycle

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from tepsipe.reporting.figures.names import unit_symbol
from tepsipe.reporting.figures.style import CYCLE, in_style, new_figure
from tepsipe.reporting.operating_points import LITERATURE_SLOPE, STIFFNESS

SHOWN = {STIFFNESS: "Stiffness $K$", "B": "Damping $B$", "reflex_gain": "Reflex gain"}
BEYOND = 0.08
# narrowest axis of angles (rad) and of torques (N·m)
NARROWEST = (0.05, 2.0)


def draw(files, chosen) -> Iterator[tuple[str, Figure]]:
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
        sign * x,
        low,
        high,
        color=colour,
        alpha=0.12,
        linewidth=0.0,
        label="slopes of the literature",
    )


def _once(axis) -> tuple[list, list]:
    """Handles and labels of a legend, each label once."""
    found = dict(zip(*reversed(axis.get_legend_handles_labels()), strict=True))
    return list(found.values()), list(found)
