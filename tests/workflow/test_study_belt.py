"""A study of treadmill recordings, and of a person on a moving platform."""

import csv

import numpy as np
import pytest
from belt_builders import belt_table
from report_readers import faults_of_study
from study_builders import snakemake, write_config, write_sheet

from tepsipe.virtual_lab.platform_person import PlatformPerson, PlatformProtocol, record_platform

pytestmark = pytest.mark.study


def platform_table(path):
    """Two minutes of a person on a moving platform as a table, 50 Hz."""
    quiet = PlatformPerson(own_torque_Nm=(4.0, 2.0))
    record = record_platform(quiet, PlatformProtocol(duration_s=120.0), np.random.default_rng(1))
    table = np.column_stack([record.time, record.platform, record.angle, record.torque])
    header = "time_s,platform_m,ankle_angle_rad,hip_angle_rad,ankle_torque_Nm,hip_torque_Nm"
    np.savetxt(path, table, delimiter=",", header=header, comments="", fmt="%.9g")


def treadmill_study(project, name, recordings, further=()):
    """Run a study of treadmill recordings, condition -> (role, file), and of further rows of the sheet."""
    rows = [
        "\t".join(["belt", condition, "recorded", "-", "-", "-", "39", str(file), "-", "-", "-", role])
        + "\t-\t-\tt\tMx (Nm)\tv (m/s)"
        for condition, (role, file) in recordings.items()
    ]
    write_sheet(project, [*rows, *further], name)
    content = {
        "study": {
            "title": "A treadmill",
            "trial_sheet": f"config/{name}.tsv",
            "virtual_lab": None,
            "reported": None,
        },
        "pathvars": {"results": f"results/{name}", "logs": f"results/{name}/logs"},
        "belt": {"analysis": {"cutoffs_hz": [6, 20]}},
    }
    write_config(project, content, name)
    run = snakemake(project, config=name)
    assert "Traceback" not in run.stdout + run.stderr
    return run


@pytest.fixture(scope="session")
def tables(tmp_path_factory):
    folder = tmp_path_factory.mktemp("tables")
    for seed, name in enumerate(("first", "second")):
        belt_table(folder / f"{name}.txt", seed)
    belt_table(folder / "turned.txt", 2, sign=-1.0)
    belt_table(folder / "still.txt", 3, still=True)
    platform_table(folder / "person.csv")
    return folder


def test_a_newcomer_calibrates_a_treadmill_from_two_text_files(project, tables):
    recordings = {"a": ("calibrate", tables / "first.txt"), "b": ("validate", tables / "second.txt")}
    person = tables / "person.csv"
    further = ["\t".join(["platform", "quiet", "recorded", *"---", "119", str(person), *"---", *"------"])]
    run = treadmill_study(project, "own-treadmill", recordings, further)
    assert run.returncode == 0, run.stdout + run.stderr
    with open(project / "results/own-treadmill/tables/estimates.csv", newline="") as file:
        found = {(row["estimator"], row["quantity"]): row for row in csv.DictReader(file)}
    assert float(found["iv-intrinsic", "K_ankle_ankle"]["value"]) == pytest.approx(1000.0, rel=0.15)
    assert found["iv-all-reflex", "K_hip_ankle"]["value"] == ""
    with open(project / "results/own-treadmill/tables/treadmill_models.csv", newline="") as file:
        rows = {(row["model"], row["cutoff_hz"]): row for row in csv.DictReader(file)}
    assert float(rows["fir", "6"]["r2"]) > 0.9
    assert {row["train"] for row in rows.values()} == {"a"}
    assert {row["test"] for row in rows.values()} == {"b"}
    assert (project / "results/own-treadmill/report/thesis.pdf").stat().st_size > 20_000
    page = (project / "results/own-treadmill/report/index.html").read_text(encoding="utf-8")
    assert "quiet: a second, independent perturbation" in page
    assert faults_of_study(project / "results/own-treadmill") == []


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
