"""The trial sheet: one row per trial, simulated by the virtual laboratory or recorded."""

import csv
import difflib
import math
import os
from dataclasses import dataclass, field
from pathlib import Path

from tepsipe.errors import InputError, listed, quoted
from tepsipe.experiments.registry import EXPERIMENTS
from tepsipe.io.formats import holds_whole_trial, takes_markers_beside
from tepsipe.io.names import check_distinct, check_name
from tepsipe.io.readers.plain_file import read_text
from workflow.support.people import belt_of, participant_of
from workflow.support.row_names import NAME_COLUMNS, names_of
from workflow.support.sheets import named_cells, refuse_columns

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
# which a sheet needs only if one of its experiments does
OPERATING_COLUMNS = ("operating_angle_rad", "operating_torque_Nm")
OPTIONAL_COLUMNS = (
    *("role", "emg", "task", *NAME_COLUMNS, "participant", "belt", "mass_kg"),
    *OPERATING_COLUMNS,
    "events",
)
# longest trials (s); more is a number in another unit
LONGEST_S = {"virtual_lab": 3600.0, "recorded": 86400.0}
ROLES = ("calibrate", "validate")
EMPTY = "-"


@dataclass(frozen=True)
class TrialRow:
    """One row of the sheet.

    ``interval_s`` is the shortest, ``longest_interval_s`` the longest time between perturbations. ``files``
    maps kinds of raw file to paths, and is empty for simulated trials. ``role`` and ``task`` (instruction of
    the person) are None where trials have none. ``names`` maps settings of the experiment to what the
    row says in their place, for example ``files.columns.time`` to the name of a column. ``participant``
    is None where the row names none, ``belt`` (left or right) where it is that of the configuration, and
    ``mass_kg`` (of the weight, kg) where it is that of the configuration or there is no weight, and
    ``operating_angle_rad`` and ``operating_torque_Nm`` where the measured means hold.
    """

    experiment: str
    condition: str
    source: str
    profile: str
    amplitude: float | None
    interval_s: float | None
    longest_interval_s: float | None
    duration_s: float
    files: dict[str, str]
    role: str | None
    task: str | None
    names: dict[str, str | int] = field(default_factory=dict)
    participant: str | None = None
    belt: str | None = None
    mass_kg: float | None = None
    operating_angle_rad: float | None = None
    operating_torque_Nm: float | None = None


def read_trial_sheet(path: str | Path, recordings_folder: str | Path) -> dict[tuple, TrialRow]:
    """Read and check the sheet; keys are (experiment, condition), in the sheet's order."""
    text = read_text(path, "the trial sheet", ended=True)
    try:
        rows = list(csv.reader(text.splitlines(), delimiter="\t"))
    except csv.Error as error:
        raise InputError(f"{path}: expected cells separated by tabs, found {error}: correct it") from None
    header = [name.strip() for name in rows[0]] if rows else []
    _check_header(header, path)
    trials: dict[tuple, TrialRow] = {}
    for number, cells in enumerate(rows[1:], start=2):
        if not any(cell.strip() for cell in cells) or cells[0].lstrip().startswith("#"):
            continue  # an empty line, or a comment
        row = _row(named_cells(cells, header, number, path), number, path)
        key = (row.experiment, row.condition)
        if key in trials:
            raise InputError(
                f"{path}: expected every trial once, found {'/'.join(key)} again on line {number}: "
                "rename its condition"
            )
        trials[key] = TrialRow(
            **{**vars(row), "files": {k: str(Path(recordings_folder) / f) for k, f in row.files.items()}}
        )
    _check_together(trials, path)
    return trials


def _check_header(header: list[str], path: str | Path) -> None:
    """Refuse unknown, repeated and missing columns."""
    refuse_columns(header, COLUMNS + OPTIONAL_COLUMNS, path)
    for name in COLUMNS:
        if name not in header:
            raise InputError(
                f"{path}: expected the tab-separated column {quoted(name)}, found {listed(header)}: add "
                "it to the header and fill it with - where it does not apply"
            )


