"""A study whose trial sheet names participants: what it plans, and its tables from estimates by hand."""

import csv

import pytest
from study_builders import jobs, snakemake, write_config

from tepsipe.io.estimates import ESTIMATES, Estimate
from workflow.support.trial_sheet import COLUMNS, OPTIONAL_COLUMNS

pytestmark = pytest.mark.study
ROW = dict.fromkeys(COLUMNS + OPTIONAL_COLUMNS, "-") | {"source": "recorded", "duration_s": "60"}
PLATE = ROW | {"calibration": "c.csv", "markers": "m.c3d"}


def write(project, name, rows, masses, **sections):
    # every trial has a recording of its own
    rows = [row | {"log": f"{row['experiment']}-{row['condition']}-{row['log']}"} for row in rows]
    lines = [list(ROW), *(list(row.values()) for row in rows)]
    (project / f"config/{name}.tsv").write_text("".join("\t".join(line) + "\n" for line in lines))
    table = "participant\tmass_kg\n" + "".join(f"{who}\t{mass}\n" for who, mass in masses.items())
    (project / f"config/{name}-participants.tsv").write_text(table)
    study = {"trial_sheet": f"config/{name}.tsv", "participants": f"config/{name}-participants.tsv"}
    content = {
        "study": study | {"virtual_lab": None, "reported": None},
        "pathvars": {"results": f"results/{name}", "logs": f"results/{name}/logs"},
    }
    write_config(project, content | sections, name)


def test_tasks_of_people_and_models_of_belts_are_jobs_of_their_own(project):
    standing = PLATE | {"experiment": "standing", "log": "s.mat"}
    rows = [
        standing | {"condition": f"{who}-{belt}-{k}", "participant": who, "task": "calm", "belt": belt}
        for who in ("P1", "P2")
        for belt in ("left", "right")
        for k in (1, 2)
    ]
    for experiment in ("weight", "empty"):
        rows += [
            (PLATE if experiment == "weight" else PLATE | {"markers": "-"})
            | {"experiment": experiment, "condition": f"{belt}-{role}", "role": role, "belt": belt}
            | {"log": f"{experiment}-{belt}-{role}.mat"}
            for belt in ("left", "right")
            for role in ("calibrate", "validate")
        ]
    write(project, "belts", rows, {"P1": 60, "P2": 80})
    run = snakemake(project, "-n", config="belts")
    planned = jobs(run)
    assert planned, run.stdout[-1500:] + run.stderr[-1500:]
    assert planned["fit_standing"] == planned["ingest_standing"] == 8
    # two people, two belts, one task
    assert planned["fit_standing_task"] == 4
    assert planned["calibrate_plate"] == 2
    assert planned["tabulate_participants"] == planned["plot_participants"] == 1


def test_tables_of_participants_follow_from_their_estimates(project):
    manipulator = ROW | {"experiment": "position_manipulator", "log": "none.csv"}
    stiffness = {
        "P1": {"rest-1": (40.0, 3.0), "rest-2": (44.0, 4.0), "push": (100.0, 2.0)},
        "P2": {"rest-1": (60.0, 2.0), "push": (160.0, 2.0)},
        "P3": {"rest-1": (51.0, 2.0), "push": (121.0, 2.0)},
    }
    rows = []
    for who, trials in stiffness.items():
        for trial, (value, error) in trials.items():
            condition = f"{who}-{trial}"
            # a name of its own in every row: nothing but the ingest depends on it
            named = {"participant": who, "task": trial.partition("-")[0], "angle_column": f"angle {who}"}
            rows.append(manipulator | {"condition": condition} | named)
            path = project / f"results/hand/estimates/position_manipulator/{condition}.csv"
            path.parent.mkdir(parents=True, exist_ok=True)
            about = ("position_manipulator", condition, "impedance", "parallel-cascade")
            ends = value - 2.0 * error, value + 2.0 * error
            ESTIMATES.write(path, [Estimate(*about, "K", "Nm/rad", value, error, *ends)])
    write(project, "hand", rows, {"P1": 60, "P2": 80, "P3": 70})
    tables, figure = "results/hand/tables", "results/hand/figures/figure_participants.svg"
    run = snakemake(project, f"{tables}/group.csv", figure, "--rerun-triggers", "mtime", config="hand")
    assert run.returncode == 0, run.stdout + run.stderr
    assert (project / figure).stat().st_size > 1000
    with open(project / tables / "group.csv", newline="") as file:
        group = {(row["condition"], row["quantity"]): row for row in csv.DictReader(file)}
    # P1 rests with (40 + 44) / 2 = 42; the mean over 42, 60 and 51 is 51, their SD 9
    rest = group["rest", "K"]
    assert (rest["n"], float(rest["mean"]), float(rest["sd"])) == ("3", 51.0, 9.0)
    # errors 2.5 (the mean of two trials), 2 and 2
    assert float(rest["u_within"]) == pytest.approx(((2.5**2 + 2.0**2 + 2.0**2) / 3.0) ** 0.5)
    # differences 58, 100 and 70: mean 76, SD sqrt(468); t = 4.303 with two degrees of freedom
    difference = group["rest minus push", "K"]
    assert float(difference["mean"]) == -76.0
    assert float(difference["sd"]) == pytest.approx(468.0**0.5)
    half = float(difference["ci_high"]) + 76.0
    assert half == pytest.approx(4.303 * (468.0 / 3.0) ** 0.5, rel=1e-4)
    # 100 / 60, 160 / 80 and 121 / 70 N·m/rad/kg
    per_kg = group["push", "K_per_kg"]
    assert float(per_kg["mean"]) == pytest.approx((100.0 / 60.0 + 2.0 + 121.0 / 70.0) / 3.0)
    assert per_kg["unit"] == "Nm/rad/kg"
    with open(project / tables / "estimates.csv", newline="") as file:
        estimates = list(csv.DictReader(file))
    assert list(estimates[0])[-1] == "participant"
    assert {row["condition"]: row["participant"] for row in estimates}["P1-rest-2"] == "P1"
    with open(project / tables / "participants.csv", newline="") as file:
        people = [
            row for row in csv.DictReader(file) if row["quantity"] == "K" and row["condition"] == "rest"
        ]
    assert [(row["participant"], row["n_trials"], float(row["mass_kg"])) for row in people] == [
        ("P1", "2", 60.0),
        ("P2", "1", 80.0),
        ("P3", "1", 70.0),
    ]
    assert people[0]["value"] == "42"
