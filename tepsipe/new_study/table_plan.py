"""Settings of the trials that are text tables: both manipulators, a moving platform, and a belt.

Columns, units and signs that differ between the files of one experiment stand in the trial sheet.
"""

import re

import numpy as np

from tepsipe.io.readers.plain_table import DELIMITERS as NAMED
from tepsipe.io.readers.text_table import refuse_other_unit
from tepsipe.new_study.files import Found, candidates_by_role, samples
from tepsipe.new_study.measures import driving_sign, period_s, resisting_sign
from tepsipe.new_study.pairing import Group, key_of
from tepsipe.new_study.plan import Missing, Plan

LARGEST_RAD = 3.2
DEFAULT_RATE_HZ, PLATFORM_RATE_HZ = 250.0, 50.0
PLATFORM_UNITS = ("m", "m/s", "m/s2")
# names of a column with a second perturbation of a person on a platform
PUSHES = r"push|pull|second|rotation"
# experiment -> characters between columns that its reader takes
DELIMITERS = {
    "wristalyzer": ("tab",),
    **dict.fromkeys(("position_manipulator", "platform", "belt"), tuple(NAMED)),
}
ROLES = {
    "wristalyzer": {"time_column": "time", "angle_column": "angle", "trigger_column": "trigger"},
    "position_manipulator": {"time_column": "time", "angle_column": "angle", "torque_column": "torque"},
    "platform": {"time_column": "time"},
}
ANGLE = {"wristalyzer": "angle", "position_manipulator": "angle", "platform": "ankle_angle"}
UNITS = {"time": "s", "torque": "Nm", "velocity": "m/s", "force": "N"}


def angle_unit(values: np.ndarray, unit: str) -> tuple[str, str]:
    """Unit of an angle, ``rad`` or ``deg``, and why: by the name of its column, else by its size (rad)."""
    if unit in ("rad", "deg"):
        return unit, "by the name of the column"
    largest = float(np.nanmax(np.abs(values), initial=0.0))
    unit = "rad" if largest < LARGEST_RAD else "deg"
    return unit, f"by its size, at most {largest:.3g}"


def plan_wristalyzer(plan: Plan, groups: list[Group]) -> None:
    """Settings of the torque-controlled manipulator."""
    first = groups[0].first
    names, key = first.columns, "wristalyzer"
    for role, setting in (("time", "time"), ("angle", "angle"), ("trigger", "trigger_time")):
        plan.put(f"{key}.files.log_columns.{setting}", names[role], f"found in {first.name}")
        _name_others(plan, f"{key}.files.log_columns.{setting}", first, role)
    angle = first.channel(names["angle"])
    unit, why = angle_unit(samples(angle), angle.unit)
    plan.assume(f"{key}.files.angle_unit", unit, why, "unit of the angle in the log")
    command = next((g.partners["command"] for g in groups if "command" in g.partners), None)
    if command is not None:
        for setting in ("time", "torque"):
            plan.put(
                f"{key}.files.command_columns.{setting}", command.columns[setting], f"found in {command.name}"
            )
        torque = command.channel(command.columns["torque"])
        period = period_s(samples(torque), torque.rate_hz) if torque.rate_hz else None
        note = (
            "the command repeats itself after this time" if period else "the command does not repeat itself"
        )
        plan.put(
            f"{key}.analysis.perturbation_period_s", None if period is None else float(f"{period:.4g}"), note
        )
    for group in groups:
        used = group.partners.get("command")
        if used is not None and key_of(used.name) != key_of(group.first.name):
            where, meaning = f"trials.tsv, {key}/{group.condition}", f"{used.name} was assumed, by its length"
            plan.check.append(Missing(f"{where}, command", meaning, "the command of this trial"))
    plan.check.append(
        Missing(
            f"{key}.analysis",
            "bounds of K and bands are those of the thesis, for a rubber joint of 10 Nm/rad",
            "set lower, upper, start and the bands to those of your joint and perturbation",
        )
    )


