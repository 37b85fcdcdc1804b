"""A study of treadmill recordings."""

import csv

import numpy as np
import pytest
from study_builders import snakemake, write_config, write_sheet

pytestmark = pytest.mark.study


def belt_table(path, seed, sign=1.0, still=False):
    """A treadmill's load (Nm) and belt velocity (m/s) as its log has them, 40 s at 100 Hz."""
    rng = np.random.default_rng(seed)
    time = np.arange(4000) / 100.0
    velocity = 1.2 + 0.1 * np.convolve(rng.standard_normal(4000), np.hanning(40) / 4.5, "same")
    load = sign * (5.0 * np.gradient(velocity, 0.01) + 0.3 * rng.standard_normal(4000))
    table = np.column_stack([time, load, np.full(4000, 1.2) if still else velocity])
    np.savetxt(path, table, delimiter="\t", header="t\tMx (Nm)\tv (m/s)", comments="", fmt="%.6g")


def treadmill_study(project, name, recordings):
    """Run a study of treadmill recordings: condition -> (role, file)."""
    rows = [
        "\t".join(["belt", condition, "recorded", "-", "-", "-", "39", str(file), "-", "-", "-", role])
        + "\t-\t-\tt\tMx (Nm)\tv (m/s)"
        for condition, (role, file) in recordings.items()
    ]
    write_sheet(project, rows, name)
    content = {
        "study": {"trial_sheet": f"config/{name}.tsv", "virtual_lab": None, "reported": None},
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
    return folder


def test_a_newcomer_calibrates_a_treadmill_from_two_text_files(project, tables):
    recordings = {"a": ("calibrate", tables / "first.txt"), "b": ("validate", tables / "second.txt")}
    run = treadmill_study(project, "own-treadmill", recordings)
    assert run.returncode == 0, run.stdout + run.stderr
    with open(project / "results/own-treadmill/tables/treadmill_models.csv", newline="") as file:
        rows = {(row["model"], row["cutoff_hz"]): row for row in csv.DictReader(file)}
    assert float(rows["fir", "6"]["r2"]) > 0.9
    assert {row["train"] for row in rows.values()} == {"a"}
    assert {row["test"] for row in rows.values()} == {"b"}
    assert (project / "results/own-treadmill/report/thesis.pdf").stat().st_size > 20_000


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
