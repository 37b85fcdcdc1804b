"""The whole way of a newcomer: one C3D of their own, new-study, what MISSING.md asks for, results."""

import hashlib
import re

import pytest
import yaml
from c3d_builders import single_c3d
from study_builders import ROOT, copy_project, estimates, value, warm_process

from tepsipe.cli import main

pytestmark = pytest.mark.study


def test_from_a_c3d_to_estimates(dummy_files, true_joint, tmp_path, monkeypatch, capsys):
    project = copy_project(tmp_path / "project")
    monkeypatch.chdir(project)
    (project / "recordings/mine").mkdir(parents=True)
    recording = single_c3d(dummy_files, project / "recordings/mine/dummy 1.c3d")
    before = hashlib.sha256(recording.read_bytes()).hexdigest()
    mine = tmp_path / "my {study} & $(touch x) ü"  # anywhere, of any name
    assert main(["new-study", "recordings/mine", "--output", str(mine)]) == 0
    assert f"fill in what {mine}/MISSING.md lists (items: 7)" in capsys.readouterr().out

    monkeypatch.chdir(mine)
    assert main(["check"]) == 2
    said = capsys.readouterr().err
    assert "config.yaml: expected a value for 'dummy.ingest.marker_sampling_hz'" in said
    assert said.count("\n") == 1

    # the same dummy as that of the example in the documentation
    page = (ROOT / "docs/recordings/plate-treadmill.md").read_text(encoding="utf-8")
    measured = re.search(r"<<'END'\n(dummy:.*?)\nEND", page, re.DOTALL)[1]
    asked = (mine / "MISSING.md").read_text().partition("## Assumed")[0]
    for section in yaml.safe_load(measured)["dummy"].values():
        assert all(f".{key}`" in asked for key in section)
    (mine / "measured.yaml").write_text(measured)
    files = ["config.yaml", "measured.yaml"]
    assert main(["check", *files]) == 0

    run = warm_process().run(["-c1", "results/tables/estimates.csv", "--configfile", *files], mine)
    assert run.returncode == 0, run.stdout + run.stderr
    rows = estimates(mine)
    assert not (project / "results").exists() and not list(tmp_path.rglob("x"))
    found = value(rows, condition="dummy-1", pathway="leg", quantity="K")
    assert found == pytest.approx(true_joint["K"], rel=0.02)
    assert hashlib.sha256(recording.read_bytes()).hexdigest() == before
    assert [p.name for p in (project / "recordings/mine").iterdir()] == ["dummy 1.c3d"]
