"""The tiny study on one core: the same bytes as on two."""

import json

import pytest
from study_builders import copy_project, digests, snakemake

pytestmark = pytest.mark.study


def test_one_core_or_two_give_the_same_bytes(request, tmp_path):
    again = copy_project(tmp_path / "again")
    run = snakemake(again, cores=1)
    assert run.returncode == 0, run.stdout + run.stderr
    second = digests(again / "results")
    # wanted no earlier: another process makes it meanwhile
    first = json.loads((request.getfixturevalue("study").parent / "digests.json").read_text())
    assert {name for name in first if first[name] != second.get(name)} == set()
    assert first.keys() == second.keys()