def _check_together(trials: dict[tuple, TrialRow], path: str | Path) -> None:
    """Refuse a sheet without trials, names that are alike, and models without trials for them."""
    if not trials:
        raise InputError(f"{path}: expected at least one trial, found none: add a row")
    for experiment in dict.fromkeys(experiment for experiment, _ in trials):
        check_distinct((c for e, c in trials if e == experiment), f"condition of {experiment}", str(path))
    check_distinct([row.task for row in trials.values() if row.task is not None], "task", str(path))
    for row in trials.values():
        if row.task is not None and row.participant is None and (row.experiment, row.task) in trials:
            raise InputError(
                f"{path}: expected tasks and conditions of {row.experiment} to have different names, because "
                f"both head rows of estimates, found {quoted(row.task)} for both: rename the condition"
            )
    _refuse_one_recording_twice(trials, path)
    for models in dict.fromkeys(filter(None, (e.models for e in EXPERIMENTS.values()))):
        check_roles([row for row in trials.values() if EXPERIMENTS[row.experiment].models == models], path)


def _refuse_one_recording_twice(trials: dict[tuple, TrialRow], path: str | Path) -> None:
    """Refuse two trials of one recording, which would count as independent; an empty belt may be shared.

    Other columns or another belt of the same file are another trial.
    """
    seen: dict[tuple, str] = {}
    for (experiment, condition), row in trials.items():
        if experiment == "empty" or "log" not in row.files:
            continue
        named = tuple(sorted((key, str(value)) for key, value in row.names.items()))
        key, trial = (os.path.normpath(row.files["log"]), named, row.belt), f"{experiment}/{condition}"
        if key in seen:
            raise InputError(
                f"{path}: expected a recording of its own for every trial, found {quoted(row.files['log'])} "
                f"for {seen[key]} and for {trial}: they would count as two independent trials, remove one "
                "row or name its own file"
            )
        seen[key] = trial


def check_sources(trials: dict[tuple, TrialRow], path: str | Path, virtual_lab: str | None) -> None:
    """Refuse simulated trials if there is no laboratory, and the weight without the empty belt."""
    for (experiment, condition), row in trials.items():
        if row.source == "virtual_lab" and virtual_lab is None:
            raise InputError(
                f"{path}: expected recordings only, because study.virtual_lab is null, found "
                f"{experiment}/{condition} to be made: name its files"
            )
    experiments = {experiment for experiment, _ in trials}
    for there, missing in (("weight", "empty"), ("empty", "weight")):
        if there in experiments and missing not in experiments:
            raise InputError(
                f"{path}: expected trials of {missing} beside those of {there}, found none: models of the "
                "treadmill need the empty belt and a known weight, add its rows"
            )


def check_roles(rows: list[TrialRow], path, belt: str | None = None) -> None:
    """Models need trials that calibrate them and others that validate them, on the belt if one is named."""
    on = f" on the {belt} belt" if belt else ""
    for experiment in dict.fromkeys(row.experiment for row in rows) if belt is None else ("weight", "empty"):
        if not any(row.role == "calibrate" for row in rows if row.experiment == experiment):
            raise InputError(
                f"{path}: expected a trial of {experiment}{on} with the role calibrate, found none: without "
                "it no model can be fitted, set the role of one of its rows"
            )
    evaluated = [row for row in rows if row.experiment != "empty"]
    if evaluated and not any(row.role == "validate" for row in evaluated):
        names = " or ".join(dict.fromkeys(row.experiment for row in evaluated))
        raise InputError(
            f"{path}: expected a trial of {names}{on} with the role validate, found none: without it no "
            "model can be tested, set the role of one of its rows or record another trial"
        )
    calibrating: dict[tuple, TrialRow] = {}
    for row in rows:
        if row.role == "calibrate":
            calibrating.setdefault(tuple(sorted(row.files.items())), row)
    for other in (row for row in rows if row.files and row.role == "validate"):
        own = calibrating.get(tuple(sorted(other.files.items())))
        if own is not None:
            raise InputError(
                f"{path}: expected {other.experiment}/{other.condition} to validate on a recording of "
                f"its own, found that of {own.experiment}/{own.condition}, {quoted(own.files['log'])}: "
                "name another file"
            )


def _row(cells: dict[str, str], number: int, path) -> TrialRow:
    """Row of a trial, checked cell by cell in the order of the columns."""
    here = f"{path}: line {number}"
    _check_trial(cells, here)
    files = _files(cells, here)
    numbers = _numbers(cells, here)
    _check_protocol(cells, numbers, here)
    return TrialRow(
        cells["experiment"],
        cells["condition"],
        cells["source"],
        cells["profile"],
        **numbers,
        files=files,
        role=_role(cells, here),
        task=_task(cells, here),
        names=names_of(cells, here),
        participant=participant_of(cells, here),
        belt=belt_of(cells, here),
        mass_kg=_mass(cells, here),
        **{name: _operating(cells, name, here) for name in OPERATING_COLUMNS},
    )


