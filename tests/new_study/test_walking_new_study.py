"""tepsipe new-study for walking: it sees markers, columns and events, and what it writes is accepted."""

import shutil

import numpy as np
import pytest

from tepsipe.errors import InputError
from tepsipe.new_study.files import look_at
from tepsipe.new_study.study import new_study
from tepsipe.virtual_lab.walker import Joint, perturb
from tepsipe.virtual_lab.walking_trial import WalkerBody, write_events, write_walk
from tests.experiments.test_walking import synthetic_walk
from workflow.check import main
from workflow.support.checked_study import checked_study, merged_settings


@pytest.fixture(scope="module")
def recordings(tmp_path_factory):
    folder = tmp_path_factory.mktemp("recordings")
    base = synthetic_walk(26)
    walk = perturb(base, Joint(), {8: 40.0, 11: 40.0}, 0.03, 0.06, 0.0, np.random.default_rng(1))
    write_walk(folder / "slow.txt", "dflow", walk, base, WalkerBody(), np.random.default_rng(2))
    write_events(folder / "slow_events.csv", walk)
    return folder


def test_a_folder_of_walking_trials_becomes_a_study(recordings, root, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(root)
    kinds = {found.name: found.kind for found in look_at(recordings)}
    assert kinds == {"slow.txt": "whole trial", "slow_events.csv": "events"}
    made = new_study(recordings, "steps", tmp_path / "steps")
    assert made.trials == {"walking": 1} and made.missing == 1 and not made.left
    assert "walking.analysis.foot_mass_kg" in (made.folder / "MISSING.md").read_text()
    config = made.folder / "config.yaml"
    assert main([str(config)]) == 2 and "MISSING" in capsys.readouterr().err
    config.write_text(config.read_text().replace("foot_mass_kg: MISSING", "foot_mass_kg: 1.1"))
    monkeypatch.chdir(made.folder)
    assert main(["config.yaml"]) == 2  # two pulses
    assert "perturbed strides at one of the phases" in capsys.readouterr().err
    files = [str(root / "config/config.yaml"), "config.yaml"]
    settings = merged_settings(files)
    study = checked_study(settings, files)
    row = study.trials["walking", "slow"]
    assert {kind: path.rpartition("/")[2] for kind, path in row.files.items()} == {
        "log": "slow.txt",
        "events": "slow_events.csv",
    }
    walking = settings["walking"]
    assert walking["recording"]["axes"] == {"forward": "-z", "up": "+y"}
    assert walking["recording"]["markers"]["toe"] == "LTOE"
    assert walking["events"] == {"heel_strike": "heel_strike", "toe_off": "toe_off", "pulse": "pulse"}


def test_columns_of_a_table_are_found_by_the_side_of_the_events(tmp_path):
    folder = tmp_path / "tables"
    folder.mkdir()
    names = "time,LeftAnkleAngle,RightAnkleAngle,RightAnkleMoment,LeftGRF_y,RightGRF_y,RightGRF_x,RightCOP_x"
    names += ",RightFoot_x,RightFoot_y"
    table = np.random.default_rng(3).normal(size=(400, 10))
    table[:, 0] = np.arange(400) / 100.0
    np.savetxt(folder / "walk.csv", table, delimiter=",", header=names, comments="")
    events = "\n".join(f"{k}.1,{k}.7" for k in range(30))
    (folder / "walk_events.csv").write_text(f"rhs,rto\n{events}\n")
    new_study(folder, "steps", tmp_path / "steps")
    text = (tmp_path / "steps/config.yaml").read_text()
    for setting in ("angle: RightAnkleAngle", "other_vertical: LeftGRF_y", "cop: RightCOP_x", "pulse: null"):
        assert setting in text


def test_walking_and_other_trials_become_two_studies(recordings, tmp_path):
    folder = tmp_path / "both"
    shutil.copytree(recordings, folder)
    time = np.arange(800) / 200.0
    np.savetxt(
        folder / "ankle.csv",
        np.column_stack([time, np.sin(time), np.cos(time)]),
        delimiter=",",
        header="time_s,angle_rad,torque_Nm",
        comments="",
    )
    (tmp_path / "steps-walking").write_text("mine")
    with pytest.raises(InputError, match="steps-walking: expected a folder to write to, found a file"):
        new_study(folder, "steps", tmp_path / "steps")
    (tmp_path / "steps-walking").unlink()
    made = new_study(folder, "steps", tmp_path / "steps")
    assert made.trials == {"position_manipulator": 1}
    (walking,) = made.others
    assert walking.trials == {"walking": 1}
    assert walking.folder == tmp_path / "steps-walking"
    assert "name: steps-walking" in (walking.folder / "config.yaml").read_text()
