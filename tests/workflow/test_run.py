"""The start of a run: what is refused before Snakemake loads anything, and what a killed run leaves."""

import json
import shutil
import subprocess
import sys
from functools import partial
from pathlib import Path

import pytest
from builders import assert_one_sentence
from snakemake import persistence
from snakemake.persistence.file import FilePersistence
from study_builders import ROOT

from snakemake_executor_plugin_tepsipe import Executor
from tepsipe import cli
from tepsipe.errors import InputError
from workflow import check, run
from workflow.support import runs

PRETEND = "import sys, time; print('here', flush=True); time.sleep(60)"


@pytest.fixture
def place(tmp_path, monkeypatch):
    (tmp_path / "config").mkdir()
    (tmp_path / "config/config.yaml").write_text("study: {}\n")
    monkeypatch.chdir(tmp_path)
    return tmp_path


@pytest.fixture
def started(monkeypatch):
    """Commands that would have been run."""
    commands = []
    monkeypatch.setattr("os.execv", lambda program, command: commands.append(command))
    monkeypatch.setattr(
        "subprocess.run", lambda command: commands.append(command) or subprocess.CompletedProcess(command, 0)
    )
    return commands


@pytest.fixture
def at_work(place):
    """Start a process in the folder that looks like another one."""
    processes = []

    def start(*arguments, folder=place):
        command = [sys.executable, *arguments]
        processes.append(subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, text=True))
        assert processes[-1].stdout.readline() == "here\n"
        return processes[-1]

    yield start
    for process in processes:
        process.kill()
        process.communicate()


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        (
            "own.yaml",
            "study:\n  seed: 1\n  name: x\n  seed: 2\n",
            "own.yaml: expected YAML, found a mistake on line 4",
        ),
        ("own.yaml", "study:\n\tseed: 1\n", "line 2"),
        ("own.yaml", "study: [1, 2\nname: x\n", "own.yaml: expected YAML"),
        (
            "own.yaml",
            "__use_yte__: true\nstudy: {}\n",
            "found the key '__use_yte__', with which Snakemake runs code",
        ),
        ("own.json", '{"study": {"seed": 1, "seed": 2}}', "found 'seed' twice"),
        ("own.yaml", "- 1\n", "expected keys and values"),
    ],
)
def test_a_configuration_that_is_not_meant_so_is_refused_before_snakemake_loads_it(
    place, started, capsys, name, content, words
):
    (place / name).write_text(content)
    assert run.main(["-c2", "--configfile", "config/config.yaml", name, "--dry-run"]) == 2
    said = capsys.readouterr().err.removeprefix("tepsipe: ")
    assert_one_sentence(said.strip(), name)
    assert words in said
    assert started == []


def test_run_becomes_snakemake_with_all_configurations_in_their_order(place, started):
    for name in ("a.yaml", "b.json"):
        (place / name).write_text("{}")
    run.main(["-c2", "--configfile", "a.yaml", "--configfile", "b.json"])
    wanted = ["-m", "snakemake", "-c2", "--rerun-incomplete", "--configfile", "a.yaml", "b.json"]
    assert started == [[sys.executable, *wanted]]


def test_lock_of_a_run_that_was_killed_is_removed(place, started, capsys):
    (place / ".snakemake/locks").mkdir(parents=True)
    run.main(["-c2"])
    assert len(started) == 1
    (place / ".snakemake/locks/0.input.lock").write_text("")
    run.main(["-c2"])
    assert started[1] == [sys.executable, "-m", "snakemake", "--unlock"]
    assert started[2][:3] == [sys.executable, "-m", "snakemake"]
    assert "the last run was killed" in capsys.readouterr().err
    # plain Snakemake stops at the lock
    with pytest.raises(InputError, match="remove it with snakemake --unlock") as caught:
        runs.refuse_a_lock()
    assert_one_sentence(caught.value, str(place))


