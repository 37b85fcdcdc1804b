"""A tiny study, run by the real Snakefile in a copy of the project."""

import csv
import hashlib
import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

import edfio
import ezc3d
import h5py
import numpy as np
import pytest
import yaml
from scipy.io import loadmat, savemat
from sharing import made_once

from tepsipe.mechanics.engines import engine_version, resolved_engine
from workflow.support.trial_sheet import COLUMNS, OPTIONAL_COLUMNS

ROOT = Path(__file__).parents[1]
TRIALS = [
    "wristalyzer 0.12 virtual_lab multisine 0.12 - 40 - - - -",
    "wristalyzer 0.16 virtual_lab multisine 0.16 - 40 - - - -",
    "dummy sine-0.5 virtual_lab sine 0.5 4 46 - - - -",
    "dummy minjerk-0.5 virtual_lab minjerk 0.5 4 46 - - - -",
    "weight sine-0.4 virtual_lab sine 0.4 4 28 - - - - calibrate",
    "weight minjerk-0.4 virtual_lab minjerk 0.4 4 28 - - - - validate",
    "empty sine-0.4 virtual_lab sine 0.4 4 28 - - - - calibrate",
    "empty minjerk-0.4 virtual_lab minjerk 0.4 4 28 - - - - validate",
    "standing relax-neg-0.5 virtual_lab negative-sine 0.5 4-4.5 41 - - - - - - relax",
    "standing stiff-pos-0.5 virtual_lab sine 0.5 4-4.5 41 - - - - - - stiff",
]
OVERRIDES = {
    "study": {"trial_sheet": "config/tiny.tsv"},
    "wristalyzer": {"analysis": {"random_starts": 3, "profile_points": 29}},
    "dummy": {"analysis": {"bootstrap_draws": 300}},
    "noise": {"snr_db": [20], "draws": 10, "predicted_draws": 2},
    "weight": {"models": {"shortest_s": 0.5, "fir_lag_s": 0.04}},
}
FIGURES = ("2_4", "2_9", "3_1", "3_3", *(f"4_{k}" for k in range(1, 15)), "5_1", "b_1", "b_2", "b_13")
PEOPLE = ("relax-neg-0.5", "stiff-pos-0.5")
# one process runs all of this file, because most of its tests change the study that they share
pytestmark = pytest.mark.study


def write_sheet(project, rows, name="tiny"):
    cells = [row.split("\t") if "\t" in row else row.split() for row in rows]
    header = [*COLUMNS, *OPTIONAL_COLUMNS][: max(map(len, cells))]
    lines = [header, *[row + ["-"] * (len(header) - len(row)) for row in cells]]
    (project / f"config/{name}.tsv").write_text("".join("\t".join(line) + "\n" for line in lines))


def write_config(project, content, name="tiny"):
    (project / f"config/{name}.yaml").write_text(yaml.safe_dump(content))


def copy_project(target):
    for name in ("Snakefile", "config", "workflow", "tepsipe", "report", "profiles", "requirements.txt"):
        source = ROOT / name
        if source.is_dir():
            shutil.copytree(source, target / name, ignore=shutil.ignore_patterns("__pycache__"))
        else:
            target.mkdir(parents=True, exist_ok=True)
            shutil.copy(source, target / name)
    settings = target / "config/config.yaml"  # PyBullet where it is installed, and elsewhere what is there
    settings.write_text(settings.read_text().replace("    engine: pybullet", "    engine: auto"))
    write_sheet(target, TRIALS)
    write_config(target, OVERRIDES)
    return target


def snakemake(project, *arguments, cores=2, config="tiny"):
    command = [sys.executable, "-m", "snakemake", f"-c{cores}", *arguments]
    command += ["--configfile", f"config/{config}.yaml"]
    return subprocess.run(command, cwd=project, capture_output=True, text=True)


def jobs(run):
    """Rule -> number of jobs in the statistics that Snakemake prints."""
    table = re.search(r"-{3,}\s+-{3,}\n(.*?)\n\n", run.stdout + run.stderr, re.DOTALL)
    rows = [line.split() for line in table.group(1).splitlines()] if table else []
    return {name: int(count) for name, count in rows if name != "total"}


def estimates(project, results="results"):
    with open(project / results / "tables/estimates.csv", newline="") as file:
        return list(csv.DictReader(file))


