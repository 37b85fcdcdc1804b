"""Numbers of the tiny study on one core and two, and under Snakemake's own executor: the same bytes."""

import json

import pytest
from study_builders import copy_project, digests, snakemake

pytestmark = pytest.mark.study


# of every kind of job with numbers, one: what collects and draws them does so in one job each
TARGETS = (
    "estimates/wristalyzer/0.16.csv",
    "estimates/dummy/sine-0.5.csv",
    "estimates/foot/sine-0.5.csv",
    "estimates/other_laws/relaxation/sine-0.5.csv",
    "estimates/weight/minjerk-0.4.csv",
    "estimates/empty/minjerk-0.4.csv",
    "estimates/standing/relax-neg-0.5.csv",
    "estimates/standing_pairs/stiff-relax.csv",
    "cross_validation/wristalyzer.csv",
    "forward/sine-0.5.csv",
    "noise/sine-0.5.csv",
    "tables/specification.csv",
)


def kinds(names):
    return {name.rpartition("/")[0] for name in names if not name.startswith(("raw/", "figures/", "report/"))}


def test_one_core_or_two_give_the_same_bytes(request, tmp_path):
    again = copy_project(tmp_path / "again")
    targets = [f"results/{name}" for name in TARGETS]
    for some in ((targets[0], "--executor", "local"), targets):
        run = snakemake(again, *some)
        assert run.returncode == 0, run.stdout + run.stderr
    second = digests(again / "results")
    # wanted no earlier: another process makes it meanwhile
    first = json.loads((request.getfixturevalue("study").parent / "digests.json").read_text())
    assert {name for name in second if first.get(name) != second[name]} == set()
    assert set(TARGETS) <= second.keys()
    assert kinds(second) == kinds(first)
