"""The trial sheet: one row per trial, made by the virtual laboratory or recorded."""

import csv
import difflib
import math
from dataclasses import dataclass
from pathlib import Path

from tepsipe.errors import InputError
from tepsipe.readers.text_file import read_text

COLUMNS = (
    "experiment",
    "condition",
    "source",
    "profile",
    "amplitude",
    "interval_s",
    "duration_s",
    "log",
    "command",
    "calibration",
    "markers",
)
# experiment -> the kinds of raw file that it needs and the names that the laboratory gives them
RAW_FILES = {
    "wristalyzer": {"log": "log.txt", "command": "command.txt"},
    "dummy": {"log": "log.mat", "calibration": "calibration.csv", "markers": "markers.c3d"},
    "ankle": {"log": None},
}
PROFILES = {"wristalyzer": ("multisine",), "dummy": ("sine", "minjerk"), "ankle": ()}
EMPTY = "-"


@dataclass(frozen=True)
class TrialRow:
    """One row of the sheet; ``files`` maps kinds of raw file to paths, and is empty for the laboratory's."""

    experiment: str
    condition: str
    source: str
    profile: str
    amplitude: float | None
    interval_s: float | None
    duration_s: float
    files: dict[str, str]


def read_trial_sheet(path: str | Path, recordings_folder: str | Path) -> dict[tuple, TrialRow]:
    """Read and check the sheet; keys are (experiment, condition), in the sheet's order."""
    text = read_text(Path(path), "the trial sheet")
    rows = list(csv.reader(text.splitlines(), delimiter="\t"))
    header = [name.strip() for name in rows[0]] if rows else []
    for name in header:
        if name not in COLUMNS:
            close = difflib.get_close_matches(name, COLUMNS, n=1, cutoff=0.5)
            hint = f"did you mean {close[0]!r}?" if close else f"known: {', '.join(COLUMNS)}"
            raise InputError(f"{path}: unknown column {name!r}: {hint}")
    for name in COLUMNS:
        if header.count(name) > 1:
            raise InputError(f"{path}: expected the column {name!r} once, found it twice: remove one")
        if name not in header:
            raise InputError(
                f"{path}: expected the tab-separated column {name!r}, found {', '.join(header)}: add "
                "it to the header and fill it with - where it does not apply"
            )
    trials: dict[tuple, TrialRow] = {}
    for number, cells in enumerate(rows[1:], start=2):
        if not any(cell.strip() for cell in cells):
            continue
        if len(cells) != len(header):
            raise InputError(
                f"{path}: expected {len(header)} cells, found {len(cells)} on line {number}: separate "
                "them by one tab each"
            )
        row = _row(dict(zip(header, map(str.strip, cells), strict=True)), number, path)
        key = (row.experiment, row.condition)
        if key in trials:
            raise InputError(
                f"{path}: expected every trial once, found {'/'.join(key)} again on line {number}: "
                "rename its condition"
            )
        trials[key] = TrialRow(
            **{
                **vars(row),
                "files": {k: str(Path(recordings_folder) / f) for k, f in row.files.items()},
            }
        )
    if not trials:
        raise InputError(f"{path}: expected at least one trial, found none: add a row")
    return trials


def _row(cells: dict[str, str], number: int, path) -> TrialRow:
    here = f"{path}: line {number}"
    experiment, condition, source = cells["experiment"], cells["condition"], cells["source"]
    if experiment not in RAW_FILES:
        raise InputError(
            f"{here}: expected an experiment of {', '.join(RAW_FILES)}, found {experiment!r}: correct it"
        )
    if not condition or not all(c.isalnum() or c in ".-" for c in condition):
        raise InputError(
            f"{here}: expected a condition of letters, digits, dots and hyphens, found {condition!r}: "
            "rename it"
        )
    if source not in ("virtual_lab", "recorded"):
        raise InputError(
            f"{here}: expected the source to be virtual_lab or recorded, found {source!r}: correct it"
        )
    needed = RAW_FILES[experiment]
    files = {kind: cells[kind] for kind in needed if cells[kind] not in (EMPTY, "")}
    if source == "recorded":
        for kind in needed:
            if kind not in files:
                raise InputError(
                    f"{here}: expected a {kind} file for {experiment}/{condition}, found "
                    f"{cells[kind]!r}: name the recorded file"
                )
    elif files or not all(needed.values()):
        found = f"{next(iter(files.values()))!r}" if files else f"experiment {experiment!r}"
        raise InputError(
            f"{here}: expected no files for what the virtual laboratory can make, found {found}: set "
            "the source to recorded"
        )
    numbers = {}
    for name in ("amplitude", "interval_s", "duration_s"):
        try:
            numbers[name] = None if cells[name] == EMPTY else float(cells[name])
        except ValueError:
            numbers[name] = -1.0
        if numbers[name] is not None and not 0.0 < numbers[name] < math.inf:
            raise InputError(
                f"{here}: expected a positive number or {EMPTY!r} for {name}, found {cells[name]!r}: "
                "correct it"
            )
    made = source == "virtual_lab"
    wanted = ["duration_s"] + (["amplitude"] if made else [])
    wanted += ["interval_s"] if made and experiment == "dummy" else []
    for name in wanted:
        if numbers[name] is None:
            raise InputError(f"{here}: expected a number for {name}, found {EMPTY!r}: fill it in")
    if made and cells["profile"] not in PROFILES[experiment]:
        raise InputError(
            f"{here}: expected a profile of {', '.join(PROFILES[experiment])}, found "
            f"{cells['profile']!r}: correct it"
        )
    return TrialRow(experiment, condition, source, cells["profile"], **numbers, files=files)