def _check_trial(cells: dict[str, str], here: str) -> None:
    """Refuse an experiment, a condition or a source that cannot be."""
    experiment, source = cells["experiment"], cells["source"]
    if experiment not in EXPERIMENTS:
        raise InputError(
            f"{here}: expected an experiment of {', '.join(EXPERIMENTS)}, found {quoted(experiment)}: "
            "correct it"
        )
    check_name(cells["condition"], "condition", here)
    if source not in ("virtual_lab", "recorded"):
        raise InputError(
            f"{here}: expected the source to be virtual_lab or recorded, found {quoted(source)}: correct it"
        )


def _files(cells: dict[str, str], here: str) -> dict[str, str]:
    """Kind -> name of the raw files: all that a recorded trial needs, none of a simulated one."""
    needed = EXPERIMENTS[cells["experiment"]].raw_files
    files = {kind: cells[kind] for kind in needed if cells.get(kind, "") not in (EMPTY, "")}
    whole = "calibration" in needed and holds_whole_trial(files.get("log", ""))
    if whole and takes_markers_beside(files["log"]) and cells.get("markers", "") not in (EMPTY, ""):
        files["markers"] = cells["markers"]  # of the empty belt, too: D-Flow's forces are among the markers
    if cells["source"] == "recorded":
        _check_recorded(cells, files, whole, here)
    elif files or not all(needed.values()):
        experiment = cells["experiment"]
        found = f"{quoted(next(iter(files.values())))}" if files else f"experiment {experiment!r}"
        raise InputError(
            f"{here}: expected no files for what the virtual laboratory can make, found {found}: set "
            "the source to recorded"
        )
    return files


def _check_recorded(cells: dict[str, str], files: dict[str, str], whole: bool, here: str) -> None:
    """Refuse a recorded trial without a file that it needs; a log with the ``whole`` trial needs no other."""
    experiment, trial = EXPERIMENTS[cells["experiment"]], f"{cells['experiment']}/{cells['condition']}"
    if whole:
        _refuse_beside_whole_trial(files, trial, here)
    for kind in ("log",) if whole else experiment.raw_files:
        if kind not in files and kind not in experiment.optional_files:
            raise InputError(
                f"{here}: expected a {kind} file for {trial}, found "
                f"{quoted(cells.get(kind, 'no such column'))}: name the recorded file"
            )


def _numbers(cells: dict[str, str], here: str) -> dict[str, float | None]:
    """Amplitude, duration (s), and shortest and longest interval between perturbations (s)."""
    numbers = {name: _positive(cells[name], name, here) for name in ("amplitude", "duration_s")}
    shortest, dash, longest = cells["interval_s"].partition("-")
    if EXPERIMENTS[cells["experiment"]].at_random and shortest and dash:
        interval = _positive(shortest, "interval_s", here), _positive(longest, "interval_s", here)
        if interval[0] > interval[1]:
            raise InputError(
                f"{here}: expected interval_s from short to long, found {quoted(cells['interval_s'])}: "
                "turn it round"
            )
    else:
        interval = (_positive(cells["interval_s"], "interval_s", here),) * 2
    return numbers | {"interval_s": interval[0], "longest_interval_s": interval[1]}


def _check_protocol(cells: dict[str, str], numbers: dict[str, float | None], here: str) -> None:
    """Refuse a trial without a length, and a simulated one without a motion that can be made."""
    experiment, made = EXPERIMENTS[cells["experiment"]], cells["source"] == "virtual_lab"
    wanted = ["duration_s"] + (["amplitude"] if made else [])
    wanted += ["interval_s"] if made and experiment.pulsed else []
    longest = LONGEST_S["virtual_lab" if made else "recorded"]
    if (numbers["duration_s"] or 0.0) > longest:
        raise InputError(
            f"{here}: expected a duration_s of at most {longest:g} s, found {quoted(cells['duration_s'])}: "
            "correct it or its unit"
        )
    for name in wanted:
        if numbers[name] is None:
            raise InputError(f"{here}: expected a number for {name}, found {EMPTY!r}: fill it in")
    if made and cells["profile"] not in experiment.profiles:
        raise InputError(
            f"{here}: expected a profile of {', '.join(experiment.profiles)}, found "
            f"{quoted(cells['profile'])}: correct it"
        )


