"""Settings of walking trials: markers, axes and plates of instruments, columns of tables, and events."""

import re

from tepsipe.errors import InputError
from tepsipe.experiments.walking.impedance import WalkingOptions
from tepsipe.new_study.look import EVENTS, Found
from tepsipe.new_study.pairing import Group
from tepsipe.new_study.settings import Missing, Plan

# part of the leg -> how the label of its marker looks, without the side
MARKERS = {
    "ankle": r"L?M?MAL|ANK|LM\b|MALLEOLUS",
    "knee": r"KNE|LEK|LFE|EPI",
    "heel": r"HEE|CAL",
    "toe": r"TOE|MT\d|MTP",
}
# signal -> how the name of its column looks, {} for the side of the leg; then the other leg's
COLUMNS = {
    "angle": r"{}.*ankle.*angle|{}.*ankle.*flexion(?!.*moment)",
    "vertical": r"{}.*(grf|force|f).?[_ ]?(y|vertical)$",
    "anterior": r"{}.*(grf|force|f).?[_ ]?(x|anterior)$",
    "cop": r"{}.*cop.?[_ ]?x$",
    "ankle_x": r"{}.*(ankle|foot).?[_ ]x$",
    "ankle_y": r"{}.*(ankle|foot).?[_ ]y$",
}
AXES = {"D-Flow": ("-z", "+y"), "other": ("+y", "+z")}
SIDES = {"left": "l(eft)?", "right": "r(ight)?"}
TOLERANCES = {
    "joint_centre_anterior_m": (0.005, "palpated malleolus"),
    "joint_centre_vertical_m": (0.005, "palpated malleolus"),
    "foot_mass_kg": (0.12, "10 % between tables of anthropometry"),
    "belt_load_kgm": (0.01, "what a treadmill model leaves of the load per belt acceleration"),
    "sync_s": (0.0003, "common trigger"),
    "angle_gain": (0.02, "motion of skin and shoe"),
    "inertia_kgm2": (0.004, "30 % between persons and shoes"),
}


def events_of(names: list[str]) -> dict[str, str]:
    """Kind of event -> name of its column in a table of events; empty if it is none.

    Of columns of both feet those of the left one are taken.
    """
    by_kind = {}
    for kind, pattern in EVENTS.items():
        fitting = [name for name in names if re.search(pattern, name.strip(), re.IGNORECASE)]
        fitting.sort(key=lambda name: not re.match(SIDES["left"], name, re.IGNORECASE))
        if fitting:
            by_kind[kind] = fitting[0]
    return by_kind if {"heel_strike", "toe_off"} <= by_kind.keys() else {}


def plan_walking(plan: Plan, groups: list[Group]) -> None:
    """Settings of walking trials, whose groups each have a table of events.

    Raises
    ------
    InputError
        If there are other trials, too.
    """
    if any(g.experiment != "walking" for g in groups):
        raise InputError(
            f"{groups[0].first.name}: expected a folder of walking trials only, because a study of "
            "walking has a report of its own, found "
            f"{next(g.first.name for g in groups if g.experiment != 'walking')}, too: "
            "put them into two folders"
        )
    first, events = groups[0].first, groups[0].partners["events"]
    kinds = {g.first.contents.kind for g in groups if g.first.kind == "whole trial"}
    if len(kinds) > 1:
        where, how = (
            "walking.recording.axes",
            "a study of its own for each kind, unless the axes are the same",
        )
        plan.check.append(Missing(where, f"files of the kinds {', '.join(sorted(kinds))} share them", how))
    columns = events_of([c.name for c in events.contents.channels])
    right = columns["heel_strike"].lower().startswith("r")
    _plan_recording(plan, first, "right" if right else "left")
    _plan_columns(plan, groups, "right" if right else "left")
    for kind in EVENTS:
        note = f"found in {events.name}" if kind in columns else "no pulses: what an experiment would need"
        plan.put(f"walking.events.{kind}", columns.get(kind), note)
    plan.put("walking.rate_hz", 100.0, "regular clock")
    plan.put("walking.max_gap_s", 0.15, "longest gap")
    plan.assume("walking.from_s", 0.0, "all strides", "time until which the belt speeds up")
    _plan_analysis(plan)


