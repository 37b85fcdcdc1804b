"""What an edit plans in a tiny study that has run: rule -> number of jobs, all of them.

An edit of a module changes the list of modules of some rules (workflow/support/imported_files.py). One dry
run shows that this plans the jobs of these rules and all after them. For other modules, the lists and the
records of inputs and outputs tell which jobs these are.
"""

import base64
import json
import re
import shutil
from collections import Counter

import pytest
from study_builders import OVERRIDES, jobs, snakemake, write_config

pytestmark = pytest.mark.study

# what stands at the end of every path: the record of file checksums and settings, and the reports
RECORD = {"record_provenance": 1}
TYPESET = {"typeset_report": 1, "write_index": 1, "all": 1}
REPORTS = {"write_report": 1, **TYPESET}
ESTIMATES = {"collect_estimates": 1, "collect_recovery": 1, "check_claims": 1, "plot_budgets": 1}
# figures show the truth beside the estimates
ESTIMATES |= {"plot_dummy": 1, "plot_foot": 1}
CELLS = {"judge_cells": 1}
# the dummy under another law of its joint, in one trial
LAW_FITTED = {"fit_trial_of_law": 1, "compare_law_with_truth": 1, "collect_other_laws": 1}
# what follows from the dummy's trials, and from its estimates
AFTER_DUMMY_ESTIMATES = {
    "check_rig": 1,
    "cross_validate_dummy": 1,
    "plot_dummy": 1,
    "plot_foot": 1,
    "plot_rigs": 1,
    "compare_with_truth": 2,
    "write_dummy_pages": 2,
    "simulate_dummy": 2,
    "collect_forward": 1,
    "plot_simulation": 1,
    "plot_simulation_trial": 2,
    "lay_out_table": 2,
    **CELLS,
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


# and from the manipulator's trials
AFTER_WRISTALYZER_TRIALS = {
    "fit_wristalyzer": 2,
    "sweep_averaging": 1,
    "cross_validate_wristalyzer": 1,
    "plot_wristalyzer": 1,
    "compare_with_truth": 2,
    "write_wristalyzer_pages": 2,
    "simulate_dummy": 2,
    "collect_forward": 1,
    "plot_simulation": 1,
    "plot_simulation_trial": 2,
    "lay_out_table": 1,
    **CELLS,
    **ESTIMATES,
    **REPORTS,
}


def planned_after_an_edit(project, name, old=None, new=None):
    """Jobs that a dry run lists after a value is replaced, or a comment added."""
    file = project / name
    text = file.read_text()
    assert old is None or text.count(old) == 1
    try:
        file.write_text(text + "\n# an edit\n" if old is None else text.replace(old, new))
        return jobs(snakemake(project, "-n"))
    finally:
        file.write_text(text)


def planned_with(project, changes):
    """Jobs that a dry run lists with other settings."""
    write_config(project, OVERRIDES | changes, "changed")
    return jobs(snakemake(project, "-n", config="changed"))


def recorded_jobs(study):
    """Jobs of the study, by Snakemake's records -> their inputs and outputs."""
    records, found = study / ".snakemake/metadata", {}
    for path in (path for path in records.rglob("*") if path.is_file()):
        record = json.loads(path.read_text(encoding="utf-8"))
        output = base64.b64decode(path.relative_to(records).as_posix().replace("/@", "")).decode()
        inputs, outputs = found.setdefault((record["rule"], *record["log"]), (set(), set()))
        inputs.update(record["input"])
        outputs.add(output)
    return found


def after_an_edit_of_a_module(study, name):
    """Jobs whose list of modules has this one, and all that use their outputs."""
    lists = [
        path for path in (study / ".snakemake/tepsipe/library").iterdir() if f"  {name}\n" in path.read_text()
    ]
    jobs_of_study, again = recorded_jobs(study), set()
    changed = {path.relative_to(study).as_posix() for path in lists}
    assert changed or name.endswith("/__init__.py")
    while new := [job for job, (inputs, _) in jobs_of_study.items() if job not in again and inputs & changed]:
        again.update(new)
        changed.update(*(jobs_of_study[job][1] for job in new))
    return Counter(rule for rule, *_ in again) | Counter(all=bool(again))


def test_a_second_run_does_nothing(own_study):
    run = snakemake(own_study)
    assert "Nothing to be done" in run.stdout + run.stderr


def test_an_edit_of_the_rubber_makes_the_trials_of_both_rigs_again_and_no_others(own_study):
    planned = planned_after_an_edit(
        own_study, "config/virtual_lab.yaml", "    softening: 0.5\n", "    softening: 0.4\n"
    )
    assert planned == {
        "make_wristalyzer_trial": 2,
        "ingest_wristalyzer": 2,
        "make_dummy_trial": 2,
        "ingest_dummy": 2,
        **AFTER_DUMMY_TRIALS,
        **AFTER_WRISTALYZER_TRIALS,
        "compare_with_truth": 4,
        "tabulate_laboratory": 1,
        "lay_out_table": 3,
        **RECORD,
    }


def test_an_edit_of_the_force_plate_makes_all_trials_on_the_treadmill_again(own_study):
    planned = planned_after_an_edit(
        own_study, "config/virtual_lab.yaml", "friction_N: 15.0", "friction_N: 16.0"
    )
    assert planned == {
        "make_dummy_trial": 2,
        "make_trial_of_law": 1,
        "ingest_trial_of_law": 1,
        **LAW_FITTED,
        "make_weight_trial": 2,
        "make_empty_trial": 2,
        "make_standing_trial": 2,
        "ingest_dummy": 2,
        "ingest_weight": 2,
        "ingest_empty": 2,
        "ingest_standing": 2,
        "fit_weight": 2,
        "fit_empty": 2,
        "calibrate_plate": 1,
        "collect_treadmill_models": 1,
        "plot_weight": 1,
        "fit_standing": 2,
        "fit_standing_task": 2,
        "compare_standing_tasks": 1,
        "plot_standing_trials": 2,
        "plot_standing": 1,
        "write_weight_pages": 2,
        "write_empty_pages": 2,
        "write_standing_pages": 2,
        **AFTER_DUMMY_TRIALS,
        "compare_with_truth": 8,
        **RECORD,
    }


def test_an_edit_of_one_task_makes_the_trials_of_this_task_again(own_study):
    stiff = "stiffness_Nm_per_rad: [510.0, 1400.0, 900.0]"
    planned = planned_after_an_edit(own_study, "config/virtual_lab.yaml", stiff, stiff.replace("510", "520"))
    assert planned == {
        "make_standing_trial": 1,
        "ingest_standing": 1,
        "fit_standing": 1,
        "fit_standing_task": 2,  # pulses of all tasks show the person's foot
        "compare_standing_tasks": 1,
        "plot_standing_trials": 1,
        "plot_standing": 1,
        "plot_rigs": 1,
        "compare_with_truth": 3,
        "write_standing_pages": 1,
        **ESTIMATES,
        **RECORD,
        **REPORTS,
    }


def test_an_edit_of_a_comment_of_the_truth_makes_nothing_again_but_its_record(own_study):
    assert planned_after_an_edit(own_study, "config/virtual_lab.yaml") == RECORD | REPORTS


@pytest.mark.parametrize(
    ("changes", "expected"),
    [
        (
            {"dummy": {**OVERRIDES["dummy"], "analysis": {"bootstrap_draws": 301}}},
            {"fit_dummy": 2, "fit_foot": 2, **LAW_FITTED, **AFTER_DUMMY_ESTIMATES, **RECORD},
        ),
        (
            {"uncertainty": {"dummy": {"leg_mass_kg": None}}},
            {"fit_dummy": 2, "fit_foot": 2, **LAW_FITTED, **AFTER_DUMMY_ESTIMATES, **RECORD},
        ),
        (
            {"dummy": {**OVERRIDES["dummy"], "foot": {"pathways": {"foot": {"window_s": 1.0}}}}},
            {
                "fit_foot": 2,
                "compare_with_truth": 2,
                "write_dummy_pages": 2,
                **ESTIMATES,
                **RECORD,
                **REPORTS,
            },
        ),
        (
            # the fit marks the estimate to quote
            {"dummy": {**OVERRIDES["dummy"], "recommended": "leg-thesis"}},
            {"fit_dummy": 2, "specify_dummy": 1, **LAW_FITTED, **AFTER_DUMMY_ESTIMATES, **RECORD},
        ),
        (
            {"standing": {"latency": {"threshold_sd": 4.0}}},
            {
                "fit_standing_task": 2,
                "compare_standing_tasks": 1,
                "compare_with_truth": 2,
                "plot_standing": 1,
                **ESTIMATES,
                **RECORD,
                **REPORTS,
            },
        ),
        ({"belt": {"analysis": {"trimmed_s": 2.0}}}, RECORD | REPORTS),
    ],
    ids=[
        "bootstrap",
        "source of uncertainty",
        "window of a pathway",
        "recommended pathway",
        "latency",
        "experiment that is not there",
    ],
)
def test_a_changed_setting_reruns_what_depends_on_it_and_nothing_else(own_study, changes, expected):
    assert planned_with(own_study, changes) == expected


def test_an_edit_of_a_module_reruns_what_uses_it_and_nothing_else_until_it_is_changed_back(own_study):
    module = "tepsipe/identification/admittance_fit.py"
    assert planned_after_an_edit(own_study, module) == AFTER_WRISTALYZER_TRIALS
    assert not jobs(snakemake(own_study, "-n"))
    assert after_an_edit_of_a_module(own_study, module) == AFTER_WRISTALYZER_TRIALS


def test_results_whose_records_are_lost_are_made_again(own_study):
    whole = Counter(rule for rule, *_ in recorded_jobs(own_study)) | Counter(all=1)
    records = own_study / ".snakemake"
    kept = records.rename(own_study / "kept")
    assert jobs(snakemake(own_study, "-n")) == whole
    shutil.rmtree(records)
    kept.rename(records)


def test_an_edit_of_a_reader_reruns_the_ingest_of_the_files_that_it_reads_and_no_other(study):
    planned = after_an_edit_of_a_module(study, "tepsipe/io/readers/edf.py")
    assert {name for name in planned if name.startswith("ingest_")} == {"ingest_standing"}


def test_an_edit_of_what_an_experiment_declares_reruns_no_job_of_a_trial(study):
    planned = after_an_edit_of_a_module(study, "tepsipe/experiments/dummy/__init__.py")
    assert not [name for name in planned if re.match("make|ingest|fit|write_.*_pages", name)]


def test_an_edit_of_the_simulation_reruns_simulations_and_no_fit(study):
    planned = after_an_edit_of_a_module(study, "tepsipe/mechanics/forward_dynamics.py")
    assert planned["simulate_dummy"] == planned["simulate_without_noise"] == 2
    assert not {"fit_dummy", "fit_foot", "fit_wristalyzer", "ingest_dummy", "plot_dummy"} & set(planned)


def test_an_edit_of_a_module_of_pages_reruns_pages_and_nothing_else(study):
    planned = after_an_edit_of_a_module(study, "tepsipe/experiments/dummy/page.py")
    assert planned == {"write_dummy_pages": 2, "write_index": 1, "all": 1}


def test_an_edit_of_a_module_of_figures_draws_again_and_runs_nothing_else(study):
    planned = after_an_edit_of_a_module(study, "tepsipe/experiments/dummy/figures.py")
    assert planned == {"plot_dummy": 1, "plot_foot": 1, **TYPESET}


def test_an_edit_of_a_reported_value_lays_its_own_table_out_again(own_study):
    planned = planned_after_an_edit(own_study, "config/reported.yaml", "sine-0.5: 5.341", "sine-0.5: 5.342")
    assert planned == {"lay_out_table": 1, "check_claims": 1, **CELLS, **RECORD, **REPORTS}
    planned = planned_after_an_edit(own_study, "config/reported.yaml", "reported: 9.996", "reported: 9.995")
    assert planned == {"check_claims": 1, **RECORD, **REPORTS}


def test_a_page_asked_for_by_name_is_that_of_the_whole_study_if_this_has_run(own_study):
    targets = "results/report/trials/dummy/sine-0.5.html", "results/report/index.html"
    assert jobs(snakemake(own_study, "-n", *targets)) == {}


def test_one_condition_alone_touches_nothing_else(own_study):
    def written():
        files = (path for path in (own_study / "results").rglob("*") if path.is_file())
        return {path.relative_to(own_study).as_posix(): path.stat().st_mtime_ns for path in files}

    target = "results/estimates/dummy/sine-0.5.csv"
    (own_study / target).unlink()
    before = written()
    run = snakemake(own_study, target)
    assert (run.returncode, jobs(run)) == (0, {"fit_dummy": 1})
    after = written()
    assert {name for name in after if after[name] != before.get(name)} == {
        target,
        "results/uncertainty/dummy/sine-0.5.csv",
        "results/fits/dummy/sine-0.5.h5",
        "results/logs/fit_dummy/sine-0.5.log",
    }
    assert not before.keys() - after.keys()


def test_one_condition_reaches_its_page_and_its_figures_alone(project):
    foot = {"make_weight_trial": 2, "make_empty_trial": 2, "calibrate_plate": 1, "fit_foot": 1}
    own = {"make_dummy_trial": 1, "fit_dummy": 1, "compare_with_truth": 1, "write_dummy_pages": 1}
    expected = foot | own | {"ingest_dummy": 1, "ingest_weight": 2, "ingest_empty": 2}
    assert jobs(snakemake(project, "-n", "results/report/trials/dummy/sine-0.5.html")) == expected
    of_manipulator = {
        f"{kind}_wristalyzer{end}": 2 for kind, end in (("make", "_trial"), ("ingest", ""), ("fit", ""))
    }
    figure = {"simulate_dummy": 1, "plot_simulation_trial": 1, "dummy/sine-0.5": 1}
    assert jobs(snakemake(project, "-n", "dummy/sine-0.5")) == expected | of_manipulator | figure


def test_a_trial_is_a_target_by_its_name(project):
    run = snakemake(project, "wristalyzer/0.12")
    assert run.returncode == 0, run.stdout + run.stderr
    made = {
        path.relative_to(project / "results").as_posix() for path in (project / "results").rglob("*.[hc]*")
    }
    assert {"estimates/wristalyzer/0.12.csv", "report/trials/wristalyzer/0.12.html"} <= made
    assert not [name for name in made if "0.16" in name]
    assert not (project / "wristalyzer").exists()
    assert "Nothing to be done" in "".join(
        (again := snakemake(project, "wristalyzer/0.12")).stdout + again.stderr
    )
    assert "wristalyzer/" not in snakemake(project, "--list").stdout
