"""Good trials of every experiment, and ways to spoil their files; `bad_input_table.py` has the table."""

import copy
import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import edfio
import ezc3d
import numpy as np
from builders import multisine_record
from c3d_builders import single_c3d, single_c3d_settings
from scipy.io import loadmat, savemat

from tepsipe.virtual_lab.dummy_trial import make_dummy_trial
from tepsipe.virtual_lab.platform_person import PlatformPerson, PlatformProtocol, record_platform
from tepsipe.virtual_lab.standing_trial import make_standing_trial
from tepsipe.virtual_lab.treadmill_trial import Protocol
from tepsipe.virtual_lab.weight_trial import make_weight_trial
from tepsipe.virtual_lab.wristalyzer_trial import make_wristalyzer_trial
from workflow.support.recordings import ingested
from workflow.support.study import Study
from workflow.support.trial_sheet import TrialRow

PLATE = {"log": "log.mat", "calibration": "calibration.csv"}
RAW = {
    "dummy": PLATE | {"markers": "markers.c3d"},
    "weight": PLATE | {"markers": "markers.c3d"},
    "empty": PLATE,
    "standing": PLATE | {"markers": "markers.c3d", "emg": "emg.edf"},
    "wristalyzer": {"log": "log.txt", "command": "command.txt"},
    "position_manipulator": {"log": "table.csv"},
    "belt": {"log": "table.txt"},
    "platform": {"log": "platform.csv"},
}
DURATION_S = {
    "dummy": 12.0,
    "weight": 12.0,
    "empty": 12.0,
    "standing": 16.0,
    "wristalyzer": 16.0,
    "position_manipulator": 20.0,
    "belt": 39.0,
    "platform": 40.0,
}
# a whole trial of the dummy in one file
WHOLE = "whole.c3d"
# another trial beside each good one, whose files are exchanged with it
OTHER = "other"
BELT_COLUMNS = {"time": "t", "load": "Mx (Nm)", "velocity": "v (m/s)"}


@dataclass(frozen=True)
class BadFile:
    """A trial one of whose files is spoiled: what is done to a copy of the good trial's folder."""

    group: str
    name: str
    experiment: str
    spoil: Callable[[Path], None]
    words: str
    whole: bool = False  # the trial is one C3D file with everything


@dataclass(frozen=True)
class BadSettings:
    """A configuration that is refused: the text of an overlay, or the mapping that it holds."""

    name: str
    overlay: str | dict
    words: str


@dataclass(frozen=True)
class BadSheet:
    """A trial sheet that is refused: what is done to its lines, a list of cells each."""

    name: str
    spoil: Callable[[list[list[str]]], object]
    words: str


# ---- good trials ---------------------------------------------------------------------------------------


def short_laboratory(truth: dict) -> dict:
    """The shipped laboratory with less rest, so that short trials hold perturbations."""
    truth = copy.deepcopy(truth)
    protocol = truth["treadmill"]["protocol"]
    protocol |= {"rest_before_s": 2.0, "rest_after_s": 3.0, "rest_after_weight_s": 3.0}
    return truth


def paths(folder: Path, experiment: str, whole: bool = False) -> dict[str, Path]:
    """Kind -> path of the files of a trial in a folder."""
    if whole:
        return {"log": folder / WHOLE}
    return {kind: folder / name for kind, name in RAW[experiment].items()}


def make_good(folder: Path, truth: dict, experiments=tuple(RAW)) -> None:
    """Good trials, folder/experiment/good, and others, folder/experiment/other."""
    truth = short_laboratory(truth)
    for experiment in experiments:
        for name, amplitude in (("good", 0.5), (OTHER, 0.2)):
            place = folder / experiment / name
            place.mkdir(parents=True)
            _make(experiment, place, truth, name, amplitude)
            if experiment == "dummy":
                single_c3d(paths(place, experiment), place / WHOLE)