def _operating(cells: dict[str, str], name: str, here: str) -> float | None:
    """Angle (rad) or torque (N·m) about which a joint was perturbed, if the row names it."""
    cell = cells.get(name, "")
    if cell in (EMPTY, ""):
        return None
    if cells["experiment"] != "position_manipulator":
        raise InputError(
            f"{here}: expected {EMPTY!r} for {name}, because only trials of position_manipulator have an "
            f"operating point, found {quoted(cell)}: correct it"
        )
    try:
        value = float(cell)
    except ValueError:
        value = math.nan
    if not math.isfinite(value) or (name == "operating_angle_rad" and abs(value) > math.pi):
        raise InputError(
            f"{here}: expected a number in the unit of its name, or {EMPTY!r}, for {name}, found "
            f"{quoted(cell)}: correct it or its unit"
        )
    return value


def _mass(cells: dict[str, str], here: str) -> float | None:
    """Mass of the weight of a trial (kg), if the row names one."""
    mass = _positive(cells.get("mass_kg") or EMPTY, "mass_kg", here)
    if mass is not None and cells["experiment"] != "weight":
        raise InputError(
            f"{here}: expected {EMPTY!r} for mass_kg, because trials of {cells['experiment']} have no "
            f"weight, found {quoted(cells['mass_kg'])}: correct it"
        )
    return mass


def _refuse_beside_whole_trial(files: dict[str, str], trial: str, here: str) -> None:
    """Refuse a calibration or, unless the log takes them, markers beside a log that holds the whole trial."""
    for kind in ("calibration",) if takes_markers_beside(files["log"]) else ("calibration", "markers"):
        if kind in files:
            raise InputError(
                f"{here}: expected {EMPTY!r} for the {kind} of {trial}, because its log "
                f"{quoted(files['log'])} holds the whole trial, found {quoted(files[kind])}: correct one "
                "of the two"
            )


def _positive(cell: str, name: str, here: str) -> float | None:
    try:
        number = None if cell == EMPTY else -1.0 if "_" in cell else float(cell)
    except ValueError:
        number = -1.0
    if number is not None and not 0.0 < number < math.inf:
        raise InputError(
            f"{here}: expected a positive number or {EMPTY!r} for {name}, found {quoted(cell)}: correct it"
        )
    return number


def _task(cells: dict[str, str], here: str) -> str | None:
    """Task of a standing person, or of another experiment's participant, who need not have one."""
    experiment, task = cells["experiment"], cells.get("task", "")
    tasks = EXPERIMENTS[experiment].tasks
    if not tasks:
        if task not in (EMPTY, "") and participant_of(cells, here):
            check_name(task, "task", here)
            return task
        if task not in (EMPTY, ""):
            raise InputError(
                f"{here}: expected {EMPTY!r} for the task, because trials of {experiment} have none, found "
                f"{quoted(task)}: correct it"
            )
        return None
    made = cells["source"] == "virtual_lab"
    if task in (EMPTY, "") or (made and task not in tasks):
        found = repr(task) if "task" in cells else "no such column"
        expected = (
            f"a task of {' or '.join(tasks)}" if made else "a task of letters, digits, dots and hyphens"
        )
        raise InputError(
            f"{here}: expected {expected} for {experiment}/{cells['condition']}, found {found}: fill in "
            "the instruction of the person"
        )
    check_name(task, "task", here)
    return task


def _role(cells: dict[str, str], here: str) -> str | None:
    experiment, role = cells["experiment"], cells.get("role", "")
    if EXPERIMENTS[experiment].models is None:
        if role not in (EMPTY, ""):
            raise InputError(
                f"{here}: expected {EMPTY!r} for the role, because trials of {experiment} have none, found "
                f"{quoted(role)}: correct it"
            )
        return None
    if role not in ROLES:
        found = repr(role) if "role" in cells else "no such column"
        close = difflib.get_close_matches(role, ROLES, n=1, cutoff=0.5)
        hint = f"did you mean {close[0]!r}?" if close else "fill in what the trial is for"
        raise InputError(
            f"{here}: expected a role of {' or '.join(ROLES)} for {experiment}/{cells['condition']}, found "
            f"{found}: {hint}"
        )
    return role
