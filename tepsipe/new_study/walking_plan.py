"""Settings of walking trials: markers, axes and plates of instruments, columns of tables, and events."""

import re

from tepsipe.experiments.walking.options import WalkingOptions
from tepsipe.new_study.files import EVENTS, Found, events_of
from tepsipe.new_study.pairing import Group
from tepsipe.new_study.plan import Missing, Plan
from tepsipe.new_study.treadmill_plan import across, forward_of
from tepsipe.new_study.treadmill_trials import Seen, plain, side_of

# part of the leg -> how the label of its marker looks, without the side
MARKERS = {
    "ankle": r"L?M?MAL|ANK|LM\b|MALLEOLUS|FAL\b",
    "knee": r"KNE|LEK|LFE|FLE\b|EPI",
    "heel": r"HEE|CAL|FCC",
    "toe": r"TOE|MT\d|MTP|FM\d",
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


def plan_walking(plan: Plan, groups: list[Group], seen: dict[str, Seen]) -> None:
    """Settings of walking trials, with events in a table or in the file of the trial, or without any.

    seen: name of the first file -> what it shows (SI units), of trials in files of instruments.
    """
    first, events = groups[0].first, groups[0].partners.get("events")
    kinds = {g.first.contents.kind for g in groups if g.first.kind == "whole trial"}
    if len(kinds) > 1:
        where, how = (
            "walking.recording.axes",
            "a study of its own for each kind, unless the axes are the same",
        )
        plan.check.append(Missing(where, f"files of the kinds {', '.join(sorted(kinds))} share them", how))
    columns = {} if events is None else events_of(event_names(events))
    side = "right" if columns.get("heel_strike", "").lower().startswith("r") else "left"
    if not columns:
        plan.check.append(
            Missing("walking", "the left leg was assumed: no events name one", "the perturbed leg")
        )
    _plan_recording(plan, first, side, seen.get(first.name))
    _plan_columns(plan, groups, side)
    for kind in EVENTS:
        absent = (
            "found by the vertical force" if kind != "pulse" else "no pulses: what an experiment would need"
        )
        note = f"found in {events.name}" if kind in columns else absent
        plan.put(f"walking.events.{kind}", columns.get(kind), note)
    plan.put("walking.rate_hz", 100.0, "regular clock")
    plan.put("walking.max_gap_s", 0.15, "longest gap")
    plan.assume("walking.from_s", 0.0, "all strides", "time until which the belt speeds up")
    _plan_analysis(plan)


def event_names(file: Found) -> list[str]:
    """Names of the columns of a table of events, or labels of the events of a C3D."""
    return list(dict.fromkeys(label for label, _ in file.contents.events)) or [
        channel.name for channel in file.contents.channels
    ]


def _plan_recording(plan: Plan, first: Found, side: str, seen: Seen | None) -> None:
    key, whole = "walking.recording", first.kind == "whole trial"
    forward, why = forward_of([seen or Seen()])
    up = seen.up if seen else "+z"
    plan.put(f"{key}.axes.forward", forward, why if seen else "not used for tables")
    plan.put(f"{key}.axes.up", up, "upward in the file")
    if whole:
        plan.check.append(Missing(f"{key}.axes", f"{forward}, {up} were assumed: {why}", "see the markers"))
    own, other = _plates(seen, forward, side)
    plan.put(f"{key}.plates.own", own, "force plate under the perturbed foot")
    plan.put(f"{key}.plates.other", other, "force plate under the other foot")
    pulled = seen is not None and min(seen.loads_N.values(), default=0.0) < 0.0
    plan.put(
        f"{key}.force_sign", -1 if pulled else 1, "forces on the plate" if pulled else "forces on the person"
    )
    plan.put(f"{key}.surface_m", 0.0, "height of the belt")
    if whole:
        meaning = f"{own} was assumed under the perturbed foot, {other} under the other one"
        plan.check.append(Missing(f"{key}.plates", meaning, "numbers as tepsipe info lists them"))
    labels = sorted(first.contents.markers or ()) if whole else []
    for part, pattern in MARKERS.items():
        fitting = [label for label in labels if re.search(pattern, plain(label), re.IGNORECASE)]
        fitting.sort(key=lambda label: side_of(label) != side)
        if fitting or not whole:
            plan.put(
                f"{key}.markers.{part}", fitting[0] if fitting else part, f"of the {side} leg, by its label"
            )
        else:
            plan.ask(
                f"{key}.markers.{part}", f"label of the marker of the {part}", f"one of {', '.join(labels)}"
            )


def _plates(seen: Seen | None, forward: str, side: str) -> tuple[int, int]:
    """Numbers of the plates under a foot and under the other one, by their places, else 1 and 2."""
    loads = {} if seen is None else seen.loads_N
    left_to_right = [int(n) for n in sorted(loads, key=lambda n: -abs(loads[n]))[:2]]
    if len(left_to_right) < 2:
        return 1, 2
    places = {n: across(seen, str(n), forward) for n in left_to_right}
    if None in places.values():
        left_to_right.sort()
    else:
        left_to_right.sort(key=places.get)
    left, right = left_to_right
    return (right, left) if side == "right" else (left, right)


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
