"""Snakemake for the tests: forks of one process that has imported it, as the command line would run it.

A start of Python and the imports take half of the time of a dry run, and as long again where jobs run, whose
fork server is such a fork, too. Each call is a fork of its own, in the folder of its study, whose code it
imports; nothing remains of it in this process.
"""

import gc
import importlib
import json
import os
import signal
import subprocess
import sys
import tempfile
import traceback
from functools import partial
from multiprocessing import forkserver, util
from pathlib import Path

# of others: what a study imports of this project belongs to the study's own copy
PACKAGES = ("snakemake.cli", "snakemake.report.html_reporter", "pydantic", "yaml")
# what Snakemake imports only when it has read a study
LATER = ("pandas", "jinja2", "requests", "smart_open", "nbformat", "argparse_dataclass", "platformdirs")
# what jobs import, as in workflow/support/preload.py
OF_JOBS = (
    *("edfio", "ezc3d", "h5py"),
    *("matplotlib.figure", "matplotlib.backends.backend_svg", "matplotlib.backends.backend_agg"),
    *(f"scipy.{name}" for name in ("fft", "interpolate", "io", "linalg", "ndimage", "optimize", "signal")),
    *("scipy.special", "scipy.stats"),
)
AS_USUAL = subprocess.run


class WarmSnakemake:
    """A process that runs Snakemake in forks, in this environment or a given one; it ends with this one."""

    def __init__(self, env=None):
        self._process = subprocess.Popen(
            [sys.executable, __file__], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=env
        )

    def run(self, arguments, folder, module="snakemake"):
        """What ``subprocess.run`` would return of ``python -m snakemake`` in a folder, or of workflow.run."""
        return self.start(arguments, folder, module)[1]()

    def start(self, arguments, folder, module="snakemake"):
        """Process id of a run, the first of a session of its own, and what waits for its end, as `run` does.

        No other begins before it has ended.
        """
        temporary = tempfile.TemporaryDirectory()
        said = [str(Path(temporary.name) / name) for name in ("stdout", "stderr")]
        call = {"arguments": list(arguments), "folder": str(folder), "said": said, "module": module}
        self._process.stdin.write(json.dumps(call) + "\n")
        self._process.stdin.flush()
        process = int(self._process.stdout.readline())

        def ended():
            status = int(self._process.stdout.readline())
            with temporary:
                texts = [Path(path).read_text(encoding="utf-8", errors="replace") for path in said]
            return subprocess.CompletedProcess(call["arguments"], status, *texts)

        return process, ended


def serve():
    """Answer every line of the standard input with a process id and, later, an exit status."""
    for package in (*PACKAGES, *LATER, *OF_JOBS):
        importlib.import_module(package)
    sys.modules["snakemake.cli"].get_argument_parser()  # finds Snakemake's plugins, once for all forks
    gc.freeze()  # a collection in a fork would copy every page that it shares with this process
    for line in sys.stdin:
        call = json.loads(line)
        child = os.fork()
        if child == 0:
            os._exit(run(**call))
        print(child, flush=True)
        print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), flush=True)


def fork_server(otherwise, run, path, arguments, kept):
    """Start the server of jobs as a fork of this process instead of a new Python; other programs as usual.

    run: number of the process that runs Snakemake. A job that starts jobs of its own has threads, with which
    no fork is safe.
    kept: numbers of the files that it takes over.
    """
    if "multiprocessing.forkserver" not in arguments[-1] or os.getpid() != run:
        return otherwise(path, arguments, kept)
    sys.stdout.flush()
    sys.stderr.flush()
    child = os.fork()
    if child == 0:
        try:
            for number in (signal.SIGTERM, signal.SIGHUP):  # which Snakemake handles
                signal.signal(number, signal.SIG_DFL)
            nothing = os.open(os.devnull, os.O_RDWR)
            opened = {int(link.name) for link in Path("/proc/self/fd").iterdir()}
            for number in opened - {0, 1, 2, nothing, *kept}:
                os.dup2(nothing, number)  # closed, and its number not given to another file
            forkserver._forkserver.__init__()  # its lock is held here; a job may start jobs of its own
            exec(arguments[-1], {})
        finally:
            os._exit(0)
    return child


def in_a_fork(command, **options):
    """Run Snakemake in a fork of this process instead of a new Python; other programs as usual."""
    if command[:3] != [sys.executable, "-m", "snakemake"]:
        return AS_USUAL(command, **options)
    with tempfile.TemporaryDirectory() as folder:
        said = [str(Path(folder) / name) for name in ("stdout", "stderr")]
        child = os.fork()
        if child == 0:
            os._exit(run(command[3:], Path.cwd(), said, "snakemake"))
        status = os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
        texts = [Path(path).read_text(encoding="utf-8", errors="replace") for path in said]
    return subprocess.CompletedProcess(command, status, *texts)


def run(arguments, folder, said, module):
    """Exit status of Snakemake in a folder, or of what becomes Snakemake; what it says goes to two files."""
    from snakemake.cli import main

    os.setsid()
    # Ctrl-C is not heard by a run whose shell started the tests in the background
    signal.signal(signal.SIGINT, signal.default_int_handler)
    nothing = os.open(os.devnull, os.O_RDONLY)
    os.dup2(nothing, 0)
    for stream, path in zip((1, 2), said, strict=True):
        os.dup2(os.open(path, os.O_WRONLY | os.O_CREAT), stream)
    util.spawnv_passfds = partial(fork_server, util.spawnv_passfds, os.getpid())
    os.chdir(folder)
    sys.path[0] = str(folder)

    def become(_, command):
        subprocess.run = AS_USUAL
        given = command[command.index("snakemake") + 1 :]
        sys.argv = [str(Path(sys.modules["snakemake"].__file__).with_name("__main__.py")), *given]
        main(given)

    status = 0
    try:
        if module == "snakemake":
            become(None, [module, *arguments])
        else:
            os.execv = become
            # before it becomes Snakemake: no fork of a process in which Snakemake is at work can run another
            subprocess.run = in_a_fork
            status = importlib.import_module(module).main(arguments)
    except SystemExit as error:
        if isinstance(error.code, str):
            print(error.code, file=sys.stderr)
        status = error.code if isinstance(error.code, int) else int(error.code is not None)
    except BaseException:
        traceback.print_exc()
        status = 1
    sys.stdout.flush()
    sys.stderr.flush()
    return status


if __name__ == "__main__":
    serve()