def table(project, name):
    with open(project / f"results/tables/{name}.csv", newline="") as file:
        return list(csv.DictReader(file))


def value(rows, **wanted):
    (row,) = [row for row in rows if all(row[key] == cell for key, cell in wanted.items())]
    return float(row["value"])


def digests(folder):
    return {
        path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for name in ("tables", "figures", "estimates", "trials", "raw")
        for path in sorted((folder / name).rglob("*"))
        if path.is_file()
    } | {"pdf": hashlib.sha256((folder / "report/thesis.pdf").read_bytes()).hexdigest()}


@pytest.fixture(scope="session")
def study(tmp_path_factory):
    def make(folder):
        project = copy_project(folder / "project")
        run = snakemake(project)
        assert run.returncode == 0, run.stdout + run.stderr
        (folder / "digests.json").write_text(json.dumps(digests(project / "results")))

    return made_once(tmp_path_factory, "study", make) / "project"


def test_the_study_writes_every_output_of_its_contract(study):
    results = study / "results"
    for name in (
        "report/thesis.pdf",
        "report/report.html",
        "provenance.json",
        "tables/estimates.csv",
        "tables/table_4_1.csv",
        "tables/table_4_2.csv",
        "tables/table_4_3.csv",
        "tables/table_4_4.csv",
        "tables/forward.csv",
        "tables/noise.csv",
        "tables/specification.csv",
        "tables/recovery.csv",
        "tables/claims.csv",
        "tables/treadmill_models.csv",
        *[f"figures/figure_{number}.{kind}" for number in FIGURES for kind in ("svg", "png")],
        *[
            f"figures/standing/{condition}_{figure}.png"
            for condition in PEOPLE
            for figure in ("4_13", "4_14")
        ],
    ):
        assert (results / name).stat().st_size > 200, name
    assert (results / "report/thesis.pdf").read_bytes().startswith(b"%PDF")
    columns = (
        "experiment condition pathway estimator quantity unit value standard_error ci_low ci_high "
        "sem_as_printed n_perturbations"
    )
    assert list(estimates(study)[0]) == columns.split()


def test_provenance_record_and_report_name_the_engine_that_ran(study):
    engine = json.loads((study / "results/provenance.json").read_text())["engine"]
    name = resolved_engine("auto")
    assert engine == {"name": name, "version": engine_version(name)}
    facts = json.loads((study / "results/report/report.json").read_text())["provenance"]["facts"]
    assert ["Engine of the simulations", f"{name} {engine['version']}"] in facts


def test_a_trial_file_describes_itself(study):
    with h5py.File(study / "results/trials/dummy/sine-0.5.h5") as trial:
        assert trial.attrs["experiment"] == "dummy"
        sources = json.loads(trial.attrs["sources"])
        raw = study / sources["log"]["file"]
        assert sources["log"]["sha256"] == hashlib.sha256(raw.read_bytes()).hexdigest()
        for name in ("marker_position", "force", "moment", "belt_velocity"):
            assert trial[name].attrs["units"]
            assert trial[name].dims[0].keys() == ["time"]
        assert trial["marker_position"].dims[1].keys() == ["marker"]
        assert np.isclose(np.diff(trial["time"][:]), 1.0 / 250.0).all()


def test_the_recommended_pathway_recovers_the_truth_and_the_printed_one_its_prediction(study):
    rows = estimates(study)
    for condition in ("sine-0.5", "minjerk-0.5"):
        of = {"experiment": "dummy", "condition": condition}
        assert value(rows, **of, pathway="leg", quantity="K") == pytest.approx(10.0, rel=0.05)
        assert value(rows, **of, pathway="leg", quantity="B") == pytest.approx(0.1, rel=0.3)
        assert value(rows, **of, pathway="leg", quantity="I") == pytest.approx(0.0, abs=0.001)
        printed = 10.0 - 2.0 * 0.4 * 9.81 * 0.4485
        assert value(rows, **of, pathway="leg-thesis", quantity="K") == pytest.approx(printed, rel=0.1)
        assert value(rows, **of, pathway="leg-thesis", quantity="I") == pytest.approx(0.054, rel=0.03)
        assert value(rows, **of, pathway="leg-thesis", quantity="VAF_perturbation") > 99.8


