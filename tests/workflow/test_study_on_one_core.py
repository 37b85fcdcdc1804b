"""Numbers of the tiny study on one core, under Snakemake's own executor and after a kill: those on two.

One study shows all of it, which runs on one core, is killed, goes on and ends under the other executor.
"""

import json
import os
import signal
import subprocess
import sys
import time

import pytest
from study_builders import copy_project, digests, jobs, snakemake, warm_process

pytestmark = pytest.mark.study


# of every kind of job with numbers, one: what collects and draws them does so in one job each
TARGETS = (
    "estimates/wristalyzer/0.16.csv",
    "estimates/dummy/sine-0.5.csv",
    "estimates/weight/minjerk-0.4.csv",
    "estimates/empty/minjerk-0.4.csv",
    "estimates/standing/relax-neg-0.5.csv",
    "estimates/standing_pairs/stiff-relax.csv",
    "cross_validation/wristalyzer.csv",
    "forward/sine-0.5.csv",
    "noise/sine-0.5.csv",
    "estimates/foot/sine-0.5.csv",
    "tables/specification.csv",
    # by Snakemake's own executor, a Python per job
    "estimates/other_laws/relaxation/sine-0.5.csv",
)


def kinds(names):
    return {name.rpartition("/")[0] for name in names if not name.startswith(("raw/", "figures/", "report/"))}


def at_work(project, rule):
    """Whether a job of a rule has begun, by its record."""
    records = (project / ".snakemake/tepsipe/jobs").glob("*.json")
    return any(json.loads(record.read_text() or "{}").get("about", "").startswith(rule) for record in records)


def killed_at_work(project, rule, targets):
    """Kill a run while a job of a rule is at work, and let another go on from there."""
    arguments = ["-c1", *targets, "--configfile", "config/tiny.yaml"]
    killed, ended = warm_process().start(arguments, project, "workflow.run")
    while not at_work(project, rule):
        os.kill(killed, 0)  # an error if it has ended
        time.sleep(0.05)
    # another run is refused meanwhile, and leaves it alone
    command = [sys.executable, "-m", "workflow.run", *arguments]
    other = subprocess.run(command, cwd=project, capture_output=True, text=True)
    assert other.returncode == 2
    assert f"found process {killed} at work: wait for it, or stop it with kill {killed}" in other.stderr
    os.kill(killed, signal.SIGKILL)
    assert ended().returncode == -signal.SIGKILL
    assert any((project / ".snakemake/locks").iterdir())
    # its job goes on for a while: the next run waits for it
    again = snakemake(project, *targets, module="workflow.run")
    assert again.returncode == 0, again.stdout + again.stderr
    assert (
        "tepsipe: the last run was killed: this one removes its lock and goes on from there" in again.stderr
    )
    assert not list((project / ".snakemake").glob("locks/*"))


def test_one_core_or_two_and_a_run_that_was_killed_give_the_same_bytes(request, tmp_path):
    again = copy_project(tmp_path / "again")
    targets = [f"results/{name}" for name in TARGETS]
    killed_at_work(again, "fit_dummy", targets[:-1])
    run = snakemake(again, targets[-1], "--executor", "local")
    assert run.returncode == 0, run.stdout + run.stderr
    assert jobs(run) == {"make_trial_of_law": 1, "ingest_trial_of_law": 1, "fit_trial_of_law": 1}
    second = digests(again / "results")
    # wanted no earlier: another process makes it meanwhile
    first = json.loads((request.getfixturevalue("study").parent / "digests.json").read_text())
    assert {name for name in second if first.get(name) != second[name]} == set()
    assert set(TARGETS) <= second.keys()
    assert kinds(second) == kinds(first)
