"""Exports read back: MATLAB files by scipy, OpenSim's files by their own header."""

import h5py
import numpy as np
import pytest
from builders import assert_one_sentence
from scipy.io import loadmat

from tepsipe.cli import main
from tepsipe.errors import InputError
from tepsipe.io.mat_export import export_mat, valid_name
from tepsipe.io.opensim_export import motion_of, torque_of, write_storage
from tepsipe.io.result import Result, write_result
from tepsipe.io.stored import read_stored
from tepsipe.io.trial import Signal, Trial, write_trial

TIME = np.arange(50) / 100.0


@pytest.fixture
def fit(tmp_path):
    """Path of a result as the dummy's fit writes it."""
    theta = 0.1 * np.sin(TIME)
    arrays = {
        "time": TIME,
        "leg/torque": 10.0 * theta,
        "leg/regressors": np.column_stack([0.0 * theta, 0.0 * theta, theta]),
        "leg-thesis/torque": 7.0 * theta,
        "10 Hz/response": np.array([1.0 + 2.0j]),
        "many": np.arange(3),
    }
    units = dict.fromkeys(arrays, "Nm") | {"time": "s"}
    facts = {
        "theta_rest_rad": 0.02,
        "pathways": ["leg", "leg-thesis"],
        "spread": [1.0, 2.0],
        "fault": None,
        "nested": {"a-b": [[1], [2, 3]]},
    }
    path = tmp_path / "fit.h5"
    write_result(path, Result(arrays, units, facts))
    return path


@pytest.fixture
def trial(tmp_path, rng):
    """Path of a trial on the force plates: a load of known point of application, and none on the left."""
    force, point = np.zeros((50, 2, 3)), np.array([0.1, 0.25, 0.0])
    force[:, 1] = np.array([5.0, 40.0, 700.0]) + rng.standard_normal((50, 3))
    moment = np.cross(point, force) + np.array([0.0, 0.0, 2.0]) * (force[:, :, 2:] != 0.0)
    signals = {
        "force": Signal(force, "N", ("time", "belt", "axis")),
        "moment": Signal(moment, "Nm", ("time", "belt", "axis")),
        "hidden": Signal(TIME > 0.2, "1"),
    }
    axes = {"time": TIME, "belt": np.array(["left", "right"]), "axis": np.array(["x", "y", "z"])}
    path = tmp_path / "trial.h5"
    write_trial(path, Trial(100.0, axes, signals, {"edge": 3}), "dummy", "a", {}, {"rate_hz": 100.0})
    return path


def read_storage(path):
    """Header and columns of a .mot or .sto file, by the rules of its format."""
    lines = path.read_text().splitlines()
    end = lines.index("endheader")
    header = dict(line.split("=") for line in lines[1:end])
    names = lines[end + 1].split("\t")
    values = np.array([line.split("\t") for line in lines[end + 2 :]], dtype=float)
    assert values.shape == (int(header["nRows"]), int(header["nColumns"]))
    assert names[0] == "time"
    assert header["version"] == "1"
    return lines[0], header["inDegrees"], dict(zip(names, values.T, strict=True))


# ---- MATLAB --------------------------------------------------------------------------------------


def test_fit_as_matlab_structures(fit, tmp_path):
    export_mat(read_stored(fit), tmp_path / "fit.mat")
    found = loadmat(tmp_path / "fit.mat", simplify_cells=True)
    stored = read_stored(fit)
    assert np.array_equal(found["leg"]["torque"], stored.arrays["leg/torque"])
    assert np.array_equal(found["leg_thesis"]["torque"], stored.arrays["leg-thesis/torque"])
    assert found["x10_Hz"]["response"] == 1.0 + 2.0j
    assert found["units"]["leg"]["torque"] == "Nm"
    assert found["units"]["time"] == "s"
    assert found["facts"]["theta_rest_rad"] == 0.02
    assert list(found["facts"]["pathways"]) == ["leg", "leg-thesis"]
    assert found["facts"]["spread"].tolist() == [1.0, 2.0]
    assert found["facts"]["fault"].size == 0


def test_trial_as_matlab_variables(trial, tmp_path):
    export_mat(read_stored(trial), tmp_path / "trial.mat")
    found = loadmat(tmp_path / "trial.mat", simplify_cells=True)
    assert np.array_equal(found["force"], read_stored(trial).values("force"))
    assert found["time"].tolist() == TIME.tolist()
    assert found["units"]["force"] == "N"
    assert list(found["belt"]) == ["left", "right"]
    assert list(found["axes"]["force"]) == ["time", "belt", "axis"]
    assert found["attributes"]["rate_hz"] == 100.0
    assert found["attributes"]["options"]["rate_hz"] == 100.0
    first = (tmp_path / "trial.mat").read_bytes()
    export_mat(read_stored(trial), tmp_path / "trial.mat")
    assert (tmp_path / "trial.mat").read_bytes() == first