def test_the_treadmill_taken_out_of_the_force_leaves_the_joint(study):
    rows = estimates(study)
    for condition in ("sine-0.5", "minjerk-0.5"):
        of = {"experiment": "dummy", "condition": condition, "quantity": "K"}
        assert abs(value(rows, **of, pathway="foot") - 10.0) > 5.0
        assert value(rows, **of, pathway="foot-compensated") == pytest.approx(10.0, rel=0.2)
    mass = value(rows, experiment="weight", condition="minjerk-0.4", quantity="mass")
    assert mass == pytest.approx(20.0, abs=0.8)


def test_a_standing_persons_ankles_and_latencies_are_recovered(study):
    rows = [row for row in table(study, "recovery") if row["experiment"] == "standing"]
    for task in ("relax", "stiff"):
        (own,) = [
            row
            for row in rows
            if (row["condition"], row["pathway"], row["estimator"], row["quantity"])
            == (task, "ankle-compensated", "pre-reflex-window", "K")
        ]
        assert abs(float(own["relative_error"])) < 0.15
        assert own["covered"] == "true"
    # seven responses of one trial only, where the study has about 35 of four
    late = [
        float(row["value"]) - float(row["truth"]) for row in rows if row["quantity"].startswith("latency")
    ]
    assert len(late) > 8
    assert np.median(np.abs(late)) < 0.005
    stiffness = {
        row["condition"]: float(row["value"])
        for row in estimates(study)
        if (row["pathway"], row["estimator"], row["quantity"])
        == ("ankle-compensated", "pre-reflex-window", "K")
    }
    assert stiffness["stiff"] > 1.3 * stiffness["relax"]


def test_simulations_tell_parameters_that_fit_a_torque_from_those_that_move_the_leg(study):
    scores = {
        (row["condition"], row["parameter_set"], row["quantity"]): float(row["vaf_trial"])
        for row in table(study, "forward")
    }
    for condition in ("sine-0.5", "minjerk-0.5"):
        assert scores[condition, "corrected", "theta"] > 90.0
        assert scores[condition, "tep", "theta"] < scores[condition, "wristalyzer", "theta"]
        assert scores[condition, "tep", "tau"] > 70.0
        assert scores[condition, "corrected", "tau"] < 0.0


def test_recommended_estimator_stands_noise_that_the_treadmills_signals_may_have(study):
    of = {"estimator": "recommended", "quantity": "K", "snr_db": "20"}
    rows = [row for row in table(study, "noise") if all(row[key] == cell for key, cell in of.items())]
    assert {(row["condition"], row["noise_on"]) for row in rows} == {
        (condition, noise_on)
        for condition in ("sine-0.5", "minjerk-0.5")
        for noise_on in ("tau", "theta", "both")
    }
    for row in rows:
        assert float(row["mean"]) == pytest.approx(10.0, rel=0.02)
        assert row["n_draws"] == "10"


