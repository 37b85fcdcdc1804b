"""Participants and belts: what a row of the trial sheet says of them, and the table of the participants."""

import csv
import difflib
import math
from pathlib import Path

from tepsipe.errors import InputError, quoted
from tepsipe.experiments.registry import EXPERIMENTS
from tepsipe.io.names import check_distinct, check_name
from tepsipe.io.readers.plain_file import read_text
from workflow.support.sheets import named_cells, refuse_columns

EMPTY = ("-", "")
BELTS = ("left", "right")
# experiment -> belts of a simulated trial; others move the right one
SIMULATED = {"weight": BELTS, "empty": BELTS, "standing": ("right", "both")}
# numbers of `standing.person` in the table of the participants; beyond its range a number has another unit
RANGES = {
    "mass_kg": (0.1, 500.0),
    "stature_m": (0.4, 2.6),
    "com_height": (0.1, 0.9),
    "ankle_height_m": (0.001, 0.3),
    "foot_com_m": (-0.3, 0.3),
}


def participant_of(cells: dict[str, str], here: str) -> str | None:
    """Participant of a row, None if it names none; ``here`` begins every message."""
    experiment, participant = cells["experiment"], cells.get("participant", "")
    if participant in EMPTY:
        return None
    if not EXPERIMENTS[experiment].of_people:
        raise InputError(
            f"{here}: expected '-' for the participant, because trials of {experiment} have none, found "
            f"{quoted(participant)}: correct it"
        )
    check_name(participant, "participant", here)
    return participant


def belt_of(cells: dict[str, str], here: str) -> str | None:
    """Belt of a row, None if it is that of the configuration; ``here`` begins every message."""
    experiment, belt = cells["experiment"], cells.get("belt", "")
    if belt in EMPTY:
        return None
    if not EXPERIMENTS[experiment].on_plate:
        raise InputError(
            f"{here}: expected '-' for the belt, because trials of {experiment} are not on the plate "
            f"treadmill, found {quoted(belt)}: correct it"
        )
    standing = experiment == "standing"
    if belt not in BELTS and not (standing and belt == "both"):
        each = ", both for a foot on each" if standing else ""
        raise InputError(
            f"{here}: expected the belt to be left or right{each}, or '-' for plate_treadmill.belt of the "
            f"configuration, found {quoted(belt)}: correct it"
        )
    simulated = SIMULATED.get(experiment, ("right",))
    if cells["source"] == "virtual_lab" and belt not in simulated:
        raise InputError(
            f"{here}: expected {' or '.join(simulated)} or '-' for the belt, because the virtual laboratory "
            f"moves no other one in trials of {experiment}, found {quoted(belt)}: correct it"
        )
    return belt


def read_participants(path: str | Path) -> dict[str, dict[str, float]]:
    """Read the table of the participants: name -> numbers that replace those of `standing.person`.

    Tab-separated with one header line: the column ``participant``, and any of `RANGES`; ``-`` keeps the
    number of the configuration.
    """
    text = read_text(Path(path), "the table of the participants", ended=True)
    reader = csv.reader(text.splitlines(), delimiter="\t", quoting=csv.QUOTE_NONE)
    rows = [row for row in reader if any(cell.strip() for cell in row)]
    header = [name.strip() for name in rows[0]] if rows else []
    if len(header) == 1 and header != ["participant"]:
        raise InputError(
            f"{path}: expected columns separated by tabs, found the header {quoted(header[0])}: save it as a "
            "tab-separated table"
        )
    refuse_columns(header, ("participant", *RANGES), path)
    if "participant" not in header:
        raise InputError(
            f"{path}: expected the tab-separated column 'participant', found {', '.join(header) or 'none'}: "
            "add it to the header"
        )
    people: dict[str, dict[str, float]] = {}
    for number, row in enumerate(rows[1:], start=2):
        cells = named_cells(row, header, number, path)
        name = cells.pop("participant")
        check_name(name, "participant", f"{path}: line {number}")
        if name in people:
            raise InputError(
                f"{path}: expected every participant once, found {quoted(name)} again on line {number}: "
                "remove one of the two"
            )
        people[name] = {
            key: _number(cell, key, f"{path}: line {number}")
            for key, cell in cells.items()
            if cell not in EMPTY
        }
    return people


def _number(cell: str, key: str, here: str) -> float:
    try:
        number = float(cell)
    except ValueError:
        number = math.nan
    low, high = RANGES[key]
    if not low <= number <= high:
        raise InputError(
            f"{here}: expected a number from {low:g} to {high:g}, or '-', for {key}, found {quoted(cell)}: "
            "correct it or its unit"
        )
    return number


def person_of(standing: dict, name: str | None, people: dict[str, dict[str, float]]) -> dict:
    """The section `standing.person`, with what the configuration and the table say of a participant."""
    return standing["person"] | standing["participants"].get(name, {}) | people.get(name, {})


def check_people(experiments: dict[str, list], standing: dict, people: dict | None, path, table) -> None:
    """Refuse participants without a row, without mass, or with two values of one number.

    ``experiments`` maps names to their rows of the sheet ``path``; ``people`` is the content of ``table``.
    """
    named = set()
    for experiment, rows in experiments.items():
        without = [row.condition for row in rows if row.participant is None]
        if len(without) not in (0, len(rows)):
            raise InputError(
                f"{path}: expected a participant for every trial of {experiment}, or for none, found none "
                f"for {without[0]}: fill it in"
            )
        named |= {row.participant for row in rows} - {None}
    check_distinct(sorted(named), "participant", str(path))
    for name in sorted(named if people is not None else ()):
        if name not in people:
            close = difflib.get_close_matches(name, people, n=1)
            hint = f"did you mean {close[0]!r}?" if close else f"add a row to {table}"
            raise InputError(f"{path}: expected participants of {table}, found {quoted(name)}: {hint}")
    table_of = people or {}
    for name, own in standing["participants"].items():
        if name not in named and name not in table_of:
            raise InputError(
                f"configuration: expected standing.participants to name participants of {path}, found "
                f"{quoted(name)}: correct one of the two"
            )
        for key in own:
            if key in table_of.get(name, {}):
                raise InputError(
                    f"configuration: expected {key} of participant {name} once, found it in "
                    f"standing.participants and in {table}: remove one of the two"
                )
    for row in experiments.get("standing", ()):
        name = row.participant
        known = standing["participants"].get(name, {}) | table_of.get(name, {})
        if name is not None and "mass_kg" not in known:
            place = f"{table}" if table else "a table, named by study.participants,"
            raise InputError(
                f"{path}: expected the body mass of participant {name}, found none: add mass_kg to {place} "
                f"or to standing.participants.{name}"
            )
