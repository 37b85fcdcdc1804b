"""Scripts of jobs in forks of the run's warm process: they end as they would by themselves."""

import os
import signal
import subprocess
import sys

import psutil
import pytest

from workflow.support import warm

SCRIPT = """
import os, sys
sys.path.insert(0, {root!r})
from workflow.support.warm import hand_over
before = os.getpid()
hand_over()
{body}
"""
FORKED = "sys.modules.get('h5py') is not None"  # the script itself has imported nothing


@pytest.fixture(scope="module")
def server():
    """The warm process of a run."""
    if sys.platform != "linux":
        pytest.skip("there is a warm process on Linux only")
    warm.start(warm.FEWEST_JOBS)
    yield os.environ[warm.VARIABLE]
    process = warm._Server.process
    warm.stop()
    assert process.poll() == 0
    assert warm.VARIABLE not in os.environ


@pytest.fixture
def script(tmp_path, root):
    """Start a script that hands itself over."""

    def start(body, **environment):
        path = tmp_path / "job.py"
        path.write_text(SCRIPT.format(root=str(root), body=body))
        return subprocess.Popen(
            [sys.executable, str(path)],
            cwd=tmp_path,
            env=os.environ | environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    return start


def ended(process):
    said, complaint = process.communicate(timeout=60)
    return process.returncode, said, complaint


def test_a_fork_has_the_folder_the_environment_and_the_streams_of_its_script(server, script, tmp_path):
    body = f"print({FORKED}, os.getcwd(), os.environ['OWN'], sys.argv, __name__)"
    status, said, complaint = ended(script(body, OWN="value"))
    assert (status, complaint) == (0, "")
    assert said.split() == ["True", str(tmp_path), "value", f"['{tmp_path}/job.py']", "__main__"]


def test_it_does_what_is_to_be_done_at_the_end(server, script):
    assert ended(script("import atexit; atexit.register(print, 'last')"))[1] == "last\n"


@pytest.mark.parametrize(
    ("body", "expected"),
    [
        ("sys.exit(0)", 0),
        ("sys.exit('no')", 1),
        ("raise ValueError('no')", 1),
        ("os._exit(7)", 7),
        ("os.kill(os.getpid(), 9)", -9),
        ("os.kill(os.getpid(), 11)", -11),
        ("os.kill(os.getpid(), 15)", -15),
    ],
)
def test_a_script_ends_as_its_fork(server, script, body, expected):
    status, _, complaint = ended(script(body))
    assert status == expected
    assert ("ValueError: no" in complaint) == ("ValueError" in body)


def forked(process):
    """The fork of a script that prints its process number."""
    return psutil.Process(int(process.stdout.readline()))


WAITING = "import time; print(os.getpid(), flush=True); time.sleep(60)"


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGTERM])
def test_whoever_kills_a_script_ends_its_fork(server, script, number):
    process = script(WAITING)
    fork = forked(process)
    assert fork.pid != process.pid
    process.send_signal(number)
    assert process.wait(60) == -number
    assert psutil.wait_procs([fork], 30)[1] == []


def test_an_interrupted_script_interrupts_its_fork(server, script):
    process = script(f"try:\n    {WAITING}\nexcept KeyboardInterrupt:\n    print('interrupted')")
    assert forked(process).pid != process.pid
    process.send_signal(signal.SIGINT)
    assert ended(process)[:2] == (0, "interrupted\n")


def test_a_script_without_the_process_runs_by_itself(script, server):
    gone = server.replace("tepsipe-", "tepsipe-no-")
    other = server.replace(sys.executable, "/another/python")
    for value in ("", "nonsense", gone, other):
        assert (
            ended(script(f"print({FORKED}, os.getpid() == before)", TEPSIPE_WARM=value))[1] == "False True\n"
        )


def test_a_run_of_few_jobs_has_none(server):
    kept = warm._Server.process
    warm.start(warm.FEWEST_JOBS - 1)
    assert warm.VARIABLE not in os.environ
    assert warm._Server.process is kept
    os.environ[warm.VARIABLE] = server


def test_forks_end_with_the_process(script):
    if sys.platform != "linux":
        pytest.skip("there is a warm process on Linux only")
    kept = warm._Server.process, os.environ.get(warm.VARIABLE, "")
    try:
        warm.start(warm.FEWEST_JOBS)
        process = script(WAITING)
        fork = forked(process)
        warm._Server.process.kill()
        assert process.wait(60) == -signal.SIGKILL  # as where memory runs out
        assert psutil.wait_procs([fork], 30)[1] == []
    finally:
        warm.stop()
        warm._Server.process, os.environ[warm.VARIABLE] = kept
