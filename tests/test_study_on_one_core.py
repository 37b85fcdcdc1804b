"""The small study on one core: the same bytes as on two. In a file of its own, for a process of its own."""

import json

import pytest
from test_study import copy_project, digests, snakemake, study  # noqa: F401  study is a fixture

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
