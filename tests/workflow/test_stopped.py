"""What is said of jobs that stop: in their log, or by the run in their place."""

import errno
import os
import subprocess
import sys
from types import SimpleNamespace

import ezc3d
import numpy as np
import pytest
from builders import assert_one_sentence

from tepsipe.virtual_lab import treadmill_trial
from workflow.support import runs
from workflow.support.stopped import note_end, records, what_stopped

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


def test_job_that_ends_leaves_an_empty_log_and_no_record(run_job, tmp_path):
    done, log = run_job("from workflow.support.stopped import records; assert len(records()) == 1")
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
    (record,) = records(tmp_path)
    assert record["said"] == log.strip()
    # the system may have room later; unusable input stays so
    assert record["lasting"] == (body == REFUSED)


def test_a_bug_leaves_its_trace(run_job, tmp_path, monkeypatch):
    done, log = run_job("{}['nothing']")
    assert "KeyError" in log
    assert done.returncode == 1
    (record,) = records(tmp_path)
    assert (record["said"], record["lasting"]) == ("KeyError: 'nothing'", True)
    monkeypatch.chdir(tmp_path)
    assert what_stopped("run.log") == ["tepsipe: fit/sine: a bug, see job.log"]
    run_job(r"raise RuntimeError('several\nlines\n')")
    assert records()[0]["said"] == "lines"


def test_sentence_that_finds_no_place_in_the_log_is_kept_in_the_record(run_job, tmp_path, monkeypatch):
    (tmp_path / "logs").mkdir()
    done, _ = run_job(f"import shutil; shutil.rmtree('logs')\n{REFUSED}", "logs/job.log")
    assert "expected b" in done.stderr
    monkeypatch.chdir(tmp_path)
    assert what_stopped("run.log") == ["tepsipe: fit/sine: a.mat: expected b, found c: do d"]


@pytest.mark.parametrize(
    ("number", "name", "words"),
    [(9, "SIGKILL", "memory"), (11, "SIGSEGV", "compiled library"), (15, "SIGTERM", "limit of time")],
)
def test_job_that_a_signal_stopped_is_named_with_the_signal(
    run_job, tmp_path, monkeypatch, number, name, words
):
    done, _ = run_job(f"import os; os.kill(os.getpid(), {number})")
    monkeypatch.chdir(tmp_path)
    note_end("fit/sine", "job.log", done.returncode)
    (said,) = what_stopped("run.log")
    assert f"fit/sine: expected the job to end by itself, found it stopped by the signal {name}" in said
    assert words in said
    assert (tmp_path / "job.log").read_text() == f"{said}\n"
    runs.note_run()
    assert records(tmp_path) == []


def test_job_that_was_killed_before_its_record_is_named_by_its_rule(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    note_end("fit/sine", "a.log", -9)
    (said,) = what_stopped("run.log")
    assert "fit/sine: expected the job to end by itself, found it stopped by the signal SIGKILL" in said
    note_end("fit/sine", "a.log", 0)  # tried again
    assert records() == []


def test_what_a_job_has_said_is_not_replaced(run_job, tmp_path, monkeypatch):
    done, log = run_job(REFUSED)
    monkeypatch.chdir(tmp_path)
    note_end("fit/sine", "job.log", done.returncode)
    assert what_stopped("run.log") == [log.strip()]
    assert (tmp_path / "job.log").read_text() == log


def test_job_that_says_nothing_is_named_all_the_same(run_job, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    note_end("fit/sine", "a.log", 1)
    nothing = "expected the job to say why it stopped, found nothing: see run.log, then run again"
    assert what_stopped("run.log") == [f"tepsipe: fit/sine: {nothing}"]
    # nobody saw how this one ended
    run_job("import os; os.kill(os.getpid(), 9)")
    assert what_stopped("run.log") == [f"tepsipe: fit/sine: {nothing}"] * 2
    runs.note_run()
    assert what_stopped("run.log") == [f"tepsipe: {nothing}"]


def test_a_full_disk_is_named_where_not_even_a_log_could_be_written(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("shutil.disk_usage", lambda path: SimpleNamespace(free=1000))
    (said,) = what_stopped("run.log")
    assert f"{tmp_path}: expected space for the run, found the disk full" in said
    assert errno.ENOSPC == 28  # the number in HDF5's messages


def test_markers_that_find_no_space_are_no_shorter_file(tmp_path, monkeypatch):
    write = ezc3d.c3d.write

    def on_a_full_disk(self, path):
        """What fits is written, and nothing is said."""
        write(self, path)
        os.truncate(path, 2000)

    monkeypatch.setattr(ezc3d.c3d, "write", on_a_full_disk)
    with pytest.raises(OSError, match="No space left on device"):
        treadmill_trial.write_markers(tmp_path / "m.c3d", ("a", "b"), np.zeros((100, 2, 3)), 250.0)