def test_models_of_the_treadmill_are_judged_on_trials_that_they_have_not_seen(study):
    with open(study / "results/tables/treadmill_models.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    columns = "model train test cutoff_hz r2 rms_before rms_after order r2_limit load unit converged"
    assert list(rows[0]) == columns.split()
    of = {"train": "empty+weight", "test": "weight", "cutoff_hz": "20", "load": "Fy"}
    (frame,) = [row for row in rows if all(row[key] == cell for key, cell in of.items())]
    assert frame["model"] == "loaded-frame"
    assert float(frame["r2"]) > 0.98
    of |= {"train": "empty"}
    others = [float(row["r2"]) for row in rows if all(row[key] == cell for key, cell in of.items())]
    assert len(others) == 6
    assert max(others) < 0.8


def test_another_truth_in_the_laboratory_is_recovered_too(study):
    truth = yaml.safe_load((study / "config/virtual_lab.yaml").read_text())
    truth["dummy"]["rubber"] |= {"stiffness_Nm_per_rad": 14.0, "damping_Nms_per_rad": 0.25}
    (study / "config/other_truth.yaml").write_text(yaml.safe_dump(truth))
    other = {
        "study": OVERRIDES["study"] | {"virtual_lab": "config/other_truth.yaml"},
        "pathvars": {"results": "results/other", "logs": "results/other/logs"},
    }
    write_config(study, other, "other")
    target = "results/other/estimates/dummy/sine-0.5.csv"
    run = snakemake(study, target, config="other")
    assert run.returncode == 0, run.stdout + run.stderr
    with open(study / target, newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["pathway"] == "leg"]
    assert value(rows, quantity="K") == pytest.approx(14.0, rel=0.05)
    assert value(rows, quantity="B") == pytest.approx(0.25, rel=0.3)


def test_a_second_run_does_nothing(study):
    run = snakemake(study)
    assert "Nothing to be done" in run.stdout + run.stderr


# ---- what an edit plans: rule -> number of jobs, all of them ---------------------------------------

# what stands at the end of every path: the record of file checksums and settings, and the reports
RECORD = {"record_provenance": 1}
REPORTS = {"write_report": 1, "write_html_report": 1, "all": 1}
ESTIMATES = {"collect_estimates": 1, "compare_with_truth": 1, "check_claims": 1}
# what follows from the dummy's trials, and from its estimates
AFTER_DUMMY_ESTIMATES = {
    "cross_validate_dummy": 1,
    "plot_dummy": 1,
    "plot_foot": 1,
    "simulate_dummy": 2,
    "collect_forward": 1,
    "plot_simulation": 1,
    "lay_out_table": 2,
    **ESTIMATES,
    **REPORTS,
}
AFTER_DUMMY_TRIALS = {
    "fit_dummy": 2,
    "fit_foot": 2,
    "specify_dummy": 1,
    "simulate_without_noise": 2,
    "sweep_noise": 2,
    "collect_noise": 1,
    "plot_noise": 1,
    **AFTER_DUMMY_ESTIMATES,
}


def planned_after_an_edit(study, name, old=None, new=None):
    """Jobs that a dry run lists after a value is replaced, or a comment added."""
    file = study / name
    text = file.read_text()
    assert old is None or text.count(old) == 1
    try:
        file.write_text(text + "\n# an edit\n" if old is None else text.replace(old, new))
        return jobs(snakemake(study, "-n"))
    finally:
        file.write_text(text)


def planned_with(study, changes):
    """Jobs that a dry run lists with other settings."""
    write_config(study, OVERRIDES | changes, "changed")
    return jobs(snakemake(study, "-n", config="changed"))


def test_an_edit_of_the_dummys_rubber_makes_the_dummys_trials_again_and_no_others(study):
    planned = planned_after_an_edit(study, "config/virtual_lab.yaml", "softening: 0.03", "softening: 0.04")
    assert planned == {"make_dummy_trial": 2, "ingest_plate_treadmill": 2, **AFTER_DUMMY_TRIALS, **RECORD}


def test_an_edit_of_the_force_plate_makes_all_trials_on_the_treadmill_again(study):
    planned = planned_after_an_edit(study, "config/virtual_lab.yaml", "friction_N: 15.0", "friction_N: 16.0")
    assert planned == {
        "make_dummy_trial": 2,
        "make_weight_trial": 2,
        "make_empty_trial": 2,
        "make_standing_trial": 2,
        "ingest_plate_treadmill": 6,
        "ingest_standing": 2,
        "fit_weight": 4,
        "calibrate_plate": 1,
        "collect_treadmill_models": 1,
        "plot_weight": 1,
        "fit_standing": 2,
        "fit_standing_task": 2,
        "plot_standing_trials": 1,
        "plot_standing": 1,
        **AFTER_DUMMY_TRIALS,
        **RECORD,
    }


def test_an_edit_of_one_task_makes_the_trials_of_this_task_again(study):
    stiff = "stiffness_Nm_per_rad: [600.0, 1400.0, 900.0]"
    planned = planned_after_an_edit(study, "config/virtual_lab.yaml", stiff, stiff.replace("600", "610"))
    assert planned == {
        "make_standing_trial": 1,
        "ingest_standing": 1,
        "fit_standing": 1,
        "fit_standing_task": 1,
        "plot_standing_trials": 1,
        "plot_standing": 1,
        **ESTIMATES,
        **RECORD,
        **REPORTS,
    }


def test_an_edit_of_a_comment_of_the_truth_makes_nothing_again_but_its_record(study):
    assert planned_after_an_edit(study, "config/virtual_lab.yaml") == RECORD | REPORTS


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        (
            {"dummy": {"analysis": {"bootstrap_draws": 301}}},
            {"fit_dummy": 2, "fit_foot": 2, **AFTER_DUMMY_ESTIMATES, **RECORD},
        ),
        (
            {"dummy": {**OVERRIDES["dummy"], "foot": {"pathways": {"foot": {"window_s": 1.0}}}}},
            {"fit_foot": 2, "plot_foot": 1, **ESTIMATES, **RECORD, **REPORTS},
        ),
        (
            {"dummy": {**OVERRIDES["dummy"], "recommended": "leg-thesis"}},
            {
                "specify_dummy": 1,
                "plot_dummy": 1,
                "plot_foot": 1,
                "simulate_dummy": 2,
                "collect_forward": 1,
                "plot_simulation": 1,
                "lay_out_table": 2,
                "check_claims": 1,
                **RECORD,
                **REPORTS,
            },
        ),
        (
            {"standing": {"latency": {"threshold_sd": 4.0}}},
            {"fit_standing_task": 2, "plot_standing": 1, **ESTIMATES, **RECORD, **REPORTS},
        ),
        ({"belt": {"analysis": {"trimmed_s": 2.0}}}, RECORD | REPORTS),
    ],
    ids=[
        "bootstrap",
        "window of a pathway",
        "recommended pathway",
        "latency",
        "experiment that is not there",
    ],
)
def test_a_changed_setting_reruns_what_depends_on_it_and_nothing_else(study, changes, expected):
    assert planned_with(study, changes) == expected


