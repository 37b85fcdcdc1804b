"""Names that a row of the trial sheet gives in place of the configuration's: columns, channels, unit, sign.

Each experiment declares those that it takes (`Experiment.names`).
"""

from collections.abc import Iterable

from tepsipe.errors import InputError, quoted
from tepsipe.experiments.registry import EXPERIMENTS
from tepsipe.io.formats import holds_whole_trial

NAME_COLUMNS = tuple(
    dict.fromkeys(name for known in (EXPERIMENTS["belt"], *EXPERIMENTS.values()) for name in known.names)
)
# cells that are no names
VALUES: dict[str, dict[str, str | int]] = {
    "angle_unit": {"rad": "rad", "deg": "deg"},
    "torque_sign": {"1": 1, "+1": 1, "-1": -1},
}
NOTHING = ("-", "")


def names_of(cells: dict[str, str], here: str) -> dict[str, str | int]:
    """Setting of the experiment -> what the row says in its place; ``here`` begins every message."""
    experiment, trial = cells["experiment"], f"{cells['experiment']}/{cells['condition']}"
    known = EXPERIMENTS[experiment]
    found: dict[str, str | int] = {}
    for column in NAME_COLUMNS:
        cell = cells.get(column, "")
        if column in known.named and cell in NOTHING:
            what = column.removesuffix("_column")
            said = repr(cell) if column in cells else "no such column"
            raise InputError(
                f"{here}: expected a {column} for {trial}, found {said}: name the column that holds the "
                f"{what} as the header of its table does"
            )
        if cell in NOTHING:
            continue
        if column not in known.names:
            raise InputError(
                f"{here}: expected '-' for {column}, because files of {experiment} take "
                f"{', '.join(known.names) or 'no names from the sheet'}, found {quoted(cell)}: correct it"
            )
        if cells["source"] == "virtual_lab":
            raise InputError(
                f"{here}: expected '-' for {column}, because the virtual laboratory names its columns "
                f"itself, found {quoted(cell)}: correct it"
            )
        if known.on_plate and not holds_whole_trial(cells.get("log", "")):
            raise InputError(
                f"{here}: expected '-' for {column}, because a MATLAB log has variables of fixed names "
                f"and only channels of a whole trial in one file may be named, found {quoted(cell)}: correct "
                "it"
            )
        values = VALUES.get(column)
        if values is not None and cell not in values:
            raise InputError(
                f"{here}: expected {column} to be {' or '.join(values)}, or '-' for that of the "
                f"configuration, found {quoted(cell)}: correct it"
            )
        found[known.names[column]] = cell if values is None else values[cell]
    _refuse_twice(experiment, found, here)
    return found


def named_by(experiment: str, names: Iterable[str], table: str) -> dict[str, str]:
    """Key of a table's columns -> where its name was given, for messages: a column of the trial sheet."""
    column_of = {setting: column for column, setting in EXPERIMENTS[experiment].names.items()}
    return {
        setting.rpartition(".")[2]: f"{column_of[setting]} of the trial sheet"
        for setting in names
        if setting.rpartition(".")[0] == table
    }


def with_names(section: dict, names: dict[str, str | int]) -> dict:
    """Settings of an experiment with what a row says in place of some; ``section`` stays as it is."""
    merged = dict(section)
    for setting, value in names.items():
        *sections, key = setting.split(".")
        target = merged
        for name in sections:
            target[name] = dict(target.get(name, {}))
            target = target[name]
        target[key] = value
    return merged


def check_names(experiment: str, condition: str, section: dict, names: dict, path) -> None:
    """Refuse a row whose names, with those of the configuration, give one column two meanings."""
    merged = with_names(section, names)
    for table in dict.fromkeys(setting.rpartition(".")[0] for setting in names):
        if not table.endswith("columns"):
            continue
        _, key = table.split(".")
        columns = {f"{table}.{what}": name for what, name in merged["files"][key].items()}
        _refuse_twice(experiment, columns, f"{path}: {experiment}/{condition}")


def _refuse_twice(experiment: str, names: dict, here: str) -> None:
    column_of = {setting: column for column, setting in EXPERIMENTS[experiment].names.items()}
    seen: dict[tuple[str, str | int], str] = {}
    for setting, name in names.items():
        table = setting.rpartition(".")[0]
        if name is None:
            continue  # a column that files need not have
        if table.endswith("columns") and (table, name) in seen:
            raise InputError(
                f"{here}: expected {column_of[seen[table, name]]} and {column_of[setting]} to name two "
                f"columns, found {quoted(name)} for both: correct one of the two"
            )
        seen[table, name] = setting