def test_names_are_those_that_matlab_accepts():
    assert valid_name("leg-thesis") == "leg_thesis"
    assert valid_name("10 Hz") == "x10_Hz"
    assert valid_name("_a") == "x_a"
    assert valid_name("end") == "xend"
    assert valid_name("a b", ["a_b"]) == "a_b_2"
    assert valid_name("µ") == "x_"
    assert len(valid_name("a" * 99, ["a" * 63])) == 63


# ---- OpenSim -------------------------------------------------------------------------------------


def test_angle_and_torque_of_a_fit(fit, tmp_path):
    stored = read_stored(fit)
    write_storage(motion_of(stored, "fit"), tmp_path / "a.mot")
    name, in_degrees, columns = read_storage(tmp_path / "a.mot")
    assert (name, in_degrees) == ("fit", "yes")
    assert columns["time"].tolist() == TIME.tolist()
    assert columns["ankle_angle_r"] == pytest.approx(np.degrees(0.1 * np.sin(TIME) + 0.02))
    write_storage(
        torque_of(stored, "fit", pathway="leg-thesis", coordinate="ankle_angle_l"), tmp_path / "a.sto"
    )
    _, in_degrees, columns = read_storage(tmp_path / "a.sto")
    assert in_degrees == "no"
    assert columns["ankle_angle_l_moment"] == pytest.approx(0.7 * np.sin(TIME))


def test_ground_reactions_of_a_trial_in_opensims_axes(trial, tmp_path):
    stored = read_stored(trial)
    write_storage(motion_of(stored, "trial"), tmp_path / "a.mot")
    _, _, columns = read_storage(tmp_path / "a.mot")
    assert columns["ground_force_right_vx"] == pytest.approx(stored.values("force")[:, 1, 1])
    assert columns["ground_force_right_vy"] == pytest.approx(stored.values("force")[:, 1, 2])
    point = [columns[f"ground_force_right_p{axis}"] for axis in "xyz"]
    assert np.transpose(point) == pytest.approx(np.tile([0.25, 0.0, 0.1], (50, 1)))
    torque = [columns[f"ground_torque_right_{axis}"] for axis in "xyz"]
    assert np.transpose(torque) == pytest.approx(np.tile([0.0, 2.0, 0.0], (50, 1)), abs=1e-9)
    assert not any(columns[name].any() for name in columns if "left" in name)


@pytest.mark.slow
def test_command_writes_every_kind_and_refuses_what_it_cannot(fit, trial, tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    for arguments in (["fit.h5", "--to", "mat"], ["fit.h5", "--to", "sto", "--trial", "trial.h5"]):
        assert main(["export", *arguments]) == 0
    assert (tmp_path / "fit.mat").is_file()
    assert "ankle_angle_r_moment" in read_storage(tmp_path / "fit.sto")[2]
    (tmp_path / "other.h5").write_bytes(b"text")
    capsys.readouterr()
    for arguments, words in (
        (["trial.h5", "--to", "sto"], "expected a torque"),
        (["fit.h5", "--to", "mot", "--pathway", "foot"], "expected the pathway 'foot', found 'leg'"),
        (["fit.h5", "--to", "mot", "--trial", "fit.h5"], "expected a trial, found a result"),
        (["none.h5", "--to", "mat"], "found none"),
        (["other.h5", "--to", "mat"], "found another kind"),
        (["fit.h5", "--to", "mat", "--output", "fit.h5"], "a file of its own to write to"),
        (["fit.h5", "--to", "mat", "--output", "no/fit.mat"], "expected a folder that exists"),
    ):
        assert main(["export", *arguments]) == 2
        said = capsys.readouterr().err
        assert words in said
        assert said.count("\n") == 1


def test_result_without_time_needs_its_trial(fit, trial):
    with h5py.File(fit, "r+") as file:
        del file["time"]
    stored, on_plates = read_stored(fit), read_stored(trial)
    with pytest.raises(InputError, match="name its trial, too") as caught:
        torque_of(stored, "fit.h5")
    assert_one_sentence(caught.value, "fit.h5")
    assert torque_of(stored, "fit.h5", on_plates).time.tolist() == TIME.tolist()
