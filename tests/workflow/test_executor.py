"""Jobs under the study's own executor and under Snakemake's: how they end, and what is said of it."""

import multiprocessing
import os
import shutil
import signal
import subprocess
import sys
import time
from types import SimpleNamespace

import psutil
import pytest
from study_builders import warm_process

from snakemake_executor_plugin_tepsipe import run_script
from workflow.support.stopped import records

pytestmark = pytest.mark.slow

SNAKEFILE = """
import sys
sys.path.insert(0, workflow.basedir)
from workflow.support.stopped import what_stopped

NAMES = {names!r}


rule all:
    input:
        expand("out/{{name}}.txt", name=NAMES),


rule made:
    input:
        library="library",
    output:
        "out/{{name}}.txt",
    log:
        "logs/{{name}}.log",
    params:
        number=7,
    script:
        "workflow/scripts/made.py"


onerror:
    print("What stopped:", *what_stopped(next(iter(log))), sep="\\n", file=sys.stderr)
"""
SCRIPT = """
import job
job.start(snakemake)
import os, signal, sys, time
from pathlib import Path
from tepsipe.errors import InputError
name, output = snakemake.wildcards.name, Path(snakemake.output[0])
loaded = {"h5py", "tepsipe.io.names"} <= sys.modules.keys()
output.write_text("begun")
if name == "bug":
    raise ValueError("no")
if name == "refused":
    raise InputError("a.mat: expected b, found c: do d")
if name in signal.__dict__:
    os.kill(os.getpid(), signal.Signals[name])
if name.startswith("slow"):
    time.sleep(1.5)
if name == "waits":
    Path("pid").write_text(str(os.getpid()))
    time.sleep(60)
output.write_text(f"{snakemake.params.number} {Path.cwd()} {os.environ['OPENBLAS_NUM_THREADS']} {loaded}")
"""


@pytest.fixture
def project(tmp_path, root):
    """Write a small project whose jobs have these names; its scripts begin as those of the study do.

    What jobs are forked from has imported nothing, unless ``preloaded``: imports take most of a short run.
    """

    def write(*names, preloaded=False):
        (tmp_path / "workflow/scripts").mkdir(parents=True)
        (tmp_path / "workflow/support").mkdir()
        for part in (
            "tepsipe",
            *(f"workflow/support/{p.name}" for p in (root / "workflow/support").glob("*")),
        ):
            (tmp_path / part).symlink_to(root / part)
        if not preloaded:
            (tmp_path / "workflow/support/preload.py").unlink()
            (tmp_path / "workflow/support/preload.py").write_text("")
        shutil.copy(root / "workflow/scripts/job.py", tmp_path / "workflow/scripts")
        (tmp_path / "workflow/scripts/made.py").write_text(SCRIPT)
        (tmp_path / "library").write_text("0  tepsipe/io/names.py\n")
        (tmp_path / "Snakefile").write_text(SNAKEFILE.format(names=names))
        return tmp_path

    return write


def arguments(executor):
    return ["-c2", "--keep-going", "--executor", executor]


def job_at_work(folder):
    """The process of the job that waits."""
    deadline = time.monotonic() + 60.0
    while not (folder / "pid").is_file() or not (folder / "pid").read_text():
        assert time.monotonic() < deadline
        time.sleep(0.05)
    return psutil.Process(int((folder / "pid").read_text()))


def has_ended(process, within_s=10.0):
    return psutil.wait_procs([process], within_s)[1] == []


@pytest.mark.parametrize("limit", [(), ("--max-jobs-per-timespan", "99/1s")])
def test_snakemake_looks_for_a_job_when_one_has_ended_and_in_between_only_if_told(project, limit):
    names = [f"slow{k}" for k in range(6)]
    folder = project(*names)
    run = warm_process().run(["-c2", "--executor", "tepsipe", "--verbose", *limit], folder)
    said = run.stdout + run.stderr
    assert run.returncode == 0, said
    assert all((folder / f"out/{name}.txt").is_file() for name in names)
    assert (said.count("Ready jobs: ") > len(names) + 1) == bool(limit)


