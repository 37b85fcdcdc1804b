"""The archive of a study: its files, its provenance, and a run in the unpacked folder."""

import hashlib
import json
import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path
from types import SimpleNamespace
from urllib.parse import unquote

import pytest
import yaml
from study_builders import ROOT, warm_process

from tepsipe import __version__
from tepsipe.cli import main
from tepsipe.errors import InputError
from workflow.archive import place_of_recording

pytestmark = pytest.mark.study


def archive(project, *arguments):
    """What the command does in a study, in a fork of the process that runs Snakemake."""
    return warm_process().run(arguments, project, "workflow.archive")


def unpacked(file, folder):
    with zipfile.ZipFile(file) as bundle:
        bundle.extractall(folder)
    return folder


def graph_of(folder):
    content = json.loads((folder / "ro-crate-metadata.json").read_text(encoding="utf-8"))
    entities = {entity["@id"]: entity for entity in content["@graph"]}
    assert len(entities) == len(content["@graph"])
    return entities


def named(value):
    """References in the values of an entity."""
    found = value if isinstance(value, list) else [value]
    return [one["@id"] for one in found if isinstance(one, dict)]


def check_graph(folder):
    """References lead to entities, files are those of the folder, and every result has one job."""
    entities = graph_of(folder)
    for entity in entities.values():
        for key, value in entity.items():
            if key not in ("conformsTo", "identifier"):
                assert set(named(value)) <= entities.keys(), entity["@id"]
    files = {unquote(name): entity for name, entity in entities.items() if "File" in entity["@type"]}
    there = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    assert files.keys() == there - {"ro-crate-metadata.json"}
    for name, entity in files.items():
        data = (folder / name).read_bytes()
        assert entity["sha256"] == hashlib.sha256(data).hexdigest(), name
        assert entity["contentSize"] == str(len(data))
    jobs = [entity for name, entity in entities.items() if name.startswith("#job/")]
    made = [name for job in jobs for name in named(job["result"])]
    assert len(made) == len(set(made))
    results = {name for name in entities if name.startswith("results/") and "/logs/" not in name}
    assert results <= set(made)
    for job in jobs:
        assert job["startTime"] <= job["endTime"]
    return entities, jobs


@pytest.fixture(scope="module")
def tiny(study, tmp_path_factory):
    """The tiny study's bundle, unpacked, and what the command printed."""
    folder = tmp_path_factory.mktemp("archive")
    command = [sys.executable, "-P", "-m", "workflow.archive", "config/tiny.yaml", f"--output={folder}/a.zip"]
    done = subprocess.run(
        [*command, "--agent=Ada Lovelace"],
        **{
            "cwd": study,
            "capture_output": True,
            "text": True,
            "env": os.environ | {"PYTHONPATH": str(study)},
        },
    )
    assert done.returncode == 0, done.stderr
    assert done.stdout.endswith(f"files\nwritten: {folder}/a.zip\n")
    return unpacked(folder / "a.zip", folder / "b")


def test_every_result_names_the_job_that_made_it_with_its_inputs(tiny, study):
    entities, jobs = check_graph(tiny)
    assert len(jobs) == len(list((study / ".snakemake/tepsipe/made").glob("*.json")))
    (job,) = [job for job in jobs if "results/tables/table_4_1.csv" in named(job["result"])]
    assert entities[named(job["instrument"])[0]]["name"] == "lay_out_table_4_1" or "table" in job["name"]
    assert named(job["object"]) and named(job["agent"]) == ["#agent"]
    fit = entities["#results/fits/dummy/sine-0.5.h5"]
    data = (study / "results/fits/dummy/sine-0.5.h5").read_bytes()
    assert fit["sha256"] == hashlib.sha256(data).hexdigest() and fit["@type"] == "CreativeWork"
    profiles = named(entities["./"]["conformsTo"])
    assert "https://w3id.org/ro/wfrun/provenance/0.5" in profiles
    workflow = entities[named(entities["./"]["mainEntity"])[0]]
    assert "ComputationalWorkflow" in workflow["@type"]
    rules = {entities[name]["name"] for name in named(workflow["step"])}
    assert {"ingest_dummy", "fit_dummy", "write_report"} <= rules
    script = entities["#rule/fit_dummy"]["hasPart"]["@id"]
    assert (tiny / script).name == "fit.py"


