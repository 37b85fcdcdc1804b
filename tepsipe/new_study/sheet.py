"""Trial sheet of a study: one row per trial, with its guesses in a comment above it."""

import re

import numpy as np

from tepsipe.new_study.files import samples
from tepsipe.new_study.measures import pulses_of
from tepsipe.new_study.pairing import Group, after_trigger
from tepsipe.new_study.plan import PLACEHOLDER, Missing
from tepsipe.new_study.table_plan import load_role, named_in_rows
from tepsipe.new_study.treadmill_plan import BELTS, ON_PLATES, belts_of
from tepsipe.new_study.treadmill_trials import BeltChannel, Seen, usual_belt
from tepsipe.new_study.weights import weights_of

COLUMNS = (
    "experiment", "condition", "source", "profile", "amplitude", "interval_s", "duration_s", "log", "command",
    "calibration", "markers",
)  # fmt: skip
OPTIONAL = (
    *("role", "emg", "events", "task", "participant", "belt", "mass_kg"),
    *("time_column", "load_column", "velocity_column", "angle_column", "torque_column", "trigger_column"),
    *("command_time_column", "angle_unit", "torque_sign"),
)
TASKS = ("relax", "relaxed", "stiff", "tense", "calm", "quiet", "normal", "eyes-closed", "eyes-open")
EMPTY = "-"


def rows_of(
    groups: list[Group], seen: dict[str, Seen], people: dict[str, str]
) -> tuple[list[dict[str, str]], list[Missing]]:
    """Rows of the sheet, and what is missing in them.

    seen: name of the first file -> what a treadmill trial shows (SI units).
    people: name of the first file -> participant, if there are several.

    Returns:
        rows: column -> cell.
        missing: cells with the placeholder.
    """
    weights = weights_of(groups, seen)
    further = {g.first.name for _, own in weights[1:] for g in own}
    belts = belts_of(groups, seen)
    roles = _roles(groups, weights, belts)
    named = named_in_rows(groups)
    usual = usual_belt(s for name, s in seen.items() if name in _on_plates(groups))
    _name_unlike_tasks(groups, people)
    rows, missing = [], []
    for group in groups:
        row = dict.fromkeys((*COLUMNS, *OPTIONAL), EMPTY)
        row |= {
            "experiment": group.experiment,
            "condition": group.condition,
            "source": "recorded",
            "duration_s": f"{_duration(group, seen.get(group.first.name)):g}",
            "log": group.first.name,
            "role": roles.get(group.first.name, EMPTY),
            "participant": people.get(group.first.name, EMPTY),
        }
        wanted = ("calibration", "markers", "emg", "command", "events")
        row |= {kind: group.partners[kind].name for kind in wanted if kind in group.partners}
        if group.experiment == "walking":  # one file holds markers and forces
            row |= {"markers": EMPTY}
        elif "record" in group.partners:  # D-Flow: the log is that of the belts
            row |= {"log": group.partners["record"].name, "markers": group.first.name}
        if group.experiment == "standing":
            row["task"] = _task(group)
        else:
            row["emg"] = EMPTY
        if group.experiment == "empty" and "record" not in group.partners:
            row["markers"] = EMPTY
        row |= named.get(group.first.name, {})
        if group.experiment == "belt":
            names = group.first.columns
            row |= {f"{role}_column": names[role] for role in ("time", "velocity")}
            row["load_column"] = names[load_role(names)]
        if group.first.name in _on_plates(groups) and "record" not in group.partners:
            row["velocity_column"] = _own_channel(seen[group.first.name], usual)
        if belts and group.experiment in ON_PLATES:
            row["belt"] = belts.get(group.first.name, PLACEHOLDER)
        if group.first.name in further:
            row["mass_kg"] = PLACEHOLDER
        for kind in _needed(group):
            if row[kind] == EMPTY:
                row[kind] = PLACEHOLDER
        missing += [
            Missing(f"trials.tsv, {group.experiment}/{group.condition}, {name}", *ABOUT[name])
            for name, cell in row.items()
            if cell == PLACEHOLDER
        ]
        rows.append(row)
    return rows, missing


def _on_plates(groups: list[Group]) -> set[str]:
    """First files of trials of one file whose experiment is on the belts of a treadmill."""
    return {g.first.name for g in groups if g.experiment in ON_PLATES and g.first.kind == "whole trial"}


def _own_channel(seen: Seen, usual: BeltChannel | None) -> str:
    """Channel of the belt's velocity in a trial, if it is another one than usual."""
    return EMPTY if seen.belt is None or usual is None or seen.belt.name == usual.name else seen.belt.name


