"""Results that are deleted, damaged, edited, or of a trial that has been renamed."""

import os
from pathlib import Path
from types import SimpleNamespace

import h5py
import pytest
from builders import assert_one_sentence

from tepsipe.errors import InputError
from workflow.support import job_outputs

CONFIG = {"pathvars": {"results": "results", "logs": "results/logs"}}
FIT, TABLE = "results/fits/dummy/a.h5", "results/estimates/dummy/a.csv"


@pytest.fixture
def job(tmp_path, monkeypatch):
    """Let a job of a rule make files."""
    monkeypatch.chdir(tmp_path)

    def run(*files, rule="fit_dummy", condition="a", logs="results/logs"):
        log = f"{logs}/{rule}/{condition}.log"
        job_outputs.begin_job(log)
        for path in files:
            Path(path).parent.mkdir(parents=True, exist_ok=True)
            if path.endswith(".h5"):
                with h5py.File(path, "w") as file:
                    file["x"] = range(500)
            else:
                with open(path, "w") as file:
                    file.write("K,8.7\n")
        wildcards = {"condition": condition} if condition else {}
        job_outputs.end_job(SimpleNamespace(log=[log], wildcards=wildcards, output=files))

    return run


@pytest.fixture
def summary(monkeypatch):
    """Files that the present study makes."""

    def makes(*files):
        monkeypatch.setattr(job_outputs, "_made_by", lambda config, snakefile: set(files))

    return makes


def found():
    return job_outputs.changes("results/logs")


def remade(found, *arguments, dry=False):
    return job_outputs.remade(found, CONFIG, "Snakefile", ["snakemake", *arguments], dry)


def test_what_nobody_touched_is_as_it_was_made(job):
    job(FIT, TABLE)
    assert found() == job_outputs.Changes()
    os.utime(TABLE)  # touched or copied
    assert found() == job_outputs.Changes()
    assert remade(found()) == []


def test_an_edited_result_is_refused_until_it_is_deleted(job, summary):
    job(FIT, TABLE)
    with open(TABLE, "w") as file:
        file.write("K,9.9\n")
    with pytest.raises(InputError, match="delete it to have it made again") as caught:
        job_outputs.refuse_edited(found())
    assert_one_sentence(caught.value, TABLE)
    Path(TABLE).unlink()
    job_outputs.refuse_edited(found())
    summary(FIT, TABLE)
    assert remade(found()) == [TABLE]


def replaced_by(make):
    def change(path):
        path.unlink()
        make(path)

    return change


def longer(path):
    with h5py.File(path, "a") as file:
        file["more"] = range(9)


@pytest.mark.parametrize(
    ("path", "change", "is_damaged"),
    [
        (TABLE, lambda path: path.write_text("K,99.9\n"), False),
        (TABLE, lambda path: path.write_text("K,8.7"), False),
        (TABLE, lambda path: path.write_text("K;8,7\n"), False),
        (TABLE, lambda path: path.write_bytes(b"\xef\xbb\xbfK,8.7\r\n"), False),
        (TABLE, lambda path: path.write_bytes(bytes(6)), False),
        (TABLE, lambda path: path.write_text(""), True),
        (TABLE, replaced_by(Path.mkdir), False),
        (TABLE, replaced_by(os.mkfifo), False),
        (TABLE, replaced_by(lambda path: path.symlink_to("/dev/zero")), False),
        (FIT, longer, False),
        (FIT, lambda path: path.write_bytes(path.read_bytes()[:-1]), True),
        (FIT, lambda path: path.write_bytes(path.read_bytes()[:100]), True),
        (FIT, lambda path: path.write_bytes(bytes(5000)), True),
        (FIT, lambda path: path.write_text("K,99.9\n"), True),
    ],
)
def test_whatever_happens_to_a_result_is_noticed(job, path, change, is_damaged):
    job(FIT, TABLE)
    change(Path(path))
    assert found() == (
        job_outputs.Changes(damaged=[path]) if is_damaged else job_outputs.Changes(edited=[path])
    )


def test_a_deleted_intermediate_is_asked_for_if_the_study_makes_it(job, summary, capsys):
    job(FIT, TABLE)
    job("results/raw/dummy/a/log.mat", rule="make_dummy_trial")
    Path(FIT).unlink()
    Path("results/raw/dummy/a/log.mat").unlink()  # of a trial that is recorded by now
    summary(FIT, TABLE)
    assert remade(found(), dry=True) == [FIT]
    assert remade(found(), TABLE) == []  # with targets, Snakemake makes what these need
    assert remade(found()) == [FIT]
    assert f"tepsipe: missing, made again: {FIT}" in capsys.readouterr().err
    assert found().missing == [FIT]  # the other one is forgotten
    Path(TABLE).unlink()
    summary()
    assert remade(found()) == []  # without any result, the run makes everything


@pytest.mark.parametrize("left", [0, 3000])
def test_a_truncated_file_is_removed_and_asked_for(job, summary, left):
    job(FIT, TABLE)
    os.truncate(FIT, left)
    summary(FIT, TABLE)
    assert found() == job_outputs.Changes(damaged=[FIT])
    assert remade(found(), dry=True) == [FIT]
    assert Path(FIT).exists()
    assert remade(found()) == [FIT]
    assert not Path(FIT).exists()


def test_figures_that_are_no_longer_drawn_are_removed_and_results_of_a_renamed_trial_named(job):
    figures = [f"results/figures/{name}.svg" for name in "abc"]
    page = "results/report/trials/dummy/a.html"
    job(FIT, TABLE)
    job(page, rule="write_dummy_pages")
    job(*figures, rule="plot_budgets", condition=None)
    with open(figures[2], "a") as file:
        file.write("mine")
    job(figures[0], "results/figures/d.svg", rule="plot_budgets", condition=None)
    assert sorted(path.name for path in Path("results/figures").iterdir()) == ["a.svg", "c.svg", "d.svg"]
    experiments = {"dummy", "weight"}
    assert job_outputs.of_no_trial("results/logs", {("dummy", "a"): 0}, experiments) == []
    assert job_outputs.of_no_trial("results/logs", {("weight", "a"): 0}, experiments) == [TABLE, FIT, page]


def test_a_job_that_is_killed_leaves_nothing_to_be_taken_for_an_edit(job):
    job(FIT, TABLE)
    job_outputs.begin_job("results/logs/fit_dummy/a.log")
    with open(TABLE, "w") as file:
        file.write("half")
    assert found() == job_outputs.Changes()


def test_results_of_another_study_in_the_folder_are_left_alone(job):
    job("results/mine/tables/a.csv", logs="results/mine/logs")
    Path("results/mine/tables/a.csv").unlink()
    assert found() == job_outputs.Changes()
    (record,) = job_outputs.RECORDS.glob("*.json")
    record.write_text("{damaged")
    assert job_outputs.changes("results/mine/logs") == job_outputs.Changes()