def test_an_edit_of_a_module_reruns_what_uses_it_and_nothing_else(study):
    planned = planned_after_an_edit(study, "tepsipe/identification/admittance_fit.py")
    assert planned == {
        "fit_wristalyzer": 2,
        "cross_validate_wristalyzer": 1,
        "plot_wristalyzer": 1,
        "simulate_dummy": 2,
        "collect_forward": 1,
        "plot_simulation": 1,
        "lay_out_table": 1,
        **ESTIMATES,
        **REPORTS,
    }


def test_an_edit_of_the_simulation_reruns_simulations_and_no_fit(study):
    planned = planned_after_an_edit(study, "tepsipe/mechanics/forward_dynamics.py")
    assert planned["simulate_dummy"] == planned["simulate_without_noise"] == 2
    assert not {"fit_dummy", "fit_foot", "fit_wristalyzer", "ingest_plate_treadmill", "plot_dummy"} & set(
        planned
    )


def test_an_edit_of_a_reported_value_lays_its_own_table_out_again(study):
    planned = planned_after_an_edit(study, "config/reported.yaml", "sine-0.5: 5.341", "sine-0.5: 5.342")
    assert planned == {"lay_out_table": 1, **RECORD, **REPORTS}
    planned = planned_after_an_edit(study, "config/reported.yaml", "reported: 9.996", "reported: 9.995")
    assert planned == {"check_claims": 1, **RECORD, **REPORTS}


def test_one_condition_alone_touches_nothing_else(study):
    target = "results/estimates/dummy/sine-0.5.csv"
    (study / target).unlink()
    assert jobs(snakemake(study, "-n", target)) == {"fit_dummy": 1}
    assert snakemake(study, target).returncode == 0
    assert "Nothing to be done" in "".join(vars(snakemake(study))[key] for key in ("stdout", "stderr"))


def test_a_recorded_trial_gives_what_the_same_files_give_when_they_are_made(study):
    raw = study / "results/raw/dummy/sine-0.5"
    row = f"dummy own recorded - - - 46 {raw / 'log.mat'} - {raw / 'calibration.csv'} {raw / 'markers.c3d'}"
    write_sheet(study, [row], "recorded")
    recorded = {
        "study": {"trial_sheet": "config/recorded.tsv", "virtual_lab": None, "reported": None},
        "pathvars": {"results": "results/recorded", "logs": "results/recorded/logs"},
        "dummy": OVERRIDES["dummy"],
    }
    write_config(study, recorded, "recorded")
    run = snakemake(study, config="recorded")
    assert run.returncode == 0, run.stdout + run.stderr
    made = [row for row in estimates(study) if row["condition"] == "sine-0.5"]
    own = estimates(study, "results/recorded")
    own_pathways = {row["pathway"] for row in own}
    of_trial = [
        row for row in made if row["quantity"] != "VAF_cross_validated" and row["pathway"] in own_pathways
    ]
    assert [row["value"] for row in own] == [row["value"] for row in of_trial]
    assert (study / "results/recorded/report/thesis.pdf").exists()