@pytest.mark.parametrize("executor", ["tepsipe", "local"])
def test_a_job_that_stops_is_named_and_the_others_go_on(project, executor):
    folder = project("good", "bug", "refused", "SIGKILL", "SIGSEGV", "also", preloaded=True)
    if executor == "tepsipe":  # in a Python of its own, whose jobs find loaded what it has loaded for them
        command = [sys.executable, "-m", "snakemake", *arguments(executor)]
        run = subprocess.run(command, cwd=folder, capture_output=True, text=True)
    else:
        run = warm_process().run(arguments(executor), folder)
    said = run.stderr.partition("What stopped:\n")[2].splitlines()
    assert run.returncode == 1
    for name in ("good", "also"):
        loaded = executor == "tepsipe" and sys.platform == "linux"
        assert (folder / f"out/{name}.txt").read_text() == f"7 {folder} 1 {loaded}"
        assert (folder / f"logs/{name}.log").read_text() == ""
    assert [path.stem for path in sorted((folder / "out").iterdir())] == ["also", "good"]
    assert "ValueError: no" in (folder / "logs/bug.log").read_text()
    logged = {name: (folder / f"logs/{name}.log").read_text() for name in ("SIGKILL", "SIGSEGV", "refused")}
    if executor == "tepsipe":
        signals = [
            "found it stopped by the signal SIGKILL, as where memory runs out",
            "found it stopped by the signal SIGSEGV, an error in a compiled library",
        ]
        assert signals[0] in logged["SIGKILL"] and signals[1] in logged["SIGSEGV"]
    else:  # nobody has seen how the process ended, only that it did
        signals = ["expected the job to say why it stopped, found nothing: see "] * 2
    assert said[0].startswith("tepsipe: made/SIGKILL: expected the job to ") and signals[0] in said[0]
    assert said[1].startswith("tepsipe: made/SIGSEGV: expected the job to ") and signals[1] in said[1]
    assert said[2] == "tepsipe: made/bug: a bug, see logs/bug.log"
    assert said[3] == "tepsipe: made/refused: a.mat: expected b, found c: do d"
    assert logged["refused"] == f"{said[3]}\n"


def test_a_run_that_is_killed_ends_its_jobs(project):
    folder = project("good", "waits")
    run, ended = warm_process().start(arguments("tepsipe"), folder)
    job = job_at_work(folder)
    while len(found := records(folder)) > 1:  # of the job that ends well none remains
        time.sleep(0.05)
    assert [(record["about"], record["said"]) for record in found] == [("made/waits", "")]
    servers = [process for process in psutil.Process(run).children(recursive=True) if process != job]
    os.kill(run, signal.SIGKILL)
    assert ended().returncode == -signal.SIGKILL
    assert has_ended(job)
    assert all(has_ended(server) for server in servers)
    assert (folder / "out/waits.txt").read_text() == "begun"
    # Snakemake knows that this output is incomplete
    (folder / "workflow/scripts/made.py").write_text(SCRIPT.replace("sleep(60)", "sleep(0)"))
    again = warm_process().run(["-c1", "--nolock", "--rerun-incomplete", "--executor", "tepsipe"], folder)
    assert again.returncode == 0, again.stderr
    assert (folder / "out/waits.txt").read_text().startswith("7 ")


@pytest.mark.parametrize("to_all", [False, True])
def test_an_interrupted_run_ends_its_jobs(project, to_all):
    folder = project("waits")
    run, ended = warm_process().start(arguments("tepsipe"), folder)
    job = job_at_work(folder)
    if to_all:  # as Ctrl-C in a terminal does it
        os.killpg(run, signal.SIGINT)
    else:
        os.kill(run, signal.SIGINT)
    done = ended()
    said = done.stdout + done.stderr
    assert has_ended(job)
    assert done.returncode == 1
    assert ("found it interrupted" if to_all else "signal SIGTERM") in said.partition("What stopped:")[2]
    assert "Traceback" not in said


@pytest.mark.skipif(sys.platform != "linux", reason="jobs are forks on Linux only")
def test_a_job_ends_with_the_process_that_forked_it(project):
    folder = project("waits")
    _, ended = warm_process().start(arguments("tepsipe"), folder)
    job = job_at_work(folder)
    job.parent().kill()
    run = ended()
    assert has_ended(job)
    stopped = "made/waits: expected the job to end by itself, found it stopped by the signal SIGKILL"
    assert stopped in run.stderr
    assert run.returncode == 1


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("sys.exit(0)", 0),
        ("sys.exit('no')", 1),
        ("raise ValueError('no')", 1),
        ("os._exit(7)", 7),
        ("os.kill(os.getpid(), 9)", -9),
        ("os.kill(os.getpid(), 15)", -15),
        ("assert snakemake.rule == 'x' and __name__ == '__main__' and sys.argv == [__file__]", 0),
    ],
)
def test_the_process_of_a_job_ends_as_its_script(tmp_path, body, expected):
    script = tmp_path / "script.py"
    script.write_text(f"import os, sys\n{body}\n")
    job = SimpleNamespace(rule="x", wildcards={}, output=[], log=["x.log"])
    processes = multiprocessing.get_context("spawn")
    process = processes.Process(target=run_script, args=(script, tmp_path, job))
    process.start()
    process.join(60)
    assert process.exitcode == expected
