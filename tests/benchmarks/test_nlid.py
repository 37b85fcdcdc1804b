"""Comparison with the toolbox NLID: scores, results of Octave, refusals, and the toolbox where it is."""

import os
import shutil

import numpy as np
import pytest
from builders import assert_one_sentence, trial_of

from benchmarks.nlid import run
from tepsipe.errors import InputError
from tepsipe.experiments.position_manipulator.options import PositionManipulatorOptions
from tepsipe.statistics.goodness_of_fit import HeldOutVaf

RATE = 250.0
OPTIONS = PositionManipulatorOptions(
    **{
        key: value
        for key, value in run.read_settings()["analysis"].items()
        if key in PositionManipulatorOptions.__dataclass_fields__
    }
)


def torque_at(time):
    """Torque (Nm) below 20 Hz at any instant."""
    return 5.0 + sum(np.sin(2.0 * np.pi * f * time + f) for f in (0.4, 1.7, 6.3, 11.0))


@pytest.fixture
def trial():
    time = np.arange(40 * 250) / RATE
    return trial_of(RATE, angle=(np.sin(time), "rad"), torque=(torque_at(time), "Nm"))


def test_perfect_prediction_at_another_rate_scores_100_percent(trial):
    time = np.arange(4000) / 100.0
    found = run.score(time, torque_at(time) - 5.0, trial, OPTIONS)
    assert found.held_out == pytest.approx(100.0, abs=0.05)
    assert found.training == pytest.approx(100.0, abs=0.05)


def test_prediction_that_lags_or_is_too_small_scores_less(trial):
    time = np.arange(4000) / 100.0
    late = run.score(time, torque_at(time - 0.01), trial, OPTIONS)
    half = run.score(time, 0.5 * torque_at(time), trial, OPTIONS)
    assert half.held_out == pytest.approx(75.0, abs=0.5)
    assert 70.0 < late.held_out < 95.0


def test_ends_of_a_simulation_do_not_count(trial):
    time = np.arange(4000) / 100.0
    spoilt = torque_at(time)
    spoilt[:60] = 100.0
    spoilt[-60:] = -100.0
    assert run.score(time, spoilt, trial, OPTIONS).held_out > 99.9


def test_results_of_octave_are_read_with_the_reasons_of_models_that_failed(tmp_path):
    (tmp_path / "models.txt").write_text("pc-rect-100Hz\t\npc-hk-100Hz\tout of memory\npc-sls-100Hz\t\n")
    (tmp_path / "pc-rect-100Hz.txt").write_text("0 1.5\n0.01 -2\n")
    (tmp_path / "pc-sls-100Hz.txt").write_text("0 1.5\n0.01 NaN\n")
    found = run.read_results(tmp_path)
    assert found["pc-rect-100Hz"].tolist() == [[0.0, 1.5], [0.01, -2.0]]
    assert found["pc-hk-100Hz"] == "out of memory"
    assert found["pc-sls-100Hz"] == "its prediction is not finite"


def test_table_has_a_row_per_model_and_says_why_one_is_missing():
    vaf = HeldOutVaf(90.0, 85.123, 86.0, 99.0)
    table = run.table_of({"trial1": [run.Score("a", vaf), run.Score("b", None, "no licence")]}).splitlines()
    assert table[2] == "| trial1 | a | 90.00 | 85.12 | 86.00 |"
    assert table[3] == "| trial1 | b | not fitted: no licence | – | – |"


def test_missing_results_are_refused(tmp_path):
    with pytest.raises(InputError) as caught:
        run.read_results(tmp_path)
    assert_one_sentence(caught.value, "models.txt")


def test_missing_octave_is_one_sentence(monkeypatch, capsys, tmp_path):
    monkeypatch.setenv("PATH", str(tmp_path))
    assert run.main(["table.csv"]) == 2
    error = capsys.readouterr().err
    assert "octave" in error
    assert "found" in error
    assert error.count("\n") == 1


@pytest.mark.parametrize("folder", [None, "empty"])
def test_missing_toolbox_is_one_sentence(folder, monkeypatch, tmp_path, capsys):
    octave = tmp_path / "octave-cli"
    octave.write_text("#!/bin/sh\n")
    octave.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv(run.FOLDER, raising=False)
    if folder:
        monkeypatch.setenv(run.FOLDER, str(tmp_path))
    assert run.main(["table.csv"]) == 2
    error = capsys.readouterr().err
    assert run.FOLDER in error
    assert "NLID" in error


@pytest.mark.slow
def test_octave_that_stops_is_named_with_its_last_message(monkeypatch, tmp_path, root):
    toolbox = tmp_path / "toolbox"
    (toolbox / "stiffnessID").mkdir(parents=True)
    (toolbox / "nlid_tools").mkdir()
    (toolbox / "stiffnessID/PC_stiffnessID.m").write_text("")
    octave = tmp_path / "octave-cli"
    octave.write_text("#!/bin/sh\necho 'error: no display' >&2\nexit 1\n")
    octave.chmod(0o755)
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}/bin")
    monkeypatch.setenv(run.FOLDER, str(toolbox))
    time = np.arange(20000) / 1000.0
    table = tmp_path / "table.csv"
    columns = np.column_stack([time, 0.05 * np.sin(9.0 * time), np.sin(9.0 * time)])
    header = "time_s,ankle_pos_rad,ankle_torque_Nm"
    np.savetxt(table, columns, delimiter=",", header=header, comments="")
    with pytest.raises(InputError) as caught:
        run.toolbox_scores(table, run.read_settings(), OPTIONS)
    assert_one_sentence(caught.value, "no display")


@pytest.mark.slow
@pytest.mark.skipif(
    not (os.environ.get(run.FOLDER) and (shutil.which("octave") or shutil.which("octave-cli"))),
    reason=f"no Octave, or no toolbox named by {run.FOLDER}",
)
def test_models_of_the_toolbox_predict_a_linear_joint(tmp_path):
    rng = np.random.default_rng(1)
    time = np.arange(30000) / 1000.0
    frequency = rng.uniform(0.3, 15.0, 40)
    waves = 0.004 * np.exp(2j * np.pi * (frequency * time[:, None] + rng.uniform(size=40)))
    angle, rate, acceleration = ((waves * (2j * np.pi * frequency) ** k).sum(axis=1).imag for k in range(3))
    torque = -(60.0 * angle + 0.8 * rate + 0.015 * acceleration) + 0.01 * rng.standard_normal(time.size)
    header = "time_s,ankle_pos_rad,ankle_torque_Nm"
    table = tmp_path / "table.csv"
    np.savetxt(table, np.column_stack([time, angle, torque]), delimiter=",", header=header, comments="")
    scores = run.toolbox_scores(table, run.read_settings(), OPTIONS)
    assert {s.model for s in scores} >= {"NLID: pc-rect-100Hz", "NLID: pc-sls-200Hz"}
    assert all(s.vaf.held_out > 95.0 for s in scores if s.vaf is not None)
    assert sum(s.vaf is not None for s in scores) >= 4
