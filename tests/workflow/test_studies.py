"""Studies with rules of their own (workflow/studies): each plans its own jobs, and those of no other."""

import pytest
from study_builders import jobs, snakemake

pytestmark = pytest.mark.study

PLANNED = {
    "coverage": {"run_laboratory": 20, "collect_coverage": 1, "plot_coverage": 1, "write_coverage": 1},
    "plan": {
        "make_dummy_trial": 4,
        "make_weight_trial": 3,
        "make_empty_trial": 4,
        "make_several_joints": 1,
        "ingest_dummy": 4,
        "ingest_weight": 3,
        "ingest_empty": 4,
        "calibrate_plate": 1,
        "plan_design": 9,
        "optimise_pulses": 1,
        "plan_several_joints": 1,
        "sweep_filters": 4,
        "collect_plan": 1,
        "plot_planning": 1,
        "plot_several_joints": 1,
        "write_plan": 1,
    },
    "walking": {
        "make_walking_trial": 2,
        "fit_walking": 3,
        "collect_walking": 1,
        "compare_walking_with_truth": 1,
        "plot_walking": 1,
        "write_walking": 1,
    },
}


@pytest.mark.parametrize("name", PLANNED)
def test_a_study_plans_its_own_jobs_and_no_others(project, name):
    run = snakemake(project, "-n", config=f"{name}/config")
    planned = {**PLANNED[name], "typeset_report": 1, "write_index": 1, "all": 1}
    assert jobs(run) == planned, run.stdout + run.stderr