def _plan_recording(plan: Plan, first: Found, side: str) -> None:
    key, whole = "walking.recording", first.kind == "whole trial"
    axes = AXES["D-Flow" if first.contents.kind.startswith("D-Flow") else "other"]
    for name, value in zip(("forward", "up"), axes, strict=True):
        plan.put(f"{key}.axes.{name}", value, "direction in the file")
    if whole:
        plan.check.append(
            Missing(f"{key}.axes", f"{axes[0]}, {axes[1]} were assumed", "see tepsipe info, and the markers")
        )
    plan.put(f"{key}.plates.own", 1, "force plate under the perturbed foot")
    plan.put(f"{key}.plates.other", 2, "force plate under the other foot")
    plan.put(f"{key}.force_sign", 1, "forces on the person")
    plan.put(f"{key}.surface_m", 0.0, "height of the belt")
    if whole:
        meaning = "1 was assumed under the perturbed foot, 2 under the other one"
        plan.check.append(Missing(f"{key}.plates", meaning, "numbers as tepsipe info lists them"))
    labels = sorted(first.contents.markers or ()) if whole else []
    for part, pattern in MARKERS.items():
        fitting = [label for label in labels if re.search(pattern, label, re.IGNORECASE)]
        fitting.sort(key=lambda label: not re.match(SIDES[side][0], label, re.IGNORECASE))
        if fitting or not whole:
            plan.put(
                f"{key}.markers.{part}", fitting[0] if fitting else part, f"of the {side} leg, by its label"
            )
        else:
            plan.ask(
                f"{key}.markers.{part}", f"label of the marker of the {part}", f"one of {', '.join(labels)}"
            )


def _plan_columns(plan: Plan, groups: list[Group], side: str) -> None:
    """Names of the columns, of a trial that is a table."""
    table = next((g.first for g in groups if g.first.kind != "whole trial"), None)
    names = [] if table is None else [c.name for c in table.contents.channels]
    key, other = "walking.columns", {"left": "right", "right": "left"}[side]

    def named(signal: str, pattern: str, of: str) -> None:
        wanted = pattern.replace("{}", f"^{SIDES[of]}")
        fitting = [name for name in names if re.search(wanted, name, re.IGNORECASE)]
        if table is None:
            plan.put(f"{key}.{signal}", signal)
        elif fitting:
            plan.put(f"{key}.{signal}", fitting[0], f"found in {table.name}")
        else:
            plan.ask(
                f"{key}.{signal}", f"column of the signal {signal}", f"as the header of {table.name} has it"
            )

    plan.put(f"{key}.time", "time" if table is None else table.columns["time"])
    for signal, pattern in COLUMNS.items():
        named(signal, pattern, side)
    named("other_vertical", COLUMNS["vertical"], other)
    plan.put(f"{key}.supplied_moment", None, "a moment of your software, if it is to be compared")


def _plan_analysis(plan: Plan) -> None:
    defaults = vars(WalkingOptions())
    for name, value in defaults.items():
        value = list(value) if isinstance(value, tuple) else value
        if name == "foot_mass_kg":
            plan.ask(
                f"walking.analysis.{name}", "mass of the foot (kg)", "1.45 % of the body's mass, and the shoe"
            )
        else:
            plan.put(f"walking.analysis.{name}", value)
    meaning = f"{defaults['inertia_kgm2']:g} was assumed"
    plan.check.append(Missing("walking.analysis.inertia_kgm2", meaning, "of foot and shoe about the ankle"))
    for name, value in (
        ("amplitude_deg", 1.5),
        ("duration_s", 0.06),
        ("stiffness_Nm_per_rad", [100.0, 180.0, 280.0, 400.0]),
        ("damping_Nms_per_rad", 2.0),
        ("strides", 150),
    ):
        plan.put(f"walking.planned.{name}", value)
    plan.put("walking.simulated", None, "recordings only")
    for name, (u, source) in TOLERANCES.items():
        plan.put(f"walking.uncertainty.{name}.standard_uncertainty", u)
        plan.put(f"walking.uncertainty.{name}.distribution", "normal")
        plan.put(f"walking.uncertainty.{name}.source", source)
    plan.check.append(
        Missing("walking.uncertainty", "tolerances of a usual laboratory", "your own standard uncertainties")
    )
