"""Schematics of the rigs, the simulation model and the free bodies, drawn from configuration and trials.

Counterparts of Figures 2-1, 2-2, 2-3, 2-6, 2-7, 2-10, 2-13 and 3-2 of the thesis. Markers are where a trial
has them at rest; masses and lengths are those of the configuration.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated

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
    "BF": (0.37, "back"),
    "RF": (0.40, "front"),
}
# letters of the electrodes in the thesis, in the order of the muscles above
LETTERS = dict(zip(ELECTRODES, "ABCDE", strict=True))


@dataclass(frozen=True)
class Rig:
    """Markers of a rig at rest."""

    points: Annotated[np.ndarray, "(number of markers, 2)"]
    """Positions along the belt and upwards (m), in the order of sampling."""
    ankle: Annotated[np.ndarray, "(2,)", "m"]
    """That of the marker ``ankle``, or their mean."""


def rig_at_rest(trial: Trial) -> Rig:
    """Markers of a rig (m), averaged over the first 2 s of a trial."""
    positions = trial.values("marker_position")[: round(REST_S * trial.rate_hz), :, 1:]
    points = np.nanmean(positions, axis=0)
    labels = [str(label) for label in trial.axes["marker"]]
    ankle = points[labels.index("ankle")] if "ankle" in labels else points.mean(axis=0)
    return Rig(points, ankle)


def _bare(axis: Axes, title: str, xlim: tuple[float, float], ylim: tuple[float, float]) -> None:
    axis.set_title(title, fontsize=9.5)
    axis.set(xlim=xlim, ylim=ylim)
    # panels begin at the top, so that the titles of a row are at one height
    axis.set_aspect("equal", anchor="N")
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


def _markers(axis: Axes, points: np.ndarray, away: float, apart: float) -> None:
    """Markers, and their numbers in the order of sampling at least ``apart`` in a column ``away`` (m).

    Markers at one place share a label.
    """
    line = {"arrowstyle": "-", "lw": 0.4, "color": COLOURS["model"], "shrinkA": 0.0, "shrinkB": 0.0}
    axis.plot(*points.T, "o", color=COLOURS["model"], markersize=2.6, zorder=5)
    places: dict[tuple[float, float], list[str]] = {}
    for k, (y, z) in enumerate(points):
        near = [own for own in places if np.hypot(own[0] - y, own[1] - z) < 0.2 * apart]
        places.setdefault(near[0] if near else (float(y), float(z)), []).append(str(k + 1))
    lowest = -np.inf
    for y, z in sorted(places, key=lambda place: (place[1], place[0])):
        height = max(z, lowest + apart)
        lowest = height
        axis.annotate(
            ", ".join(places[y, z]),
            (y, z),
            (-away, height),
            fontsize=7.5,
            va="center",
            ha="right",
            arrowprops=line,
        )


def _draw_dummy(axis: Axes, rig: Rig, geometry: Mapping) -> None:
    height, com = float(geometry["foot_height_m"]), float(geometry["leg_com_m"])
    points = rig.points - [rig.ankle[0], 0.0]
    top = max(2.0 * com, float((points[:, 1] - height).max()))
    _belt(axis, -0.35, 0.35, 0.018)
    axis.add_patch(Rectangle((-0.06, 0.0), 0.12, 0.8 * height, facecolor=BODY, edgecolor=LINE, linewidth=0.8))
    axis.add_patch(Rectangle((-0.012, height), 0.024, top, facecolor=BODY, edgecolor=LINE, linewidth=0.8))
    axis.add_patch(Circle((0.0, height), 0.022, facecolor=LINE, edgecolor=LINE))
    _markers(axis, points, 0.12, 0.055)
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
    _markers(axis, points, 0.25, 0.105)
    lowest = -np.inf
    for muscle, (part, side) in sorted(ELECTRODES.items(), key=lambda item: item[1]):
        height = part * stature
        y = np.interp(height, joints[:, 1], joints[:, 0]) + (0.055 if side == "front" else -0.055)
        axis.plot(y, height, "s", color=COLOURS["recommended"], markersize=3.4, zorder=5)
        lowest = max(height, lowest + 0.105)
        axis.annotate(
            f"{LETTERS[muscle]} {muscle}",
            (y, height),
            (0.34, lowest),
            fontsize=7.5,
            color=COLOURS["recommended"],
            va="center",
            arrowprops={"arrowstyle": "-", "lw": 0.4, "color": COLOURS["recommended"], "shrinkA": 0.0},
        )
    _bare(axis, "Person, from the side", (-0.6, 0.8), (-0.15, stature + 0.05))


def _draw_person_from_behind(axis: Axes, stature: float) -> None:
    """Legs, trunk and head from behind, with the electrodes of the right leg; open ones are in front."""
    hip, knee, foot = 0.53 * stature, 0.285 * stature, 0.046 * stature
    axis.add_patch(Rectangle((-0.32, -0.03), 0.31, 0.03, color=BELT, linewidth=0.0))
    axis.add_patch(Rectangle((0.01, -0.03), 0.31, 0.03, color=BELT, linewidth=0.0))
    for side in (0.08, 0.24):
        axis.plot([side, side], [foot, hip], color=BODY, linewidth=8.0, solid_capstyle="round", zorder=1)
        axis.plot(
            [side] * 3, [foot, knee, hip], color=LINE, linewidth=0.8, marker="o", markersize=2.6, zorder=2
        )
        outline = [(side - 0.045, 0.0), (side + 0.045, 0.0), (side + 0.03, foot), (side - 0.03, foot)]
        axis.add_patch(Polygon(outline, facecolor=BODY, edgecolor=LINE, linewidth=0.8))
    shoulder = 0.82 * stature
    trunk = [(0.06, hip), (0.26, hip), (0.36, shoulder), (-0.04, shoulder)]
    axis.add_patch(Polygon(trunk, facecolor=BODY, edgecolor=LINE, linewidth=0.8))
    axis.add_patch(Circle((0.16, 0.93 * stature), 0.06 * stature, facecolor=BODY, edgecolor=LINE))
    for muscle, (height, side) in ELECTRODES.items():
        face, z = (COLOURS["recommended"] if side == "back" else "white"), height * stature
        axis.plot(0.24, z, "s", color=COLOURS["recommended"], markersize=3.6, markerfacecolor=face, zorder=5)
        x = 0.33 if side == "back" else 0.15
        axis.text(x, z, LETTERS[muscle], fontsize=7.5, color=COLOURS["recommended"], va="center", ha="center")
    axis.text(-0.02, -0.05, "left belt", fontsize=7.5, ha="right", va="top")
    axis.text(0.02, -0.05, "right belt", fontsize=7.5, ha="left", va="top")
    _bare(axis, "Person, from behind", (-0.45, 0.55), (-0.15, stature + 0.05))


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
    _bare(axis, "Wristalyzer, from above", (-0.62, 0.58), (-0.40, 0.34))


def _draw_drive(axis: Axes) -> None:
    """The drive of the manipulator from the side: motor, encoder and torque transducer below the handle."""
    part = {"edgecolor": LINE, "linewidth": 0.8}
    axis.add_patch(Rectangle((-0.5, 0.0), 1.0, 0.045, facecolor="#eeeeee", **part))
    axis.add_patch(Rectangle((-0.5, 0.1), 0.3, 0.05, facecolor="#eeeeee", **part))
    axis.add_patch(Rectangle((-0.5, 0.045), 0.045, 0.055, facecolor="#eeeeee", **part))
    axis.add_patch(Rectangle((-0.5, 0.16), 0.5, 0.035, facecolor=BODY, **part))
    axis.add_patch(Rectangle((-0.16, 0.07), 0.32, 0.03, facecolor="#eeeeee", **part))
    axis.add_patch(Rectangle((-0.04, 0.11), 0.26, 0.11, facecolor=BODY, **part))
    axis.add_patch(Rectangle((-0.02, -0.5), 0.04, 0.57, facecolor=BELT, **part))
    stack = (
        (-0.09, 0.06, "torque transducer"),
        (-0.32, 0.20, "brushless motor\nwith current control"),
        (-0.46, 0.08, "encoder: angle"),
    )
    for z, height, text in stack:
        axis.add_patch(Rectangle((-0.11, z), 0.22, height, facecolor="#dfe6ea", **part))
        axis.text(0.15, z + 0.5 * height, text, fontsize=7.5, va="center")
    axis.plot([0.0, 0.0], [-0.52, 0.3], color=LINE, linewidth=0.6, linestyle="-.")
    axis.text(-0.34, 0.22, "rod, strapped to\nthe arm rest", fontsize=7.5, ha="center", va="bottom")
    axis.text(0.24, 0.165, "foot on\nthe handle", fontsize=7.5, va="center")
    _bare(axis, "Wristalyzer, from the side", (-0.62, 0.66), (-0.54, 0.42))


@in_style
def draw_rigs(rigs: Mapping[str, Rig | None], geometry: Mapping, person: Mapping, mass_kg: float) -> Figure:
    """The rigs from the side, with the markers where they stand at rest.

    rigs: experiment (wristalyzer, dummy, weight, standing) -> its markers; the Wristalyzer has none.
    geometry: section ``dummy.geometry`` of the configuration (units in the keys).
    person: section ``standing.person`` of the configuration (units in the keys).
    mass_kg: mass of the weight.
    Returns: A panel for each rig.
    """
    panels = []
    if "wristalyzer" in rigs:
        panels.append(_draw_manipulator)
    if "dummy" in rigs:
        panels.append(lambda axis: _draw_dummy(axis, rigs["dummy"], geometry))
    if "weight" in rigs:
        panels.append(lambda axis: _draw_weight(axis, rigs["weight"], mass_kg))
    if "wristalyzer" in rigs:
        panels.append(_draw_drive)
    if "standing" in rigs:
        stature = float(person["stature_m"])
        panels.append(lambda axis: _draw_person(axis, rigs["standing"], stature))
        panels.append(lambda axis: _draw_person_from_behind(axis, stature))
    columns = min(3, len(panels))
    rows = -(-len(panels) // columns)
    figure, axes = new_figure(rows, columns, 2.5 * rows, squeeze=False)
    for axis in axes.flat[len(panels) :]:
        axis.set_visible(False)
    for axis, panel in zip(axes.flat, panels, strict=False):
        panel(axis)
    return figure


@in_style
def draw_simulation_model(geometry: Mapping) -> Figure:
    """Model of the dummy in the simulation (Figure 2-10): bodies, joints, input and outputs.

    geometry: section ``dummy.geometry`` of the configuration (units in the keys).
    """
    figure, axis = new_figure(1, 1, 2.6)
    length, height = 2.0 * float(geometry["leg_com_m"]), float(geometry["foot_height_m"])
    theta, blue, red = 0.22, COLOURS["recommended"], COLOURS["model"]
    along = np.array([np.sin(theta), np.cos(theta)])
    axis.plot([-0.55, 0.75], [0.0, 0.0], color=LINE, linewidth=0.8)
    for y in np.arange(-0.5, 0.75, 0.08):
        axis.plot([y, y - 0.04], [0.0, -0.04], color=LINE, linewidth=0.5)
    for y in (-0.08, 0.08):
        axis.add_patch(Circle((y, 0.015), 0.015, facecolor="white", edgecolor=LINE, linewidth=0.7))
    foot = 0.03 + 1.4 * height
    axis.add_patch(Rectangle((-0.14, 0.03), 0.28, foot - 0.03, facecolor=BODY, edgecolor=LINE, linewidth=0.8))
    ankle = np.array([0.0, foot + 0.035])
    top, com = ankle + length * along, ankle + 0.5 * length * along
    axis.plot(*np.transpose([ankle, top]), color=LINE, linewidth=7.0, solid_capstyle="butt")
    axis.plot(*np.transpose([ankle, top]), color=BODY, linewidth=5.6, solid_capstyle="butt")
    axis.plot([0.0, 0.0], [ankle[1], ankle[1] + length], color="#999999", linewidth=0.7, linestyle="--")
    axis.add_patch(Circle(tuple(ankle), 0.033, facecolor="white", edgecolor=LINE, linewidth=0.9, zorder=4))
    arc = 1.5 * length
    axis.add_patch(Arc(tuple(ankle), arc, arc, theta1=90.0 - np.degrees(theta), theta2=90.0, color=LINE))
    axis.text(0.03, ankle[1] + 0.79 * length, r"$\theta_A$", fontsize=9.0)
    axis.plot(*com, marker="x", color=LINE, markersize=5.0, zorder=5)
    _arrow(axis, (-0.52, 0.09), (-0.15, 0.09), "", blue, (0.0, 0.0))
    axis.text(
        -0.54,
        0.13,
        "input: recorded motion\nof the belt, $y_f$, $\\dot{y}_f$, $\\ddot{y}_f$",
        fontsize=8.0,
        color=blue,
        ha="center",
        va="bottom",
    )
    notes = (
        (f"leg: {geometry['leg_mass_kg']:g} kg, {geometry['leg_inertia_kgm2']:g} kg·m²", com, 0.62),
        ("revolute joint about $x$: $I$, $B$, $K$", ankle + np.array([0.03, 0.01]), 0.36),
        (f"foot: {geometry['foot_mass_kg']:g} kg, slides along $y$", np.array([0.14, 0.07]), 0.13),
    )
    line = {"arrowstyle": "-", "lw": 0.5, "color": LINE}
    for text, at, z in notes:
        axis.annotate(text, tuple(at), (0.5, z), fontsize=8.0, va="center", arrowprops=line)
    axis.text(
        1.2,
        1.02,
        "recorded: torque, angle and derivatives,\nforces at ankle and ground, motion of the foot",
        fontsize=8.0,
        color=red,
        ha="right",
        va="top",
    )
    _arrow(axis, (-1.05, 0.6), (-0.85, 0.6), "$y$", LINE, (-0.83, 0.58))
    _arrow(axis, (-1.05, 0.6), (-1.05, 0.8), "$z$", LINE, (-1.07, 0.82))
    _bare(axis, "", (-1.1, 1.25), (-0.06, 1.05))
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