def plan_position(plan: Plan, groups: list[Group]) -> None:
    """Settings of the position-controlled manipulator."""
    first = groups[0].first
    key = "position_manipulator"
    for role in ("time", "angle", "torque"):
        plan.put(f"{key}.files.columns.{role}", first.columns[role], f"found in {first.name}")
        _name_others(plan, f"{key}.files.columns.{role}", first, role)
    _plan_delimiter(plan, key, groups)
    angle, torque = (first.channel(first.columns[role]) for role in ("angle", "torque"))
    unit, why = angle_unit(samples(angle), angle.unit)
    plan.put(f"{key}.files.angle_unit", unit, why)
    sign = driving_sign(samples(angle), samples(torque), angle.rate_hz or 1.0)
    how = "-1 if a torque that resists a positive angle is recorded as negative, else 1"
    plan.assume(f"{key}.files.torque_sign", sign, "sign of the torque that moves the joint", how)
    _plan_rate(plan, key, groups, "angle", DEFAULT_RATE_HZ)


def _name_others(plan: Plan, key: str, file: Found, role: str) -> None:
    """List the columns that might be meant instead of the chosen one."""
    others = candidates_by_role([c.name for c in file.contents.channels]).get(role, [])[1:]
    if others:
        meaning = f"{file.columns[role]} was assumed, not {', '.join(others)}"
        plan.check.append(Missing(key, meaning, "the column that was measured at the joint"))


def plan_platform(plan: Plan, groups: list[Group]) -> None:
    """Settings of a person on a moving platform."""
    first, key = groups[0].first, "platform"
    for role, name in first.columns.items():
        plan.put(f"{key}.files.columns.{role}", name, f"found in {first.name}")
    _plan_delimiter(plan, key, groups)
    angle, torque = (first.channel(first.columns[f"ankle_{what}"]) for what in ("angle", "torque"))
    unit, why = angle_unit(samples(angle), angle.unit)
    plan.put(f"{key}.files.angle_unit", unit, why)
    sign = resisting_sign(samples(angle), samples(torque), angle.rate_hz or 1.0)
    how = "-1 if a torque that resists a positive angle is recorded as negative, else 1"
    plan.assume(f"{key}.files.torque_sign", sign, "sign of K of the ankle in a regression", how)
    named = first.channel(first.columns["platform"]).unit
    if named in PLATFORM_UNITS:
        plan.put(f"{key}.files.platform_unit", named, "by the name of the column")
    else:
        plan.assume(f"{key}.files.platform_unit", "m", "a position", "m, m/s or m/s2; it only labels figures")
    plan.check.append(
        Missing(
            f"{key}.files.columns",
            "angle of the ankle from the vertical, of the hip relative to the leg, both positive forwards",
            "subtract or turn the recorded angles if they are defined otherwise",
        )
    )
    for channel in first.contents.channels:
        pushed = re.search(PUSHES, channel.name, re.IGNORECASE) and channel.name not in first.columns.values()
        if pushed and np.nanstd(samples(channel)) > 0.0:
            how = "null if it is no perturbation that was applied at random beside the platform's"
            plan.assume(f"{key}.files.columns.second_perturbation", channel.name, "by its name", how)
            break
    _plan_rate(plan, key, groups, "ankle_angle", PLATFORM_RATE_HZ)


def _plan_delimiter(plan: Plan, key: str, groups: list[Group]) -> None:
    """Character between the columns of an experiment's tables."""
    first = groups[0].first
    plan.put(f"{key}.files.delimiter", first.contents.facts["delimiter"], f"found in {first.name}")


def _plan_rate(plan: Plan, key: str, groups: list[Group], role: str, shipped_hz: float) -> None:
    """Rate of the trials (Hz), if the tables are slower than the shipped one."""
    rate = min((g.first.channel(g.first.columns[role]).rate_hz or np.inf for g in groups), default=np.inf)
    if rate < (1.0 - 1e-3) * shipped_hz:
        plan.put(
            f"{key}.ingest.resample_rate_hz", float(f"{0.99 * rate:.3g}"), "just below the rate of the tables"
        )


