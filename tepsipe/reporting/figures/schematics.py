"""Schematics of the rigs, the free bodies and the signal chain, drawn from the configuration and the trials.

Counterparts of Figures 2-1, 2-2, 2-3, 2-5, 2-6, 2-7, 2-10, 2-13 and 3-2 of the thesis. Markers stand where a
trial has them at rest; masses and lengths are those of the configuration.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Arc, Circle, FancyArrowPatch, FancyBboxPatch, Polygon, Rectangle

from tepsipe.io.trial import Trial
from tepsipe.reporting.figures.style import COLOURS, in_style, new_figure

# beginning of a trial, before the first perturbation, over which markers are averaged (s)
REST_S = 2.0
BODY = "#d9d3c4"
LINE = "#3a3a3a"
BELT = "#8a8a8a"
# muscles of the person's electromyograms -> height of the electrode as a part of the stature, side
ELECTRODES = {
    "TA": (0.20, "front"),
    "SOL": (0.13, "back"),
    "GAS": (0.22, "back"),
    "RF": (0.40, "front"),
    "BF": (0.37, "back"),
}


@dataclass(frozen=True)
class Rig:
    """Markers of a rig at rest.

    Attributes
    ----------
    points : ndarray, shape (number of markers, 2)
        Positions along the belt and upwards (m), in the order of sampling.
    ankle : ndarray, shape (2,)
        That of the marker ``ankle``, or their mean (m).
    """

    points: np.ndarray
    ankle: np.ndarray


def rig_at_rest(trial: Trial) -> Rig:
    """Markers of a rig (m), averaged over the first 2 s of a trial."""
    positions = trial.values("marker_position")[: round(REST_S * trial.rate_hz), :, 1:]
    points = np.nanmean(positions, axis=0)
    labels = [str(label) for label in trial.axes["marker"]]
    ankle = points[labels.index("ankle")] if "ankle" in labels else points.mean(axis=0)
    return Rig(points, ankle)


def _bare(axis: Axes, title: str, xlim: tuple[float, float], ylim: tuple[float, float]) -> None:
    axis.set_title(title, fontsize=9.5)
    axis.set(xlim=xlim, ylim=ylim, aspect="equal")
    axis.grid(visible=False)
    axis.axis("off")


def _belt(axis: Axes, left: float, right: float, thickness: float) -> None:
    """The belt with its surface at height 0, and the direction of its movement."""
    axis.add_patch(Rectangle((left, -thickness), right - left, thickness, color=BELT, linewidth=0.0))
    y = -2.2 * thickness
    axis.annotate(
        "",
        (right, y),
        (left, y),
        arrowprops={"arrowstyle": "<->", "color": COLOURS["recommended"], "lw": 1.1},
    )


def _markers(axis: Axes, points: np.ndarray, away: float) -> None:
    """Markers, numbered in the order of their sampling, on the side on which there is room."""
    axis.plot(*points.T, "o", color=COLOURS["model"], markersize=3.4, zorder=5)
    middle = float(np.median(points[:, 0]))
    for k, (y, z) in enumerate(points):
        side = 1.0 if y >= middle else -1.0
        axis.text(y + side * away, z, str(k + 1), fontsize=7.5, va="center", ha="center", zorder=6)


def _draw_dummy(axis: Axes, rig: Rig, geometry: Mapping) -> None:
    height, com = float(geometry["foot_height_m"]), float(geometry["leg_com_m"])
    points = rig.points - [rig.ankle[0], 0.0]
    top = max(2.0 * com, float((points[:, 1] - height).max()))
    _belt(axis, -0.35, 0.35, 0.018)
    axis.add_patch(Rectangle((-0.06, 0.0), 0.12, 0.8 * height, facecolor=BODY, edgecolor=LINE, linewidth=0.8))
    axis.add_patch(Rectangle((-0.012, height), 0.024, top, facecolor=BODY, edgecolor=LINE, linewidth=0.8))
    axis.add_patch(Circle((0.0, height), 0.022, facecolor=LINE, edgecolor=LINE))
    _markers(axis, points, 0.045)
    axis.plot(0.0, height + com, marker="x", color=LINE, markersize=5.0, zorder=6)
    axis.annotate(
        f"leg: {geometry['leg_mass_kg']:g} kg,\n{geometry['leg_inertia_kgm2']:g} kg·m²",
        (0.0, height + com),
        (0.16, height + 1.22 * com),
        fontsize=7.5,
        arrowprops={"arrowstyle": "-", "lw": 0.5, "color": LINE},
    )
    for text, z, at in (
        (f"foot: {geometry['foot_mass_kg']:g} kg", 0.16, (0.05, 0.4 * height)),
        ("rubber joint", 0.26, (0.0, height)),
    ):
        axis.annotate(
            text, at, (0.16, z), fontsize=7.5, arrowprops={"arrowstyle": "-", "lw": 0.5, "color": LINE}
        )
    _bare(axis, "Dummy on the belt", (-0.42, 0.48), (-0.08, top + 0.12))


def _draw_weight(axis: Axes, rig: Rig, mass_kg: float) -> None:
    points = rig.points - [rig.points[:, 0].mean(), 0.0]
    top = float(points[:, 1].max())
    half = float(np.abs(points[:, 0]).max())
    _belt(axis, -0.35, 0.35, 0.018)
    axis.add_patch(Rectangle((-half, 0.0), 2.0 * half, top, facecolor=BODY, edgecolor=LINE, linewidth=0.8))
    axis.text(0.0, 0.5 * top, f"{mass_kg:g} kg", ha="center", va="center", fontsize=8.5)
    for y in np.unique(np.round(points[:, 0], 3)):
        own = [str(k + 1) for k, p in enumerate(points) if abs(p[0] - y) < 2e-3]
        axis.plot(y, top, "o", color=COLOURS["model"], markersize=3.4, zorder=5)
        axis.text(y, top + 0.02, ", ".join(own), fontsize=7.5, ha="center", va="bottom")
    _bare(axis, "Weight on the belt", (-0.42, 0.42), (-0.08, 0.62))


def _draw_person(axis: Axes, rig: Rig, stature: float) -> None:
    points = rig.points - [rig.ankle[0], 0.0]
    joints = np.array([[0.0, 0.046], [0.03, 0.285], [0.045, 0.53], [0.05, 0.82]]) * [
        stature,
        stature,
    ]  # ankle, knee, hip, shoulder: segment lengths of Winter (2009)
    _belt(axis, -0.45, 0.55, 0.03)
    axis.add_patch(
        Polygon([(-0.06, 0.0), (0.19, 0.0), (0.02, 0.09)], facecolor=BODY, edgecolor=LINE, linewidth=0.8)
    )
    axis.plot(*joints.T, color=BODY, linewidth=9.0, solid_capstyle="round", zorder=1)
    axis.plot(*joints.T, color=LINE, linewidth=0.8, marker="o", markersize=2.6, zorder=2)
    axis.add_patch(Circle((0.055 * stature, 0.93 * stature), 0.06 * stature, facecolor=BODY, edgecolor=LINE))
    _markers(axis, points, 0.075)
    for muscle, (height, side) in ELECTRODES.items():
        y = np.interp(height * stature, joints[:, 1], joints[:, 0]) + (0.055 if side == "front" else -0.055)
        axis.plot(y, height * stature, "s", color=COLOURS["recommended"], markersize=3.4, zorder=5)
        axis.annotate(
            muscle,
            (y, height * stature),
            (y - 0.16 if side == "back" else y + 0.44, height * stature),
            fontsize=7.0,
            color=COLOURS["recommended"],
            va="center",
            ha="right",
            arrowprops={"arrowstyle": "-", "lw": 0.3, "color": COLOURS["recommended"]},
        )
    _bare(axis, "Standing person", (-0.55, 0.75), (-0.15, stature + 0.05))


def _draw_manipulator(axis: Axes) -> None:
    """The dummy in the torque-controlled manipulator, from above: rod in the arm rest, foot on the handle."""
    axis.add_patch(
        FancyBboxPatch(
            (-0.55, -0.10),
            0.42,
            0.20,
            boxstyle="round,pad=0.02",
            facecolor="#eeeeee",
            edgecolor=LINE,
            linewidth=0.8,
        )
    )
    axis.text(-0.34, -0.20, "arm rest, fixed", fontsize=7.5, ha="center", va="top")
    axis.add_patch(Rectangle((-0.52, -0.012), 0.52, 0.024, facecolor=BODY, edgecolor=LINE, linewidth=0.8))
    axis.text(-0.34, 0.045, "rod (leg)", fontsize=7.5, ha="center")
    axis.add_patch(Circle((0.0, 0.0), 0.16, facecolor="#eeeeee", edgecolor=LINE, linewidth=0.8))
    axis.add_patch(
        Rectangle((-0.05, -0.06), 0.26, 0.12, angle=12.0, facecolor=BODY, edgecolor=LINE, linewidth=0.8)
    )
    axis.add_patch(Circle((0.0, 0.0), 0.024, color=LINE))
    axis.text(0.14, 0.14, "foot on the handle", fontsize=7.5, ha="left", va="bottom")
    axis.add_patch(
        Arc((0.0, 0.0), 0.62, 0.62, theta1=-55.0, theta2=-8.0, color=COLOURS["recommended"], linewidth=1.2)
    )
    axis.add_patch(
        FancyArrowPatch(
            (0.295, -0.075),
            (0.308, -0.028),
            arrowstyle="-|>",
            mutation_scale=9.0,
            color=COLOURS["recommended"],
            linewidth=0.0,
        )
    )
    axis.text(0.33, -0.14, r"$\tau(t)$, $\theta(t)$", color=COLOURS["recommended"], fontsize=9.0)
    _bare(axis, "Dummy in the Wristalyzer,\nfrom above", (-0.62, 0.58), (-0.40, 0.34))


@in_style
def draw_rigs(rigs: Mapping[str, Rig | None], geometry: Mapping, person: Mapping, mass_kg: float) -> Figure:
    """The rigs from the side, with the markers where they stand at rest.

    Parameters
    ----------
    rigs : mapping of str to Rig or None
        Experiment (wristalyzer, dummy, weight, standing) -> its markers (m); the Wristalyzer has none.
    geometry : mapping
        Section ``dummy.geometry`` of the configuration (units in the keys).
    person : mapping
        Section ``standing.person`` of the configuration (units in the keys).
    mass_kg : float
        Mass of the weight (kg).

    Returns
    -------
    Figure
        A panel for each rig.
    """
    shown = [name for name in ("wristalyzer", "dummy", "weight", "standing") if name in rigs]
    widths = {"wristalyzer": 1.5, "dummy": 0.9, "weight": 0.9, "standing": 1.15}
    figure, axes = new_figure(
        1, len(shown), 2.75, squeeze=False, gridspec_kw={"width_ratios": [widths[name] for name in shown]}
    )
    for axis, name in zip(axes[0], shown, strict=True):
        rig = rigs[name]
        if name == "wristalyzer":
            _draw_manipulator(axis)
        elif name == "dummy":
            _draw_dummy(axis, rig, geometry)
        elif name == "weight":
            _draw_weight(axis, rig, mass_kg)
        else:
            _draw_person(axis, rig, float(person["stature_m"]))
    return figure


def _arrow(axis: Axes, start: tuple, end: tuple, label: str, colour: str, at: tuple, **keywords) -> None:
    axis.annotate("", end, start, arrowprops={"arrowstyle": "-|>", "color": colour, "lw": 1.2})
    axis.text(*at, label, color=colour, fontsize=9.0, **keywords)


@in_style
def draw_free_bodies(theta: float = 0.35) -> Figure:
    """Free bodies of the dummy's leg and foot, with the leg tipped forwards by ``theta`` (rad).

    Counterpart of Figure 3-2: the forces of eqs (3-7) and (3-8).
    """
    figure, (leg, foot) = new_figure(1, 2, 2.7)
    red, blue = COLOURS["model"], COLOURS["recommended"]
    axis_of_leg = np.array([np.sin(theta), np.cos(theta)])
    com, top = 0.45 * axis_of_leg, 0.9 * axis_of_leg
    leg.plot([0.0, top[0]], [0.0, top[1]], color=BODY, linewidth=8.0, solid_capstyle="round")
    leg.plot([0.0, 0.0], [0.0, 0.95], color="#bbbbbb", linewidth=0.7, linestyle="--")
    leg.add_patch(
        Arc((0.0, 0.0), 1.3, 1.3, theta1=90.0 - np.degrees(theta), theta2=90.0, color=LINE, linewidth=0.8)
    )
    leg.text(0.08, 0.68, r"$\theta_A$", fontsize=10.0)
    leg.plot(*com, marker="x", color=LINE, markersize=6.0)
    leg.text(com[0] + 0.06, com[1] + 0.06, r"$m,\ I_{leg}$", fontsize=9.0)
    _arrow(leg, tuple(com), (com[0], com[1] - 0.26), r"$m g$", red, (com[0] + 0.03, com[1] - 0.22))
    _arrow(leg, (-0.34, 0.0), (-0.03, 0.0), r"$F_{Ay}$", blue, (-0.34, 0.04))
    _arrow(leg, (0.0, -0.34), (0.0, -0.03), r"$F_{Az}$", blue, (0.03, -0.28))
    leg.add_patch(Arc((0.0, 0.0), 0.34, 0.34, theta1=210.0, theta2=340.0, color=blue, linewidth=1.2))
    leg.annotate("", (0.165, -0.03), (0.16, -0.06), arrowprops={"arrowstyle": "-|>", "color": blue})
    leg.text(-0.28, -0.20, r"$\tau_A$", color=blue, fontsize=10.0)
    leg.annotate(
        "", tuple(com * 0.97 + [-0.07, 0.03]), (-0.07, 0.03), arrowprops={"arrowstyle": "<->", "lw": 0.7}
    )
    leg.text(com[0] / 2 - 0.13, com[1] / 2 + 0.05, r"$r$", fontsize=9.5)
    _bare(leg, "Leg", (-0.5, 0.75), (-0.42, 1.0))
    foot.add_patch(Rectangle((-0.5, 0.0), 1.0, 0.42, facecolor=BODY, edgecolor=LINE, linewidth=0.8))
    foot.add_patch(Rectangle((-0.9, -0.06), 1.8, 0.06, color=BELT))
    foot.plot(0.0, 0.55, "o", color=LINE, markersize=6.0)
    foot.plot([0.0, 0.0], [0.42, 0.55], color=LINE, linewidth=1.0)
    _arrow(foot, (0.36, 0.55), (0.04, 0.55), r"$F_{Ay}$", blue, (0.22, 0.60))
    _arrow(foot, (0.0, 0.90), (0.0, 0.60), r"$F_{Az}$", blue, (0.04, 0.80))
    foot.text(-0.30, 0.60, r"$\tau_A$", color=blue, fontsize=10.0)
    foot.add_patch(Arc((0.0, 0.55), 0.40, 0.40, theta1=100.0, theta2=240.0, color=blue, linewidth=1.2))
    foot.annotate("", (-0.02, 0.75), (-0.06, 0.745), arrowprops={"arrowstyle": "-|>", "color": blue})
    foot.plot(0.0, 0.2, marker="x", color=LINE, markersize=6.0)
    foot.text(0.05, 0.22, r"$m_f$", fontsize=9.0)
    _arrow(foot, (0.0, 0.18), (0.0, -0.02), r"$m_f g$", red, (0.04, 0.06))
    _arrow(foot, (-0.75, -0.16), (-0.35, -0.16), r"$F_y$", red, (-0.60, -0.32))
    _arrow(foot, (0.25, -0.40), (0.25, -0.08), r"$F_z$", red, (0.29, -0.34))
    foot.text(0.52, -0.30, r"$M_x$ (plate)", color=red, fontsize=9.0)
    foot.annotate("", (-0.62, 0.55), (-0.62, 0.0), arrowprops={"arrowstyle": "<->", "lw": 0.7})
    foot.text(-0.75, 0.25, r"$l_f$", fontsize=9.5)
    _bare(foot, "Foot", (-1.0, 1.05), (-0.46, 1.0))
    return figure


@in_style
def draw_signal_chain(choices: Mapping) -> Figure:
    """From the instruments' files to one trial: rates, trigger and common clock (Figure 2-5 of the thesis).

    Parameters
    ----------
    choices : mapping
        ``plate_rate_hz``, ``sampling_hz`` (of the markers within a frame, or None), ``cutoff_hz`` (all Hz),
        and ``emg``: whether the study has electromyograms.
    """
    figure, axis = new_figure(1, 1, 2.3)
    _draw_instruments(axis, choices)
    _draw_steps(axis, choices)
    axis.set(xlim=(-0.01, 1.03), ylim=(0.0, 1.0))
    axis.grid(visible=False)
    axis.axis("off")
    return figure


def _draw_instruments(axis: Axes, choices: Mapping) -> None:
    """Boxes of the instruments and their files, one above the other, with arrows to the first step."""
    sampling_hz = choices["sampling_hz"]
    in_turn = "" if sampling_hz is None else f", one after another\nat {sampling_hz:g} Hz"
    instruments = [
        ("Belt and force plate", "log: belt velocity, plate voltages,\ntrigger"),
        ("Motion capture", f"markers (C3D){in_turn}"),
    ]
    if choices["emg"]:
        instruments.append(("EMG amplifier", "electromyograms (EDF), trigger"))
    height = 1.0 / len(instruments)
    for k, (name, files) in enumerate(instruments):
        y = 1.0 - (k + 0.5) * height
        _draw_box(axis, (0.0, y - 0.32 * height), (0.26, 0.64 * height), "#f1ede2")
        axis.text(0.13, y + 0.15 * height, name, ha="center", va="center", fontsize=8.5, weight="bold")
        axis.text(0.13, y - 0.12 * height, files, ha="center", va="center", fontsize=6.6)
        _draw_arrow(axis, (0.27, y), (0.325, 0.5 + 0.25 * (y - 0.5)))


def _draw_steps(axis: Axes, choices: Mapping) -> None:
    """Boxes of the processing steps from left to right, joined by arrows."""
    steps = (
        "align by trigger;\nmarkers to\none instant;\nvoltages to forces",
        f"resample at\n{choices['plate_rate_hz']:g} Hz:\none trial (HDF5)",
        f"zero-lag\nlow-pass,\n{choices['cutoff_hz']:g} Hz",
        "pathways:\ntorque, windows,\nestimator",
    )
    width = 0.145
    for k, label in enumerate(steps):
        x = 0.33 + k * (width + 0.032)
        _draw_box(axis, (x, 0.27), (width, 0.46), "#e3edf4")
        axis.text(x + 0.5 * width, 0.5, label, ha="center", va="center", fontsize=7.4)
        if k:
            _draw_arrow(axis, (x - 0.030, 0.5), (x - 0.004, 0.5))


def _draw_box(axis: Axes, corner: tuple[float, float], size: tuple[float, float], colour: str) -> None:
    """Rounded box of a flow chart; ``corner`` is the lower left one."""
    style = {"boxstyle": "round,pad=0.004", "edgecolor": LINE, "linewidth": 0.8}
    axis.add_patch(FancyBboxPatch(corner, *size, facecolor=colour, **style))


def _draw_arrow(axis: Axes, begin: tuple[float, float], end: tuple[float, float]) -> None:
    """Arrow of a flow chart."""
    axis.annotate("", end, begin, arrowprops={"arrowstyle": "-|>", "lw": 0.9, "color": LINE})
