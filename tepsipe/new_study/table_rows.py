"""Text tables of one experiment whose columns have other names, units or signs in each file."""

from tepsipe.io.readers.plain_table import DELIMITERS as NAMED
from tepsipe.io.readers.text_table import refuse_other_unit
from tepsipe.new_study.look import samples
from tepsipe.new_study.measures import driving_sign
from tepsipe.new_study.pairing import Group
from tepsipe.new_study.table_plan import angle_unit

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