def test_what_cannot_be_trusted_of_a_person_is_named_in_the_report_and_left_out(study):
    """A flat, a missing and a loose electrode, a hidden marker, and in the other trial a step."""
    bad = study / "bad_person"
    for condition in PEOPLE:
        shutil.copytree(study / f"results/raw/standing/{condition}", bad / condition)
    edf = edfio.read_edf(bad / PEOPLE[0] / "emg.edf")
    hum = 300.0 * np.sin(2.0 * np.pi * 50.0 * np.arange(edf.signals[0].data.size) / 1000.0)
    for signal in edf.signals:
        if signal.label == "EMG SOL":
            signal.update_data(np.zeros_like(signal.data), keep_physical_range=True)
        if signal.label == "EMG BF":
            signal.update_data(hum, keep_physical_range=True)
        if signal.label == "EMG GAS":
            signal.label = "EMG gastro"
    edf.write(bad / PEOPLE[0] / "emg.edf")
    with h5py.File(study / f"results/epochs/standing/{PEOPLE[0]}.h5") as responses:
        onset = float(responses["onsets_s"][1])
    hide_marker(bad / PEOPLE[0] / "markers.c3d", "shank2", onset + 0.03)
    step(bad / PEOPLE[1] / "markers.c3d", 20.0)
    rows = [
        f"standing {condition} recorded - - - 41 {folder / 'log.mat'} - {folder / 'calibration.csv'} "
        f"{folder / 'markers.c3d'} - {folder / 'emg.edf'} {condition.partition('-')[0]}"
        for condition, folder in ((condition, bad / condition) for condition in PEOPLE)
    ]
    write_sheet(study, rows, "people")
    people = {
        "study": {"trial_sheet": "config/people.tsv", "virtual_lab": None, "reported": None},
        "pathvars": {"results": "results/people", "logs": "results/people/logs"},
        "standing": {"pathways": {"ankle-compensated": {"treadmill_model": None}}},
    }
    write_config(study, people, "people")
    run = snakemake(study, config="people")
    assert run.returncode == 0, run.stdout + run.stderr
    report = json.loads((study / "results/people/report/report.json").read_text())["standing"]
    told = "\n".join(report["left_out"])
    for words in (
        "muscle SOL left out: expected at least 0.25 uV",
        "muscle GAS left out: its channel is not in the file",
        "muscle BF left out: expected at most 80 % of the power from the mains",
        f"perturbation at {onset:.2f} s left out: marker 'shank2' was hidden",
        "standing/stiff-pos-0.5: left out as a whole: the foot's marker",
    ):
        assert words in told, told
    found = estimates(study, "results/people")
    assert {row["condition"] for row in found} == {"relax-neg-0.5", "relax"}
    before = value(
        estimates(study),
        condition="relax-neg-0.5",
        pathway="ankle",
        estimator="pre-reflex-window",
        quantity="K",
    )
    after = value(
        found, condition="relax-neg-0.5", pathway="ankle", estimator="pre-reflex-window", quantity="K"
    )
    # one of the responses is missing, and nothing else has changed
    assert after != before
    assert after == pytest.approx(before, rel=0.2)


def test_a_person_without_electromyograms_still_has_ankles(study):
    folder = study / f"results/raw/standing/{PEOPLE[0]}"
    row = (
        f"standing {PEOPLE[0]} recorded - - - 41 {folder / 'log.mat'} - {folder / 'calibration.csv'} "
        f"{folder / 'markers.c3d'} - - told"
    )
    write_sheet(study, [row], "silent")
    silent = {
        "study": {"trial_sheet": "config/silent.tsv", "virtual_lab": None, "reported": None},
        "pathvars": {"results": "results/silent", "logs": "results/silent/logs"},
        "standing": {"pathways": {"ankle-compensated": {"treadmill_model": None}}},
    }
    write_config(study, silent, "silent")
    run = snakemake(study, config="silent")
    assert run.returncode == 0, run.stdout + run.stderr
    wanted = {"condition": PEOPLE[0], "pathway": "ankle", "estimator": "pre-reflex-window", "quantity": "K"}
    found = estimates(study, "results/silent")
    assert value(found, **wanted) == value(estimates(study), **wanted)
    assert not [row for row in found if row["estimator"] == "emg-driven"]
    report = json.loads((study / "results/silent/report/report.json").read_text())["standing"]
    assert report["left_out"][0] == (
        f"standing/{PEOPLE[0]}: no muscles: the trial has no file of electromyograms"
    )