def _name_unlike_tasks(groups: list[Group], people: dict[str, str]) -> None:
    """Make the names of trials differ from the names of tasks, because both head rows of the same table."""
    standing = [g for g in groups if g.experiment == "standing"]
    tasks = {_task(g) for g in standing}
    tasks |= {f"{people[g.first.name]}-{_task(g)}" for g in standing if g.first.name in people}
    for group in standing:
        if group.condition in tasks:
            group.condition += "-1"


ABOUT = {
    "belt": ("belt that is perturbed, left or right", "by your protocol"),
    "mass_kg": ("mass of its weight (kg)", "weigh it, as in weight.further_weights of the configuration"),
    "task": (
        "instruction of the person, for example relax",
        "by your protocol; rename the file, or fill in the cell",
    ),
    "command": ("file of the torque command", "export it, or name the one that was used"),
    "calibration": (
        "calibration matrix of the force plate (CSV)",
        "from the maker of the treadmill; without one, take out the row",
    ),
    "markers": ("C3D file of the markers of this trial", "export it from the motion capture system"),
}


def _needed(group: Group) -> tuple[str, ...]:
    if group.first.kind == "treadmill log":
        return ("calibration",) if group.experiment == "empty" else ("calibration", "markers")
    return ("command",) if group.first.kind == "manipulator log" else ()


def _duration(group: Group, seen: Seen | None) -> float:
    """Length of a trial (s) that all of its files reach, rounded down to 0.1 s."""
    if seen is not None or group.first.kind == "whole trial":
        length = (group.first.duration_s or 0.0) if seen is None else seen.duration_s
    elif group.first.kind == "manipulator log":
        command, after = group.partners.get("command"), after_trigger(group.first)
        length = min(after, command.duration_s) if command is not None else after
    else:
        time = samples(group.first.channel(group.first.columns["time"]))
        length = float(np.nanmax(time) - np.nanmin(time) + np.nanmedian(np.diff(time)))
    return max(0.1, float(np.floor(10.0 * length + 1e-6)) / 10.0)


def _task(group: Group) -> str:
    words = re.split(r"[^a-z]+", group.first.name.lower())
    return next((word for word in reversed(words) if word in TASKS), PLACEHOLDER)


def _roles(
    groups: list[Group], weights: list[tuple[float, list[Group]]], belts: dict[str, str]
) -> dict[str, str]:
    """First file of each trial of weight, empty or belt -> its role.

    Each weight has trials of both roles, and so has the empty belt, on every belt of the treadmill.

    belts: first file -> belt of the treadmill.
    """
    roles = {}
    others = [[g for g in groups if g.experiment == experiment] for experiment in ("empty", "belt")]
    for alike in (*(own for _, own in weights), *others):
        for belt in dict.fromkeys(belts.get(g.first.name) for g in alike):
            members = [g for g in groups if g in alike and belts.get(g.first.name) == belt]
            kinds = [_motion(g.condition) for g in members]
            for k, group in enumerate(members):
                if "val" in kinds[k] or "test" in kinds[k]:
                    role = "validate"
                elif len(set(kinds)) > 1:  # another motion of the belt validates
                    role = "calibrate" if kinds[k] == kinds[0] else "validate"
                else:
                    role = "validate" if k == len(members) - 1 and k else "calibrate"
                roles[group.first.name] = role
                group.notes.append(f"role {role} by the order of the names")
    return roles


def _motion(condition: str) -> str:
    """First word of a condition that is not the belt's."""
    words = [word for word in re.split(r"[-_\d]", condition.lower()) if word not in BELTS]
    return words[0] if words else ""


def sheet_text(rows: list[dict[str, str]], groups: list[Group]) -> str:
    """The sheet as tab-separated text, without optional columns that no row needs (units in its header)."""
    header = [*COLUMNS, *(n for n in OPTIONAL if any(row[n] != EMPTY for row in rows))]
    lines = ["\t".join(header)]
    for row, group in zip(rows, groups, strict=True):
        if group.notes:
            lines.append(f"# {group.experiment}/{group.condition}: {'; '.join(dict.fromkeys(group.notes))}")
        lines.append("\t".join(row[name] for name in header))
    return "\n".join(lines) + "\n"


def describe_pulses(seen: Seen) -> str:
    """Comment on the belt's pulses (s); empty if it had none."""
    if seen.velocity is None:
        return ""
    pulses = pulses_of(seen.velocity, seen.velocity_rate_hz)
    if pulses is None:
        return ""
    return f"{pulses.count} pulses of the belt from {pulses.first_s:.2f} to {pulses.last_s:.2f} s"