def test_the_unpacked_study_runs_to_the_same_numbers(tiny):
    required = (tiny / "requirements.txt").read_text(encoding="utf-8").splitlines()
    assert required[1].split(" #")[0] == f"tepsipe[study]=={__version__}"
    assert any(line.startswith("numpy==") for line in required)
    table = tiny / "results/tables/table_4_1.csv"
    before, time = table.read_bytes(), table.stat().st_mtime_ns
    command = [sys.executable, "-m", "tepsipe.cli", "run", "-c2", "results/tables/table_4_1.csv"]
    done = subprocess.run(
        command, cwd=tiny, capture_output=True, text=True, env=os.environ | {"PYTHONPATH": str(ROOT)}
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert table.read_bytes() == before and table.stat().st_mtime_ns > time


@pytest.fixture(scope="module")
def belt(belt_study, tmp_path_factory):
    """A copy of the study of text files, to change."""
    return Path(shutil.copytree(belt_study, tmp_path_factory.mktemp("belt") / "project"))


def test_recordings_are_named_by_their_contents_or_packed(belt, tmp_path):
    done = archive(belt, "config/belt.yaml", f"--output={tmp_path}/a.zip")
    assert done.returncode == 0 and "without the recordings" in done.stdout, done.stderr
    folder = unpacked(tmp_path / "a.zip", tmp_path / "a")
    entities, jobs = check_graph(folder)
    (job,) = [job for job in jobs if "#results/trials/belt/a.h5" in named(job["result"])]
    assert "#recordings/first%20run.txt" in named(job["object"])
    digest = hashlib.sha256((belt / "of the belt/first run.txt").read_bytes()).hexdigest()
    assert entities["#recordings/first%20run.txt"]["sha256"] == digest
    assert f"{digest}  recordings/first run.txt" in (folder / "recordings.sha256").read_text()
    config = yaml.safe_load((folder / "config.yaml").read_text(encoding="utf-8"))
    assert config["study"]["recordings_folder"] == "recordings"
    assert config["pathvars"]["results"] == "results" and config["belt"]["analysis"]["cutoffs_hz"] == [6, 20]
    assert not (folder / "recordings").exists()
    done = archive(
        belt, "config/belt.yaml", f"--output={tmp_path}/b.zip", "--with-recordings", "--licence=CC0-1.0"
    )
    assert done.returncode == 0 and "without" not in done.stdout, done.stderr
    folder = unpacked(tmp_path / "b.zip", tmp_path / "b")
    entities, _ = check_graph(folder)
    assert entities["recordings/first%20run.txt"]["sha256"] == digest
    assert entities[entities["./"]["license"]["@id"]]["name"] == "CC0-1.0"


def test_an_archive_overwrites_nothing_and_needs_a_finished_study(belt, tmp_path):
    def refused(*arguments):
        done = archive(belt, "config/belt.yaml", *arguments)
        assert done.returncode == 2 and done.stderr.count("\n") == 1, done.stdout + done.stderr
        return done.stderr

    (tmp_path / "a.zip").touch()
    said = refused(f"--output={tmp_path}/a.zip")
    assert f"{tmp_path}/a.zip: expected the name of a new file" in said and "found a file" in said
    assert "found no folder for it" in refused(f"--output={tmp_path}/none/a.zip")
    records = belt / ".snakemake/metadata"
    records.rename(belt / "records")
    try:
        said = refused()
    finally:
        (belt / "records").rename(records)
    assert "expected" in said and "tepsipe run" in said
    table = belt / "results/belt/tables/treadmill_models.csv"
    kept = table.read_bytes()
    table.unlink()
    said = refused()
    assert "results/belt/" in said and "expected the results of a finished study, found" in said
    assert not (belt / "belt.zip").exists()
    table.write_bytes(kept + b"\n")
    assert "found it edited since then" in refused()


def test_recordings_outside_of_their_folder_are_refused():
    study = SimpleNamespace(config={"study": {"trial_sheet": "trials.tsv", "recordings_folder": "r"}})
    assert place_of_recording("r/a/b.c3d", study) == "recordings/a/b.c3d"
    for path in ("s/b.c3d", "r/../b.c3d"):
        with pytest.raises(
            InputError, match=r"^trials\.tsv: expected recordings in study\.recordings_folder"
        ):
            place_of_recording(path, study)


def test_the_command_hands_its_options_on(monkeypatch, tmp_path, capsys):
    monkeypatch.setattr("tepsipe.new_study.start.find_spec", lambda name: name)
    (tmp_path / "workflow").mkdir()
    (tmp_path / "workflow/check.py").touch()
    (tmp_path / "workflow/archive.py").write_text("import sys; print(*sys.argv[1:])")
    monkeypatch.chdir(tmp_path)
    assert main(["archive", "a.yaml", "--output", "b.zip", "--agent", "A B", "--with-recordings"]) == 0
    assert capsys.readouterr().out == "--output=b.zip --agent=A B --with-recordings a.yaml\n"
