"""Snakemake executor ``warm``: the scripts of all jobs, one after the other, in forks of one warm process.

A job of Snakemake's own executor is a new Python, which takes 1.3 s to import what it needs. A fork has it
already. Everything else is Snakemake's: the graph, its checks, outputs of jobs that stop, records of what has
been done. A run takes one core, however many it is given: laboratories run side by side, not their jobs.

    PYTHONPATH=workflow/plugins snakemake --executor warm -c1

What stopped a job stands in ``.snakemake/tepsipe/stopped.json``: its rule, log, sentence, and whether the
same would happen again (``lasting``), or not, as after a signal or with a full disk.
"""

import atexit
import ctypes
import gc
import importlib
import json
import os
import pkgutil
import runpy
import sys
from contextlib import suppress
from pathlib import Path

from snakemake.script import Snakemake
from snakemake_interface_executor_plugins.executors.base import SubmittedJobInfo
from snakemake_interface_executor_plugins.executors.real import RealExecutor
from snakemake_interface_executor_plugins.settings import CommonSettings

common_settings = CommonSettings(
    non_local_exec=False,
    implies_no_shared_fs=False,
    job_deploy_sources=False,
    pass_envvar_declarations_to_cmd=True,
    auto_deploy_default_storage_provider=False,
)

STOPPED = Path(".snakemake") / "tepsipe" / "stopped.json"
SCRIPTS = Path(__file__).parents[2] / "scripts"
# errors of the machine, not of the study: the same job may succeed when it is run again
PASSING = (OSError, MemoryError, KeyboardInterrupt)
FAILED, PASSED = 1, 3
# packages of the library that scripts of rules import; figures need more, and import it themselves
LIBRARY = (
    "experiments",
    "identification",
    "io",
    "mechanics",
    "signals",
    "statistics",
    "treadmill",
    "virtual_lab",
)
# of malloc.h
M_TRIM_THRESHOLD, M_TOP_PAD, M_MMAP_THRESHOLD = -1, -2, -3


class Executor(RealExecutor):
    """Runs one job at a time, and returns when it has ended."""

    def __post_init__(self):
        for library in ("OMP", "OPENBLAS", "MKL"):
            os.environ[f"{library}_NUM_THREADS"] = "1"
        sys.path.insert(0, str(SCRIPTS))
        _warm_up()

    def run_job(self, job):
        """Run the job's script in a fork, and tell Snakemake how it ended."""
        info = SubmittedJobInfo(job=job)
        self.workflow.async_run(job.prepare())
        self.report_job_submission(info)
        if job.is_norun:  # the rule of all outputs has no script
            self.report_job_success(info)
            return
        status = _in_a_fork(job)
        if status == 0:
            self.report_job_success(info)
            return
        log = str(job.log[0])
        said = Path(log).read_text(encoding="utf-8").strip() if Path(log).is_file() else ""
        STOPPED.parent.mkdir(parents=True, exist_ok=True)
        found = {"rule": job.rule.name, "log": log, "said": said, "lasting": status == FAILED}
        STOPPED.write_text(json.dumps(found), encoding="utf-8")
        self.report_job_error(info)

    def shutdown(self):
        """Nothing is left to end: jobs have ended when `run_job` returns."""

    cancel = shutdown

    def get_exec_mode(self):
        """Never asked: no further Snakemake is started."""
        raise NotImplementedError

    get_python_executable = get_exec_mode

    @property
    def cores(self):
        """Of this run (-)."""
        return self.workflow.resource_settings.cores


def _warm_up() -> None:
    """Import once what scripts need, and let forks use their memory again and again."""
    import ezc3d  # noqa: F401
    import h5py  # noqa: F401
    import scipy

    import tepsipe.io.hdf5_file
    import tepsipe.reporting.recovery

    for package in (
        "fft",
        "interpolate",
        "io",
        "linalg",
        "ndimage",
        "optimize",
        "signal",
        "special",
        "stats",
    ):
        getattr(scipy, package)
    for package in LIBRARY:
        found = importlib.import_module(f"tepsipe.{package}")
        for module in pkgutil.walk_packages(found.__path__, f"{found.__name__}."):
            importlib.import_module(module.name)
    # a fork reads what this run has written, and a fork that crashes ends nothing else
    tepsipe.io.hdf5_file.read_directly()
    _keep_memory()
    # a collection in a fork would copy every page that this process shares with it
    gc.freeze()


def _keep_memory() -> None:
    """Let the C library keep what arrays free: giving it back costs a fault per page at the next array."""
    with suppress(OSError, AttributeError):
        mallopt = ctypes.CDLL(None).mallopt
        for option, bytes_ in (
            (M_MMAP_THRESHOLD, 32 << 20),
            (M_TRIM_THRESHOLD, 512 << 20),
            (M_TOP_PAD, 16 << 20),
        ):
            mallopt(option, bytes_)


def _in_a_fork(job) -> int:
    """Exit status of the job's script: 0, `FAILED`, `PASSED`, or minus the signal that ended it."""
    sys.stdout.flush()
    sys.stderr.flush()
    child = os.fork()
    if child == 0:
        os._exit(_run(job))
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def _run(job) -> int:
    """Run the script as Snakemake does it, in this process, and everything that it wants done at exit."""
    atexit._clear()
    script = SCRIPTS / Path(str(job.rule.script)).name
    sys.argv = [str(script.with_name(f"{job.jobid}.{script.name}"))]
    status = 0
    try:
        runpy.run_path(str(script), {"snakemake": _seen_by_the_script(job)}, run_name="__main__")
    except SystemExit as error:
        status = FAILED if error.code else 0
    except BaseException as error:
        sys.excepthook(*sys.exc_info())
        status = PASSED if isinstance(error, PASSING) else FAILED
    atexit._run_exitfuncs()
    sys.stdout.flush()
    sys.stderr.flush()
    return status


def _seen_by_the_script(job) -> Snakemake:
    """The object ``snakemake`` of a script."""
    return Snakemake(
        job.input._plainstrings(),
        job.output._plainstrings(),
        job.params,
        job.wildcards,
        job.threads,
        job.resources,
        job.log._plainstrings(),
        job.rule.workflow.config,
        job.rule.name,
        None,
        str(SCRIPTS),
    )
