"""A study from an installation by pip alone: six C3Ds, from new-study to the page, without a network."""

import csv
import hashlib
import os
import shutil
import subprocess
import sys
import zipfile
from importlib.util import find_spec
from pathlib import Path

import pytest
import yaml
from laboratory_folders import c3d_with_plates_and_emg

import tepsipe

PACKAGE = Path(tepsipe.__file__).parent
pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(
        not ((PACKAGE / "_study").is_dir() and find_spec("snakemake")),
        reason="needs an installation from a wheel with the extra study: make wheel-test",
    ),
]


def without_network():
    """Beginning of a command that runs without a network, where the system allows it."""
    command = ["unshare", "--net"]
    allowed = shutil.which("unshare") and subprocess.run([*command, "true"], capture_output=True)
    return command if allowed and allowed.returncode == 0 else []


def digests(folder):
    """Path -> SHA-256 of the files of an installation but for Python's bytecode."""
    return {
        path.relative_to(folder): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in folder.rglob("*")
        if path.is_file() and "__pycache__" not in path.parts
    }


def answered(config, answers):
    """Settings with what a user fills in."""
    for key, value in answers.items():
        nested = isinstance(value, dict) and isinstance(config.get(key), dict)
        config[key] = answered(config[key], value) if nested else value
    return config


def test_six_c3ds_become_a_page(shipped_truth, tmp_path):
    recordings, study = tmp_path / "recordings", tmp_path / "my study"
    recordings.mkdir()
    answers, _ = c3d_with_plates_and_emg(recordings, shipped_truth)
    assert len(list(recordings.glob("*.c3d"))) == 6
    before = digests(PACKAGE)

    def run(*arguments, folder=study):
        environment = {key: x for key, x in os.environ.items() if not key.lower().endswith("_proxy")}
        command = [*without_network(), sys.executable, "-m", "tepsipe.cli", *arguments]
        return subprocess.run(command, cwd=folder, capture_output=True, text=True, env=environment)

    made = run("new-study", "recordings", "--output", study.name, folder=tmp_path)
    assert made.returncode == 0 and made.stdout.endswith("tepsipe run\n"), made.stdout + made.stderr
    settings = study / "config.yaml"
    settings.write_text(yaml.safe_dump(answered(yaml.safe_load(settings.read_text()), answers)))
    checked = run("check")
    assert checked.returncode == 0 and "6 trials" in checked.stdout, checked.stderr
    done = run("run", "-c1")
    assert done.returncode == 0, done.stdout + done.stderr
    page = study / "results/report/index.html"
    assert done.stdout.splitlines()[-1] == str(page) and "Function" in page.read_text(encoding="utf-8")
    with open(study / "results/tables/estimates.csv", encoding="utf-8") as table:
        rows = [row for row in csv.DictReader(table) if row["experiment"] == "standing"]
    assert len(rows) > 10
    wanted = {"condition": "relax", "quantity": "K", "recommended": "true"}
    quoted = next(row for row in rows if row.items() >= wanted.items())
    half = 50.0 * (float(quoted["ci_high"]) - float(quoted["ci_low"])) / float(quoted["value"])
    assert f"verdict: standing/relax: K will be quotable, ± {half:.2g} % expected" in checked.stdout
    again = run("run", "-n")
    assert "Nothing to be done" in again.stdout + again.stderr
    archived = run("archive", "--output", "../archive.zip")
    assert archived.returncode == 0, archived.stdout + archived.stderr
    with zipfile.ZipFile(tmp_path / "archive.zip") as bundle:
        assert len(bundle.read("recordings.sha256").splitlines()) == 6
        assert {"code/Snakefile", "results/tables/answers.csv"} <= set(bundle.namelist())
    assert digests(PACKAGE) == before
    required = study / "requirements.txt"
    required.write_text("tepsipe[study]==0.0.1\n")
    other = run("run", "-n")
    assert other.returncode == 2 and "pip install 'tepsipe[study]==0.0.1'" in other.stderr
    assert run("run", "-n", "--any-version").returncode == 0
