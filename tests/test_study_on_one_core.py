"""Numbers of the tiny study on one core: the same bytes as on two."""

import json

import pytest
from study_builders import copy_project, digests, snakemake

pytestmark = pytest.mark.study


def test_one_core_or_two_give_the_same_bytes(request, tmp_path):
    again = copy_project(tmp_path / "again")
    # figures, pages and reports are drawn from these numbers by one job each
    tables = ("estimates", "table_4_4", "noise", "forward", "recovery", "claims", "specification")
    run = snakemake(again, *(f"results/tables/{name}.csv" for name in tables), cores=1)
    assert run.returncode == 0, run.stdout + run.stderr
    second = digests(again / "results")
    # wanted no earlier: another process makes it meanwhile
    first = json.loads((request.getfixturevalue("study").parent / "digests.json").read_text())
    assert {name for name in second if first.get(name) != second[name]} == set()
    made = {name.partition("/")[0] for name in second}
    assert made == {"tables", "estimates", "trials", "raw"}
    assert {name for name in first if name.startswith(("estimates/", "trials/", "raw/"))} <= second.keys()
