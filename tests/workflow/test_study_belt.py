"""A study of treadmill recordings, and of a person on a moving platform."""

import csv

import pytest
from belt_builders import belt_table
from report_readers import faults_of_study
from study_builders import treadmill_study

pytestmark = pytest.mark.study


@pytest.fixture(scope="session")
def tables(tmp_path_factory):
    folder = tmp_path_factory.mktemp("tables")
    for seed, name in enumerate(("first", "second")):
        belt_table(folder / f"{name}.txt", seed)
    belt_table(folder / "turned.txt", 2, sign=-1.0)
    belt_table(folder / "still.txt", 3, still=True)
    return folder


def test_a_newcomer_calibrates_a_treadmill_from_two_text_files(belt_study):
    results = belt_study / "results/belt"
    with open(results / "tables/estimates.csv", newline="") as file:
        found = {(row["estimator"], row["quantity"]): row for row in csv.DictReader(file)}
    assert float(found["iv-intrinsic", "K_ankle_ankle"]["value"]) == pytest.approx(1000.0, rel=0.15)
    assert found["iv-all-reflex", "K_hip_ankle"]["value"] == ""
    with open(results / "tables/treadmill_models.csv", newline="") as file:
        rows = {(row["model"], row["cutoff_hz"]): row for row in csv.DictReader(file)}
    assert float(rows["fir", "6"]["r2"]) > 0.9
    assert {row["train"] for row in rows.values()} == {"a"}
    assert {row["test"] for row in rows.values()} == {"b"}
    assert (results / "report/belt.pdf").stat().st_size > 20_000
    page = (results / "report/index.html").read_text(encoding="utf-8")
    assert "quiet: a second, independent perturbation" in page
    assert faults_of_study(results) == []


@pytest.mark.parametrize(
    ("name", "calibrate", "validate", "words"),
    [
        ("turned", "first", "turned", "found it with the opposite sign"),
        ("still", "first", "still", "found 1.2 throughout"),
        ("uncalibrated", None, "second", "with the role calibrate, found none"),
    ],
)
def test_recordings_that_cannot_calibrate_a_treadmill_get_one_sentence(
    project, tables, name, calibrate, validate, words
):
    recordings = {"b": ("validate", tables / f"{validate}.txt")}
    if calibrate:
        recordings["a"] = ("calibrate", tables / f"{calibrate}.txt")
    run = treadmill_study(project, name, recordings)
    assert run.returncode != 0
    said = [line for line in (run.stdout + run.stderr).splitlines() if line.startswith("tepsipe: ")]
    assert len(said) == 1
    assert words in said[0]
