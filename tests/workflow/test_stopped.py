"""What is said of jobs that stop: in their log, or by the run in their place."""

import errno
import json
import os
import subprocess
import sys
from types import SimpleNamespace

import numpy as np
import pytest
from builders import assert_one_sentence

from tepsipe.virtual_lab import treadmill_files
from workflow.support import runs
from workflow.support.stopped import what_stopped

SCRIPT = """
import sys
sys.path.insert(0, {scripts!r})
from types import SimpleNamespace
import job
job.start(SimpleNamespace(
    rule="fit", wildcards=["sine"], input=SimpleNamespace(), output=["results/fits/sine.h5"], log=[{log!r}]
))
{body}
"""
REFUSED = "from tepsipe.errors import InputError; raise InputError('a.mat: expected b, found c: do d')"


@pytest.fixture
def run_job(tmp_path, root):
    """Run a job's script in a folder of its own; the process and the text of its log."""
    (tmp_path / "results/fits").mkdir(parents=True)

    def run(body, log="job.log"):
        script = tmp_path / "tmpabc.fit.py"
        script.write_text(SCRIPT.format(scripts=str(root / "workflow/scripts"), log=log, body=body))
        done = subprocess.run([sys.executable, str(script)], cwd=tmp_path, capture_output=True, text=True)
        return done, (tmp_path / "job.log").read_text() if log == "job.log" else ""

    return run


def records(folder):
    return [json.loads(path.read_text()) for path in (folder / ".snakemake/tepsipe/jobs").glob("*.json")]


def test_job_that_ends_leaves_an_empty_log_and_no_record(run_job, tmp_path):
    done, log = run_job("assert __import__('os').path.exists('.snakemake/tepsipe/jobs/tmpabc.fit.json')")
    assert (done.returncode, log) == (0, "")
    assert records(tmp_path) == []


@pytest.mark.parametrize(
    ("body", "words"),
    [
        (REFUSED, "a.mat: expected b"),
        ("open('/dev/full', 'w').write('x' * 100000)", "expected space for the outputs, found the disk full"),
        (
            "raise OSError('Unable to write (errno = 28, error ...)')",
            "results/fits: expected space",
        ),
        ("raise RuntimeError('typst: No space left on device')", "found the disk full"),
        ("raise PermissionError(13, 'denied', 'results/fits/sine.h5')", "sine.h5: expected permission"),
        (
            "raise OSError(30, 'Read-only file system', 'results/fits/x')",
            "results/fits/x: expected permission",
        ),
        ("raise MemoryError", "expected enough memory"),
        ("raise KeyboardInterrupt", "found it interrupted"),
        (
            "import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (5000, 5000))\n"
            "open('results/fits/x', 'w').write('x' * 90000)",
            "found the limit of file sizes",
        ),
    ],
)
def test_job_says_in_one_sentence_what_the_system_refused(run_job, tmp_path, body, words):
    done, log = run_job(body)
    assert done.returncode != 0
    assert log.startswith("tepsipe: fit/sine: ")
    assert_one_sentence(log.strip(), "tepsipe: fit/sine")
    assert words in log
    assert records(tmp_path) == []


def test_a_bug_leaves_its_trace(run_job):
    done, log = run_job("{}['nothing']")
    assert "KeyError" in log
    assert done.returncode == 1


def a_job(log, rule="fit"):
    return SimpleNamespace(rule=rule, wildcards=["sine"], log=[log])


def test_sentence_that_finds_no_place_in_the_log_is_kept_in_the_record(run_job, tmp_path, monkeypatch):
    (tmp_path / "logs").mkdir()
    done, _ = run_job(f"import shutil; shutil.rmtree('logs')\n{REFUSED}", "logs/job.log")
    assert "expected b" in done.stderr
    monkeypatch.chdir(tmp_path)
    assert what_stopped([a_job("logs/job.log")]) == ["tepsipe: fit/sine: a.mat: expected b, found c: do d"]


@pytest.mark.parametrize(
    ("number", "name", "words"),
    [(9, "SIGKILL", "memory"), (11, "SIGSEGV", "compiled library"), (15, "SIGTERM", "limit of time")],
)
@pytest.mark.parametrize("by_a_shell", [False, True])
def test_job_that_a_signal_stopped_is_named_with_the_signal(
    run_job, tmp_path, monkeypatch, number, name, words, by_a_shell
):
    done, _ = run_job(f"import os; os.kill(os.getpid(), {number})")
    assert done.returncode == -number
    died = f"died with <Signals.{name}: {number}>."
    ended = f"returned non-zero exit status {128 + number}." if by_a_shell else died
    (tmp_path / "run.log").write_text(
        "Command 'python tmpother.fit.py' died with <Signals.SIGFPE: 8>.\n"
        f"Command 'set -euo pipefail;  python /x/.snakemake/scripts/tmpabc.fit.py' {ended}\n"
    )
    monkeypatch.chdir(tmp_path)
    (said,) = what_stopped([a_job("job.log")], "run.log")
    assert f"fit/sine: expected the job to end by itself, found it stopped by the signal {name}" in said
    assert words in said
    assert (tmp_path / "job.log").read_text() == f"{said}\n"
    runs.note_run()
    assert records(tmp_path) == []


def test_job_that_was_killed_before_its_record_is_named_by_its_rule(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "run.log").write_text("Command 'python /x/tmp_a1.fit.py' died with <Signals.SIGKILL: 9>.\n")
    rule = SimpleNamespace(script="../scripts/fit.py")
    (said,) = what_stopped([a_job("a.log", rule)], "run.log")
    assert "stopped by the signal SIGKILL" in said


def test_job_that_says_nothing_is_named_all_the_same(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.log").write_text("")
    (tmp_path / "bug.log").write_text("Traceback ...\nKeyError: 'x'\n")
    said = what_stopped([a_job("a.log"), a_job("bug.log", "other")], "run.log")
    nothing = "expected the job to say why it stopped, found nothing: see run.log, then run again"
    assert said[0] == f"tepsipe: fit/sine: {nothing}"
    assert said[1] == "tepsipe: other/sine: a bug, see bug.log"


def test_a_full_disk_is_named_where_not_even_a_log_could_be_written(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("shutil.disk_usage", lambda path: SimpleNamespace(free=1000))
    (said,) = what_stopped([a_job("a.log")])
    assert f"{tmp_path}: expected space for the run, found the disk full" in said
    assert errno.ENOSPC == 28  # the number in HDF5's messages


def test_markers_that_find_no_space_are_no_shorter_file(tmp_path, monkeypatch):
    write = treadmill_files.ezc3d.c3d.write

    def on_a_full_disk(self, path):
        """What fits is written, and nothing is said."""
        write(self, path)
        os.truncate(path, 2000)

    monkeypatch.setattr(treadmill_files.ezc3d.c3d, "write", on_a_full_disk)
    with pytest.raises(OSError, match="No space left on device"):
        treadmill_files.write_markers(tmp_path / "m.c3d", ("a", "b"), np.zeros((100, 2, 3)), 250.0)