def _make(experiment: str, place: Path, truth: dict, name: str, amplitude: float) -> None:
    files, lasts = paths(place, experiment), DURATION_S[experiment]
    if experiment == "dummy":
        make_dummy_trial(truth, name, Protocol("sine", amplitude, 2.0, lasts), files)
    elif experiment in ("weight", "empty"):
        make_weight_trial(truth, name, Protocol("sine", amplitude, 2.0, lasts), files)
    elif experiment == "standing":
        make_standing_trial(truth, name, "relax", Protocol("sine", amplitude, (2.0, 2.2), lasts), files)
    elif experiment == "wristalyzer":
        make_wristalyzer_trial(truth, name, 0.4 * amplitude, lasts, files)
    elif experiment == "position_manipulator":
        torque, angle = multisine_record(
            (0.01, 0.5, 100.0), lasts / 10.0 + 0.2, rate_hz=500.0, seed=len(name)
        )
        noise = np.random.default_rng(1).standard_normal((2, torque.size))
        table = [np.arange(torque.size) / 500.0, angle + 1e-6 * noise[0], -torque - 1e-3 * noise[1]]
        header = "time_s,ankle_pos_rad,ankle_torque_Nm"
        np.savetxt(files["log"], np.transpose(table), delimiter=",", header=header, comments="", fmt="%.9g")
    elif experiment == "platform":
        write_platform(files["log"], lasts + 0.5, len(name))
    else:
        rng = np.random.default_rng(len(name))
        time = np.arange(4000) / 100.0
        velocity = 1.2 + 0.1 * np.convolve(rng.standard_normal(4000), np.hanning(40) / 4.5, "same")
        load = 5.0 * np.gradient(velocity, 0.01) + 0.3 * rng.standard_normal(4000)
        header, table = "\t".join(BELT_COLUMNS.values()), np.column_stack([time, load, velocity])
        np.savetxt(files["log"], table, delimiter="\t", header=header, comments="", fmt="%.6g")


def write_platform(path: Path, seconds: float, seed: int, person: PlatformPerson | None = None) -> None:
    """Table of a person on a moving platform (s, m, rad, N·m), with the shipped names of columns."""
    record = record_platform(
        person or PlatformPerson(), PlatformProtocol(seconds), np.random.default_rng(seed)
    )
    table = np.column_stack([record.time, record.platform, record.angle, record.torque])
    header = "time_s,platform_m,ankle_angle_rad,hip_angle_rad,ankle_torque_Nm,hip_torque_Nm"
    np.savetxt(path, table, delimiter=",", header=header, comments="", fmt="%.9g")


def sheet_rows(folder: Path, conditions: dict[str, list[str]], whole=()) -> list[str]:
    """Rows of a trial sheet: experiment -> conditions, whose files are in folder/experiment/condition.

    The conditions in ``whole`` are those of trials of one file.
    """
    rows = []
    for experiment, names in conditions.items():
        for k, name in enumerate(names):
            files = paths(folder / experiment / name, experiment, name in whole)
            role = (
                "-"
                if experiment not in ("weight", "empty", "belt")
                else "validate"
                if k == 1
                else "calibrate"
            )
            columns = list(BELT_COLUMNS.values()) if experiment == "belt" else ["-"] * 3
            cells = [experiment, name, "recorded", "-", "-", "-", f"{DURATION_S[experiment]:g}"]
            cells += [str(files.get(kind, "-")) for kind in ("log", "command", "calibration", "markers")]
            cells += [
                role,
                str(files.get("emg", "-")),
                "relax1" if experiment == "standing" else "-",
                *columns,
            ]
            rows.append("\t".join(cells))
    return rows


# settings of a study of these trials, beside its sheet
STUDY = {
    "plate_treadmill": {"recording": single_c3d_settings()},
    "dummy": {"analysis": {"rest_before_s": 2.0, "rest_after_s": 3.0, "bootstrap_draws": 100}},
    "wristalyzer": {"analysis": {"cut_s": 2.0, "perturbation_period_s": None, "random_starts": 2}},
    "standing": {"pathways": {"ankle-compensated": {"treadmill_model": None}}},
    "position_manipulator": {"analysis": {"bootstrap_draws": 100}},
}


# ---- ways to spoil a file ---------------------------------------------------------------------------------


def gone(name):
    return lambda folder: (folder / name).unlink()


def empty(name):
    return lambda folder: (folder / name).write_bytes(b"")


def folder_instead(name):
    def spoil(folder):
        (folder / name).unlink()
        (folder / name).mkdir()

    return spoil


def cut(name, share):
    def spoil(folder):
        content = (folder / name).read_bytes()
        (folder / name).write_bytes(content[: round(share * len(content))])

    return spoil


def cut_bytes(name, count):
    return lambda folder: (folder / name).write_bytes((folder / name).read_bytes()[:-count])


def content(name, data):
    return lambda folder: (folder / name).write_bytes(data)


def swapped(name, other):
    return lambda folder: shutil.copy(folder / other, folder / name)


def of_other(*names):
    """Files of the other trial of the same experiment, or of another experiment."""

    def spoil(folder):
        for name in names:
            shutil.copy(folder.parent / OTHER / name, folder / name)

    return spoil


def of_experiment(experiment, *names):
    def spoil(folder):
        for name in names:
            shutil.copy(folder.parents[1] / experiment / "good" / name, folder / name)

    return spoil


def text(name, old, new, count=-1):
    """Replace text in a file."""

    def spoil(folder):
        before = (folder / name).read_text()
        after = before.replace(old, new, count)
        assert after != before, f"{old!r} is not in {name}"
        (folder / name).write_text(after)

    return spoil