def test_another_run_in_the_folder_is_left_alone(place, started, at_work, capsys):
    holds = f"import sys; sys.path.insert(0, {str(ROOT)!r}); from workflow.support import runs; runs.begin()"
    other = at_work("-c", f"{holds}; {PRETEND}")
    (place / ".snakemake/locks").mkdir(parents=True)
    (place / ".snakemake/locks/0.input.lock").write_text("")
    assert run.main(["-c2"]) == 2
    said = capsys.readouterr().err.removeprefix("tepsipe: ").strip()
    assert_one_sentence(said, str(place))
    assert f"found process {other.pid} at work: wait for it, or stop it with kill {other.pid}" in said
    assert started == []
    other.kill()
    other.wait()
    run.main(["-c2"])
    assert len(started) == 2


def test_a_run_keeps_the_folder_when_it_becomes_snakemake(place):
    """Of two that find the lock of a killed run, one goes on."""
    takes = (
        f"import os, sys; sys.path.insert(0, {str(ROOT)!r}); from workflow.support import runs; runs.begin()"
    )
    then = f"{takes}; print('mine', flush=True); input()"
    first = f"{takes}; os.execv(sys.executable, [sys.executable, '-c', {then!r}])"
    holds = subprocess.Popen(
        [sys.executable, "-c", first], cwd=place, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    assert holds.stdout.readline() == "mine\n"
    with pytest.raises(InputError, match=f"found process {holds.pid} at work"):
        runs.begin()
    holds.communicate("\n")
    runs.begin()


@pytest.mark.parametrize(
    ("arguments", "dry", "looks"),
    [
        (["-c2"], False, False),
        (["-np"], True, False),
        (["--dry-run"], True, False),
        (["-c1", "--configfile", "knee.yaml"], False, False),
        (["--report", "x.html"], False, True),
        (["--mode=subprocess"], False, True),
        (["--unlock"], False, True),
    ],
)
def test_a_run_that_starts_no_jobs_is_known_by_its_arguments(arguments, dry, looks):
    assert (runs.is_dry(arguments), runs.looks(arguments)) == (dry, looks)


def test_a_folder_that_cannot_be_written_to_is_one_sentence(place):
    (place / ".snakemake").write_text("")
    with pytest.raises(InputError, match="expected a folder to write to") as caught:
        runs.begin()
    assert_one_sentence(caught.value, f"{place}/.snakemake")


@pytest.mark.parametrize("executable", ["/a b/python", "/a$(touch x)/python", "/a'b/python", "/{x}/python"])
def test_an_interpreter_that_a_shell_would_not_find_is_refused(executable, monkeypatch):
    monkeypatch.setattr("sys.executable", executable)
    monkeypatch.setattr(Executor, "in_use", False)
    with pytest.raises(InputError, match="put the environment elsewhere") as caught:
        runs.refuse_interpreter()
    assert_one_sentence(caught.value, executable)
    monkeypatch.setattr(Executor, "in_use", True)
    runs.refuse_interpreter()


def test_a_param_is_compared_as_a_table_only_where_pandas_is_loaded(monkeypatch):
    table = pytest.importorskip("pandas").DataFrame({"a": [1]})
    kind = persistence.PersistenceBase
    monkeypatch.setattr(kind, "_serialize_param", kind._serialize_param)
    as_snakemake = partial(kind._serialize_param_pandas, FilePersistence.__new__(FilePersistence))
    runs.spare_pandas()
    records = FilePersistence.__new__(FilePersistence)
    params = [None, 1, 0.5, "a", ["b"], {"c": 2}, Path("d"), table]
    found = [records._serialize_param(value) for value in params]
    assert found == [as_snakemake(value) for value in params]
    assert isinstance(found[-1], str)  # by its contents
    monkeypatch.delitem(sys.modules, "pandas")
    assert [records._serialize_param(value) for value in params[:-1]] == found[:-1]
    assert "pandas" not in sys.modules


def test_lock_of_a_study_without_a_snakefile_is_removed_by_that_of_the_run(place, started):
    (place / ".snakemake/locks").mkdir(parents=True)
    (place / ".snakemake/locks/0.input.lock").touch()
    (place / "a.yaml").write_text("{}")
    run.main(["-s", "/rules/Snakefile", "-c2", "--configfile", "a.yaml"])
    study = ["--snakefile", "/rules/Snakefile", "--configfile", "a.yaml"]
    unlocked, went_on = (command[command.index("snakemake") + 1 :] for command in started)
    assert unlocked == ["--unlock", *study]
    assert went_on == ["-c2", "--rerun-incomplete", *study]


def test_run_on_another_computer_is_left_alone(place, started, capsys):
    runs.note_run()
    assert runs.elsewhere() is None
    runs.NOTE.write_text(json.dumps({"computer": "cluster-7", "started": "2026-01-02 03:04:05"}))
    assert run.main(["-c2"]) == 2
    assert "found one on cluster-7 since 2026-01-02 03:04:05" in capsys.readouterr().err
    runs.forget_run()
    run.main(["-c2"])
    assert len(started) == 1


@pytest.mark.slow
def test_jobs_that_have_lost_their_run_are_waited_for(place, started, at_work, monkeypatch, capsys):
    (place / ".snakemake/scripts").mkdir(parents=True)
    (place / ".snakemake/scripts/tmp1.fit.py").write_text(PRETEND.replace("60", "1"))
    orphan = at_work(str(place / ".snakemake/scripts/tmp1.fit.py"))
    runs.note_run()
    assert runs.jobs_alive() == [orphan.pid]
    assert not runs.wait_for_jobs(0.0)
    run.main(["-c2"])
    assert "1 jobs of a run that was killed are at work" in capsys.readouterr().err
    assert runs.jobs_alive() == []
    assert len(started) == 1


@pytest.mark.slow
def test_check_names_the_file_and_the_line(place, root, monkeypatch, capfd):
    (place / "own.yaml").write_text("study:\n  seed: 1\n  seed: 2\n")
    (place / "far.yaml").write_text("pathvars: {results: /nowhere}\n")
    (place / "good.yaml").write_text("study: {title: Mine}\n")
    monkeypatch.chdir(root)
    assert cli.main(["check", str(place / "own.yaml")]) == 2
    assert "own.yaml: expected YAML, found a mistake on line 3" in capfd.readouterr().err
    assert check.main([str(place / "far.yaml")]) == 2
    said = capfd.readouterr().err
    assert said.startswith(f"tepsipe: {place / 'far.yaml'}: expected pathvars.results in the folder")
    assert "set study.outside to true" in said
    (place / "odd.yaml").write_text("pilott: 1\n")
    assert check.main([str(place / "good.yaml"), str(place / "odd.yaml")]) == 2
    assert f"{place / 'odd.yaml'}: unknown key 'pilott'" in capfd.readouterr().err
    assert check.main([str(place / "good.yaml")]) == 0
    assert "good.yaml: 56 trials (5 of wristalyzer" in capfd.readouterr().out
    rows = (root / "config/trials.tsv").read_text().splitlines(keepends=True)
    (place / "one.tsv").write_text(rows[0] + next(row for row in rows if row.startswith("wristalyzer")))
    (place / "one.yaml").write_text(f"study: {{trial_sheet: {place / 'one.tsv'}}}\n")
    assert check.main([str(place / "one.yaml")]) == 0
    assert "one.yaml: 1 trial (1 of wristalyzer)" in capfd.readouterr().out


@pytest.mark.skipif(shutil.which("make") is None, reason="no make")
def test_make_executes_nothing_of_a_path(tmp_path, root):
    folder = tmp_path / 'a$(touch x)`touch y`"b'
    folder.mkdir()
    for name in ("Makefile", "requirements.txt", "pyproject.toml"):
        shutil.copy(root / name, folder)
    make = partial(subprocess.run, cwd=folder, capture_output=True, text=True)
    done = make(["make", "--no-print-directory", "environment", f"PYTHON={sys.executable}"])
    assert done.returncode == 2
    assert_one_sentence(done.stdout.strip(), f"tepsipe: {folder}", "rename it")
    done = make(["make", "-n", "study", f"PYTHON={sys.executable}", "CONFIG=my 's$(touch z) {x}.yaml"])
    assert r"--configfile 'my '\''s$(touch z) {x}.yaml'" in done.stdout
    assert sorted(path.name for path in folder.iterdir()) == [
        "Makefile",
        "pyproject.toml",
        "requirements.txt",
    ]