def hide_marker(path, label, instant_s):
    """Hide a marker for 20 ms."""
    file = ezc3d.c3d(str(path))
    labels = file["parameters"]["POINT"]["LABELS"]["value"]
    frames = slice(round(250.0 * instant_s), round(250.0 * instant_s) + 5)
    file["data"]["points"][:3, labels.index(label), frames] = np.nan
    rewrite(file, path)


def step(path, instant_s):
    """The leg goes on 8 cm further forward."""
    file = ezc3d.c3d(str(path))
    file["data"]["points"][1, :, round(250.0 * instant_s) :] += 80.0
    rewrite(file, path)


def rewrite(file, path):
    hidden = np.isnan(file["data"]["points"][:3]).any(axis=0)
    file["data"]["meta_points"]["residuals"] = np.where(hidden, -1.0, 0.0)[None]
    file.write(str(path))


def test_bad_recordings_stop_their_own_jobs_with_one_sentence_each(study):
    raw = study / "results/raw/dummy/sine-0.5"
    bad = study / "bad"
    bad.mkdir()
    (bad / "truncated.mat").write_bytes((raw / "log.mat").read_bytes()[:300_000])
    (bad / "truncated.c3d").write_bytes((raw / "markers.c3d").read_bytes()[:300_000])
    content = {k: v for k, v in loadmat(raw / "log.mat").items() if not k.startswith("__")}
    content["belt_velocity_m_per_s"] = 0.001 * np.random.default_rng(1).standard_normal(
        content["belt_velocity_m_per_s"].shape
    )
    savemat(bad / "still.mat", content)
    good = {"log": raw / "log.mat", "calibration": raw / "calibration.csv", "markers": raw / "markers.c3d"}
    cases = {
        "good": {},
        "missing": {"log": "nowhere.mat"},
        "truncated-log": {"log": bad / "truncated.mat"},
        "truncated-markers": {"markers": bad / "truncated.c3d"},
        "still": {"log": bad / "still.mat"},
    }
    rows = []
    for condition, wrong in cases.items():
        files = good | wrong
        rows.append(
            f"dummy {condition} recorded - - - 46 {files['log']} - {files['calibration']} {files['markers']}"
        )
    write_sheet(study, rows, "bad")
    write_config(
        study,
        {
            "study": {"trial_sheet": "config/bad.tsv", "virtual_lab": None, "reported": None},
            "pathvars": {"results": "results/bad", "logs": "results/bad/logs"},
        },
        "bad",
    )
    run = snakemake(study, config="bad")
    assert run.returncode != 0
    assert (study / "results/bad/estimates/dummy/good.csv").exists()
    said = run.stdout + run.stderr
    assert "Traceback" not in said
    for condition, words in {
        "missing": "nowhere.mat: expected a treadmill log, found no file",
        "truncated-log": "truncated.mat: expected a MATLAB file",
        "truncated-markers": "truncated.c3d: expected 11500 frames",
        "still": "expected perturbations",
    }.items():
        assert not (study / f"results/bad/estimates/dummy/{condition}.csv").exists()
        (log,) = [
            text
            for rule in ("ingest_plate_treadmill/dummy", "fit_dummy")
            for path in [study / f"results/bad/logs/{rule}/{condition}.log"]
            if path.exists() and (text := path.read_text())
        ]
        assert log.startswith("tepsipe: ")
        assert log.count("\n") == 1
        assert words in log
        assert words in said