def lines(name, change):
    """Change the lines of a text file, without their ends."""

    def spoil(folder):
        made = change((folder / name).read_text().splitlines())
        (folder / name).write_text("".join(f"{line}\n" for line in made))

    return spoil


def cells(name, column, change, delimiter="\t"):
    """Change one column of a table as an array: numbers, from the line after the header on."""

    def spoil(folder):
        head, *rest = (folder / name).read_text().splitlines()
        k = head.split(delimiter).index(column)
        rows = [line.split(delimiter) for line in rest]
        values = change(np.array([float(row[k]) for row in rows]))
        for row, value in zip(rows, values, strict=True):
            row[k] = f"{value:.9g}"
        (folder / name).write_text(
            "".join(f"{delimiter.join(row)}\n" for row in ([*[head.split(delimiter)], *rows]))
        )

    return spoil


def mat(**changes):
    """Change variables of the treadmill's log: name -> function of the old value, or None to leave it out."""

    def spoil(folder):
        path = folder / "log.mat"
        held = {k: v for k, v in loadmat(path).items() if not k.startswith("__")}
        for name, change in changes.items():
            value = None if change is None else change(held[name])
            if value is None:
                del held[name]
            else:
                held[name] = value
        savemat(path, held)

    return spoil


def calibration(change):
    """Change the calibration matrix: rows of cells, the header first."""

    def spoil(folder):
        path = folder / "calibration.csv"
        rows = [line.split(",") for line in path.read_text().splitlines()]
        change(rows)
        path.write_text("".join(",".join(row) + "\n" for row in rows))

    return spoil


def factor(value, *components):
    """Rows of the calibration matrix times a number; all rows if none is named."""

    def change(rows):
        for row in rows[1:]:
            if not components or row[0] in components:
                row[2:] = [f"{value * float(x):.9g}" for x in row[2:]]

    return calibration(change)


def c3d(change, name="markers.c3d"):
    """Change a C3D file: a function of its content."""

    def spoil(folder):
        file = ezc3d.c3d(str(folder / name))
        change(file)
        points = file["data"]["points"]
        file["data"]["meta_points"]["residuals"] = np.where(np.isnan(points[:1]).any(axis=0), -1.0, 0.0)[None]
        file["data"]["meta_points"]["camera_masks"] = np.zeros((7, *points.shape[1:]), dtype=bool)
        file.write(str(folder / name))

    return spoil


def points(change):
    """Change positions of the markers, shape (3, markers, frames), in place or by an answer (mm)."""

    def on_file(file):
        p = file["data"]["points"]
        answer = change(p[:3])
        if answer is not None:
            made = np.ones((4, *np.shape(answer)[1:]))
            made[:3] = answer
            file["data"]["points"] = made

    return c3d(on_file)


def put(index, value):
    """Samples of an array set to a value."""

    def change(x):
        x = np.array(x)
        x[index] = value
        return x

    return change


def label(old, new):
    def change(file):
        names = file["parameters"]["POINT"]["LABELS"]["value"]
        names[names.index(old)] = new

    return c3d(change)


def parameter(group, name, value):
    def change(file):
        file["parameters"][group][name]["value"] = [value]

    return c3d(change)


def edf(change):
    """Change signals of the file of electromyograms: a function of the opened file."""

    def spoil(folder):
        file = edfio.read_edf(folder / "emg.edf")
        change({signal.label: signal for signal in file.signals}, file)
        file.write(folder / "emg.edf")

    return spoil


def samples(name, change):
    return edf(
        lambda signals, file: signals[name].update_data(change(signals[name].data), keep_physical_range=False)
    )


def relabelled(old, new):
    def change(signals, file):
        signals[old].label = new

    return edf(change)


def noise(size, seed=1):
    return lambda x: size * np.random.default_rng(seed).standard_normal(np.shape(x))


def times(value):
    return lambda x: value * np.asarray(x)


FOOT, LEG = slice(0, 4), slice(4, 8)


# ---- ingest as the scripts of the workflow do it ----------------------------------------------------------


def ingest(experiment, folder, config, whole=False):
    """The trial of a folder, with the settings of a configuration, as `tepsipe check` reads it."""
    files = {kind: str(path) for kind, path in paths(folder, experiment, whole).items()}
    if whole:
        config = copy.deepcopy(config)
        config["plate_treadmill"]["recording"] |= {
            key: value for key, value in STUDY["plate_treadmill"]["recording"].items() if key != "axes"
        }
    columns = BELT_COLUMNS if experiment == "belt" else {}
    row = TrialRow(
        *(experiment, "a", "recorded", "-", None, None, None, DURATION_S[experiment], files),
        role="calibrate",
        task="relax",
        names={f"files.columns.{key}": name for key, name in columns.items()},
    )
    return ingested(Study(config, {(experiment, "a"): row}), experiment, "a")
