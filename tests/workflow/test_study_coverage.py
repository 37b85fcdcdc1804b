"""A coverage study of two laboratories, by the real Snakefile: one has results, the other a bad recording."""

import csv
import json

import pytest
from study_builders import jobs, snakemake, write_config, write_sheet

pytestmark = pytest.mark.study
COVERED = {
    "study": {"name": "laboratory", "trial_sheet": "config/covered.tsv", "reported": None},
    "coverage": {
        "laboratories": 2,
        "seed": 1,
        "also_evaluated": [],
        # in the second laboratory markers are hidden most of the time
        "sets": {
            "assumed": {},
            "hidden": {
                "constants": {
                    "treadmill.capture.occlusions_per_minute": 400.0,
                    "treadmill.capture.occlusion_s": 0.4,
                }
            },
        },
    },
    "dummy": {"analysis": {"bootstrap_draws": 100}},
}


@pytest.fixture(scope="module")
def covered(project):
    write_sheet(project, ["dummy sine-0.5 virtual_lab sine 0.5 4 26 - - - -"], "covered")
    write_config(project, COVERED, "covered")
    run = snakemake(project, "results/tables/coverage.csv", config="covered")
    assert run.returncode == 0, run.stdout + run.stderr
    assert jobs(run) == {"run_laboratory": 2, "collect_coverage": 1}
    return project / "results"


def rows(results, name):
    with open(results / f"tables/{name}.csv", newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_a_laboratory_that_fails_is_a_row_with_its_sentence(covered):
    first, second = rows(covered, "laboratories")
    assert (first["set"], first["failed"]) == ("assumed", "")
    assert second["set"] == "hidden"
    assert second["failed"].startswith("ingest_dummy/sine-0.5: ") and "expected" in second["failed"]
    with open(covered / "laboratories/2/estimates.csv", encoding="utf-8") as file:
        assert len(file.readlines()) == 1


def test_rows_of_the_coverage_are_those_of_the_laboratory_with_results(covered):
    found = rows(covered, "coverage")
    assert {row["mechanism"] for row in found} == {"assumed"}
    quoted = {row["quantity"]: row for row in found if row["recommended"] == "true"}
    assert {"B", "K"} <= set(quoted)
    assert quoted["K"]["n"] == "1" and abs(float(quoted["K"]["bias_percent"])) < 10.0
    assert any(row["source"] == "leg_mass_kg" for row in rows(covered, "dropped"))
    assert {row["laboratory"] for row in rows(covered, "outcomes")} == {"1"}


def test_what_remains_of_a_laboratory_is_what_runs_it_again(covered):
    folder = covered / "laboratories/1"
    left = {path.relative_to(folder).as_posix() for path in folder.rglob("*") if path.is_file()}
    tables = {f"{name}.csv" for name in ("estimates", "uncertainty", "recovery")}
    files = {f"study/config/{name}" for name in ("config.yaml", "virtual_lab.yaml", "trials.tsv")}
    assert left == {"laboratory.json", *tables, *files}
    about = json.loads((folder / "laboratory.json").read_text(encoding="utf-8"))
    own = json.loads((folder / "study/config/virtual_lab.yaml").read_text(encoding="utf-8"))
    assert about == {"number": 1, "set": "assumed", "seed": own["seed"], "failed": ""}