def plan_belt(plan: Plan, groups: list[Group]) -> None:
    """Settings of the calibration of a treadmill."""
    first = groups[0].first
    _plan_delimiter(plan, "belt", groups)
    role = load_role(first.columns)
    plan.put("belt.files.load_unit", "Nm" if role == "torque" else "N", f"of {first.columns[role]}")
    if len(groups) < 2:
        plan.missing.append(
            Missing(
                "trials.tsv, role", "a second recording, to validate the models on", "record another trial"
            )
        )


def load_role(columns: dict[str, str]) -> str:
    """Role of the column with the load of a belt table (N·m or N): torque before force."""
    return "torque" if "torque" in columns else "force"


def unlike_tables(groups: list[Group]) -> dict[str, str]:
    """Tables that cannot be in a study with the first one of their experiment: name of the file -> why."""
    why = {}
    for experiment, allowed in DELIMITERS.items():
        members = [g for g in groups if g.experiment == experiment]
        fitting = []
        for group in members:
            file = next((f for f in _files(group) if _delimiter(f) not in allowed), None)
            if file is not None:
                why[group.first.name] = (
                    f"columns of {file.name} are separated by a {_delimiter(file)}: export them with a "
                    f"{' or '.join(allowed)}"
                )
                continue
            fitting.append(group)
        for group in fitting[1:]:
            first = fitting[0].first
            if _delimiter(group.first) != _delimiter(first):
                why[group.first.name] = (
                    f"its columns are separated by a {_delimiter(group.first)}, those of {first.name} by a "
                    f"{_delimiter(first)}: export both alike"
                )
            elif experiment == "platform" and _others(group) != _others(fitting[0]):
                why[group.first.name] = (
                    f"its columns have other names than those of {first.name}: rename them"
                )
    return why


def refuse_units(group: Group) -> None:
    """Refuse a table with a column in a unit that its reader does not convert, by its columns' names."""
    file = group.first
    for role, column in file.columns.items():
        what = role.rpartition("_")[2]
        unit = UNITS.get(what, "")
        if what == "angle":
            channel = file.channel(column)
            unit = angle_unit(samples(channel), channel.unit)[0]
        needed = role in ROLES.get(group.experiment, {}).values() or group.experiment in ("platform", "belt")
        if needed and not (role == "force" and "torque" in file.columns):
            refuse_other_unit(column, unit, str(file.path), role.replace("_", " "))


def _files(group: Group) -> list:
    command = group.partners.get("command")
    return [group.first, *([] if command is None else [command])]


def _delimiter(file) -> str:
    return file.contents.facts["delimiter"]


def _others(group: Group) -> dict[str, str]:
    """Columns of a platform's table that no row of the sheet can name."""
    return {role: name for role, name in group.first.columns.items() if role != "time"}


def named_in_rows(groups: list[Group]) -> dict[str, dict[str, str]]:
    """Name of a table -> columns of the sheet, where it differs from the first table of its experiment."""
    rows: dict[str, dict[str, str]] = {}
    for experiment in ROLES:
        members = [g for g in groups if g.experiment == experiment]
        for group in members[1:]:
            first, own = _named(members[0]), _named(group)
            different = {key: cell for key, cell in own.items() if cell != first.get(key)}
            if "torque_column" not in different:
                different.pop("torque_sign", None)
            rows[group.first.name] = different
    return rows


def _named(group: Group) -> dict[str, str]:
    """Columns, unit and sign of a table, by the column of the sheet that names them."""
    file, experiment = group.first, group.experiment
    named = {column: file.columns[role] for column, role in ROLES[experiment].items()}
    angle = file.channel(file.columns[ANGLE[experiment]])
    named["angle_unit"] = angle_unit(samples(angle), angle.unit)[0]
    if experiment == "position_manipulator":
        torque = samples(file.channel(file.columns["torque"]))
        named["torque_sign"] = str(driving_sign(samples(angle), torque, angle.rate_hz or 1.0))
    command = group.partners.get("command")
    if command is not None:
        named |= {"torque_column": command.columns["torque"], "command_time_column": command.columns["time"]}
    return named