def belt_table(path, seed, sign=1.0, still=False):
    """A treadmill's load (Nm) and belt velocity (m/s) as its log has them, 40 s at 100 Hz."""
    rng = np.random.default_rng(seed)
    time = np.arange(4000) / 100.0
    velocity = 1.2 + 0.1 * np.convolve(rng.standard_normal(4000), np.hanning(40) / 4.5, "same")
    load = sign * (5.0 * np.gradient(velocity, 0.01) + 0.3 * rng.standard_normal(4000))
    table = np.column_stack([time, load, np.full(4000, 1.2) if still else velocity])
    np.savetxt(path, table, delimiter="\t", header="t\tMx (Nm)\tv (m/s)", comments="", fmt="%.6g")


def treadmill_study(study, name, recordings):
    """Run a study of treadmill recordings: condition -> (role, file)."""
    rows = [
        "\t".join(["belt", condition, "recorded", "-", "-", "-", "39", str(file), "-", "-", "-", role])
        + "\t-\t-\tt\tMx (Nm)\tv (m/s)"
        for condition, (role, file) in recordings.items()
    ]
    write_sheet(study, rows, name)
    content = {
        "study": {"trial_sheet": f"config/{name}.tsv", "virtual_lab": None, "reported": None},
        "pathvars": {"results": f"results/{name}", "logs": f"results/{name}/logs"},
        "belt": {"analysis": {"cutoffs_hz": [6, 20]}},
    }
    write_config(study, content, name)
    run = snakemake(study, config=name)
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


def test_a_newcomer_calibrates_a_treadmill_from_two_text_files(study, tables):
    recordings = {"a": ("calibrate", tables / "first.txt"), "b": ("validate", tables / "second.txt")}
    run = treadmill_study(study, "own-treadmill", recordings)
    assert run.returncode == 0, run.stdout + run.stderr
    with open(study / "results/own-treadmill/tables/treadmill_models.csv", newline="") as file:
        rows = {(row["model"], row["cutoff_hz"]): row for row in csv.DictReader(file)}
    assert float(rows["fir", "6"]["r2"]) > 0.9
    assert {row["train"] for row in rows.values()} == {"a"}
    assert {row["test"] for row in rows.values()} == {"b"}
    assert (study / "results/own-treadmill/report/thesis.pdf").stat().st_size > 20_000


@pytest.mark.parametrize(
    ("name", "calibrate", "validate", "words"),
    [
        ("turned", "first", "turned", "found it with the opposite sign"),
        ("still", "first", "still", "found 1.2 throughout"),
        ("uncalibrated", None, "second", "with the role calibrate, found none"),
    ],
)
def test_recordings_that_cannot_calibrate_a_treadmill_get_one_sentence(
    study, tables, name, calibrate, validate, words
):
    recordings = {"b": ("validate", tables / f"{validate}.txt")}
    if calibrate:
        recordings["a"] = ("calibrate", tables / f"{calibrate}.txt")
    run = treadmill_study(study, name, recordings)
    assert run.returncode != 0
    said = [line for line in (run.stdout + run.stderr).splitlines() if line.startswith("tepsipe: ")]
    assert len(said) == 1
    assert words in said[0]


@pytest.mark.parametrize(
    ("section", "words"),
    [
        ({"plate_treadmill": {"lowpas_cutoff_hz": 20.0}}, "did you mean 'lowpass_cutoff_hz'?"),
        ({"plate_treadmill": {"lowpass_cutoff_hz": -20.0}}, "expected a number above 0"),
        ({"plate_treadmill": {"lowpass_cutoff_hz": "20 Hz"}}, "expected a value of type number"),
        ({"pilot": {"person": {"mass_kg": 70.0}}}, "unknown key 'pilot': renamed to 'standing'"),
        ({"weight": {"belt": "left"}}, "unknown key 'weight.belt': moved to plate_treadmill.belt"),
        (
            {"plate_treadmill": {"exceptions": {"standing": {"belt": "left"}}}},
            "found left in plate_treadmill.exceptions.standing",
        ),
        ({"study": {"trial_sheet": "config/none.tsv"}}, "expected the trial sheet, found no file"),
        (
            {"dummy": {"simulation": {"engine": "bullet"}}},
            "expected one of 'pybullet', 'mujoco'",
        ),
    ],
)
def test_a_mistake_in_the_configuration_stops_the_run_before_anything_is_computed(study, section, words):
    write_config(study, section, "mistaken")
    run = snakemake(study, config="mistaken")
    said = run.stdout + run.stderr
    assert run.returncode != 0
    assert words in said
    assert "Traceback" not in said
    assert "Job stats" not in said
