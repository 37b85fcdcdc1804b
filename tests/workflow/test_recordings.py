"""Recordings that `tepsipe check` refuses because their analysis could not begin."""

import copy

import numpy as np
import pytest
from study_builders import write_sheet

from tests.builders import WRISTALYZER_DURATION_S
from workflow.support.recordings import refused_recordings
from workflow.support.study import Study
from workflow.support.trial_sheet import read_trial_sheet


@pytest.fixture
def refused(tmp_path, shipped_config):
    """Sentences of a study of some rows, with other settings by their keys."""
    (tmp_path / "config").mkdir()

    def check(rows, **other):
        write_sheet(tmp_path, ["\t".join(map(str, row)) for row in rows])
        settings = copy.deepcopy(shipped_config)
        for key, value in other.items():
            *sections, last = key.split("__")
            place = settings
            for section in sections:
                place = place[section]
            place[last] = value
        return refused_recordings(Study(settings, read_trial_sheet(tmp_path / "config/tiny.tsv", ".")))

    return check


def test_a_short_or_slow_table_of_a_joint(refused, tmp_path, rng):
    time = np.arange(0.0, 16.0, 0.004)
    angle = 0.002 * np.convolve(rng.standard_normal(time.size), np.hanning(30), mode="same")
    torque = -1.2 * np.gradient(angle, time) - 70.0 * angle

    def row(seconds):
        path, kept = tmp_path / f"{seconds}.csv", time < seconds
        table = np.column_stack([time, angle, torque])[kept]
        header = "time_s,ankle_pos_rad,ankle_torque_Nm"
        np.savetxt(path, table, "%.6f", ",", header=header, comments="")
        name = f"of-{seconds}-s"
        return ["position_manipulator", name, "recorded", "-", "-", "-", seconds, path, "-", "-", "-"]

    assert refused([row(16)]) == []
    (said,) = refused([row(16), row(8)])
    assert said.startswith("position_manipulator/of-8-s: expected at least 4 blocks of 1 s to fit")
    (said,) = refused([row(16)], position_manipulator__analysis__lowpass_cutoff_hz=120.0)
    assert "expected a low-pass of at most" in said


def test_too_few_periods_in_a_torque_controlled_manipulator(refused, wristalyzer_files):
    log, command = (wristalyzer_files[kind] for kind in ("log", "command"))
    row = [*("wristalyzer", "a", "recorded", "-", "-", "-"), WRISTALYZER_DURATION_S, log, command, "-", "-"]
    (said,) = refused([row])
    assert said.startswith("wristalyzer/a: expected more than 13 s of record")
    cut = {"wristalyzer__analysis__cut_s": 1.0}
    assert refused([row], wristalyzer__analysis__perturbation_period_s=None, **cut) == []
    (said,) = refused([row], **cut)
    assert said.startswith("wristalyzer/a: expected at least two periods")


def test_recordings_of_a_belt_too_short_for_its_models(refused, tmp_path):
    rows, time = [], np.arange(0.0, 30.0, 0.01)
    for k, role in enumerate(("calibrate", "validate")):
        path, phase = tmp_path / f"{role}.csv", time + k
        table = np.column_stack(
            [time, 3.0 * np.sin(phase) + 0.1 * np.sin(7.0 * time), 1.0 + 0.1 * np.cos(phase)]
        )
        np.savetxt(path, table, "%.6f", ",", header="t,moment,speed", comments="")
        cells = ["belt", role, "recorded", "-", "-", "-", 30, path, "-", "-", "-"]
        rows.append([*cells, role, "-", "-", "t", "moment", "speed"])
    files = {"belt__files__delimiter": "comma", "belt__files__load_unit": "Nm"}
    assert refused(rows, **files) == []
    (said,) = refused(rows, belt__models__shortest_s=100.0, **files)
    assert said.startswith("models of the belt: calibrate: expected at least 100 s to calibrate")
