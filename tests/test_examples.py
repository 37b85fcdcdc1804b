"""The examples run as the README says, and print what they promise."""

import os
import re
import runpy
import subprocess
import sys

import pytest

from tepsipe.ingest.plate_treadmill import ingest_treadmill_files
from tepsipe.ingest.treadmill_options import TreadmillOptions
from tepsipe.ingest.whole_trial import read_recording_files
from tepsipe.io.trial import write_trial

pytestmark = pytest.mark.slow


@pytest.fixture
def run(root, tmp_path, monkeypatch, capsys):
    """Output of an example that runs in a folder of its own; its figures must be there afterwards.

    It runs in this process, where the packages are imported already.
    """
    import matplotlib

    matplotlib.use("Agg")
    monkeypatch.chdir(tmp_path)

    def output(name, *arguments):
        file = str(root / "examples" / f"{name}.py")
        monkeypatch.setattr(sys, "argv", [file, *map(str, arguments)])
        runpy.run_path(file, run_name="__main__")
        assert list(tmp_path.glob("*.png")), "no figure was written"
        return capsys.readouterr().out

    return output


def stiffness(text):
    """Estimate and interval (N·m/rad) of every K that a summary prints."""
    rows = re.findall(r"^K +([-\d.]+) +\S+ +\[([-\d.]+), ([-\d.]+)\]", text, re.MULTILINE)
    return [tuple(map(float, row)) for row in rows]


def test_own_arrays(root, tmp_path):
    environment = os.environ | {"MPLBACKEND": "Agg", "PYTHONPATH": str(root)}
    command = [sys.executable, str(root / "examples/own_arrays.py")]
    done = subprocess.run(command, cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert list(tmp_path.glob("*.png")), "no figure was written"
    ((value, low, high),) = stiffness(done.stdout)
    assert value == pytest.approx(10.0, rel=0.03)
    assert low < value < high
    assert "K," in (tmp_path / "own_arrays.csv").read_text()


def test_readme_prints_what_it_shows(root, tmp_path, monkeypatch, capsys):
    text = (root / "README.md").read_text(encoding="utf-8")
    (code,) = [
        block for block in re.findall(r"```python\n(.*?)```", text, re.DOTALL) if "load_example" in block
    ]
    shown = re.findall(r"^ *(\w = .* in truth)$", text, re.MULTILINE)
    monkeypatch.chdir(tmp_path)
    exec(compile(code, "README.md", "exec"), {})
    printed = capsys.readouterr().out
    assert len(shown) == 3
    assert all(line in printed for line in shown)


def test_human_joint(run):
    text = run("human_joint")
    ((value, _, _),) = stiffness(text)
    assert value == pytest.approx(80.0, rel=0.03)
    gain = float(re.search(r"^reflex_gain +([\d.]+)", text, re.MULTILINE).group(1))
    assert gain == pytest.approx(5.0, rel=0.1)


def test_study_trial(run, tmp_path, dummy_files, shipped_config, true_joint, short_truth):
    options = TreadmillOptions(**shipped_config["dummy"]["ingest"], resample_rate_hz=250.0)
    labels = shipped_config["dummy"]["files"]["marker_labels"]
    trial = ingest_treadmill_files(dummy_files, labels, options, 12.0)
    write_trial(tmp_path / "trial.h5", trial, "dummy", "sine-0.5", dummy_files, vars(options))
    thesis, consistent, output_error = stiffness(run("study_trial", tmp_path / "trial.h5"))
    # windows hold the stiffness of the working amplitude, output error that of small bending
    assert thesis[0] == pytest.approx(true_joint["K"] - 2.0 * 0.4 * 9.81 * 0.4485, rel=0.02)
    assert consistent[0] == pytest.approx(true_joint["K"], rel=0.02)
    small = short_truth["dummy"]["rubber"]["stiffness_Nm_per_rad"]
    assert output_error[0] == pytest.approx(small, rel=0.03)
    assert thesis[0] < consistent[0] < 0.95 * small


def test_simulate_and_estimate(run):
    found = stiffness(run("simulate_and_estimate"))
    assert len(found) == 3
    assert found[0][0] == pytest.approx(10.0, rel=0.005)
    assert found[1][1] - 0.1 < 10.0 < found[1][2] + 0.1


def test_trial_as_text(run, dummy_files, tmp_path):
    options = TreadmillOptions(250.0, 0.1, 2500.0, 2.5)
    labels = ["foot1", "foot2", "foot3", "ankle", "leg1", "leg2", "leg3", "leg4"]
    trial = ingest_treadmill_files(dummy_files, labels, options, 12.0)
    write_trial(tmp_path / "trial.h5", trial, "dummy", "a", {}, {})
    (tmp_path / "none.png").touch()  # this example draws nothing
    run("trial_as_text", "trial.h5", "dflow", "table")
    for log, markers in (
        ("dflow/Record0001.txt", "dflow/Mocap0001.txt"),
        ("table/trial.csv", "table/trial.trc"),
    ):
        files = {"log": str(tmp_path / log), "markers": str(tmp_path / markers)}
        found = read_recording_files(files, ("foot1", "foot2"))
        assert found.markers.labels == tuple(labels)
        assert found.markers.positions.shape[0] > 0.99 * trial.time.size
        assert len(found.plates) == 2
