"""Snakemake executor ``tepsipe``: every job's script in a process that has imported what it needs.

A job of Snakemake's own executor is a new Python, which imports for 1.3 s before it computes anything. Here
the fork server of Python's standard library imports once (`workflow/support/preload.py`), and each job is a
fork of it. Where processes cannot be forked safely (macOS, Windows), each job is a new Python after all.

`profiles/default` selects this executor; ``snakemake --executor local`` does without it. Scripts and results
are the same for both. A job ends with the run that started it, also if the run is killed.
"""

import asyncio
import contextlib
import multiprocessing
import os
import runpy
import signal
import sys
import threading
from multiprocessing import connection, forkserver
from pathlib import Path
from types import SimpleNamespace

from snakemake_interface_executor_plugins.executors.base import SubmittedJobInfo
from snakemake_interface_executor_plugins.executors.real import RealExecutor
from snakemake_interface_executor_plugins.settings import CommonSettings

common_settings = CommonSettings(
    non_local_exec=False,
    implies_no_shared_fs=False,
    job_deploy_sources=False,
    auto_deploy_default_storage_provider=False,
)

FORKS = sys.platform == "linux"
PRELOADED = ("snakemake.cli", __name__, "workflow.support.preload")
MODULES = "TEPSIPE_MODULES"  # names of further modules to import, for `workflow/support/preload.py`
FAILED = 1
USUAL_LIMIT = (100, 1.0)  # Snakemake's jobs per seconds
SERVER_ENDED = 255  # exit code that multiprocessing gives to a job whose fork server was killed
LONGEST_END_S = 2.0


class Executor(RealExecutor):
    """Starts a process per job, and tells Snakemake when it has ended."""

    in_use = False  # whether this executor runs the jobs of this Snakemake

    def __post_init__(self):
        Executor.in_use = True
        self.processes = multiprocessing.get_context("forkserver" if FORKS else "spawn")
        self.at_work = {}  # thread that waits for a job -> process of the job
        self.lock = threading.Lock()
        self.serves = False  # whether the fork server has been started
        if FORKS:
            self.processes.set_forkserver_preload(list(PRELOADED))

    def run_job(self, job):
        """Start the process of a job, and a thread that waits for it."""
        info = SubmittedJobInfo(job=job)
        self._without_limit()
        asyncio.run(job.prepare())
        self.report_job_submission(info)
        if job.is_norun:  # the rule of all outputs has no script
            self.report_job_success(info)
            return
        script = (Path(job.rule.snakefile).parent / str(job.rule.script)).resolve()
        if not self.serves and FORKS:  # before there are other threads, which would see another folder
            os.environ[MODULES] = " ".join(self._modules())
            with contextlib.chdir(script.parents[2]):  # where it finds the modules of this checkout
                forkserver.ensure_running()
        self.serves = True
        process = self.processes.Process(
            target=run_script, args=(script, Path.cwd(), _seen_by_the_script(job))
        )
        with self.lock:
            process.start()
        thread = threading.Thread(target=self._wait_for, args=(info, process), daemon=True)
        self.at_work[thread] = process
        thread.start()

    def _modules(self):
        """Modules that jobs of this run may import: a run of few jobs needs a small part of the library."""
        from workflow.support.imported_files import modules_in  # of the Snakefile that runs

        return modules_in({job.input.get("library") for job in self.dag.needrun_jobs()} - {None})

    def _without_limit(self):
        """Drop Snakemake's limit to 100 new jobs a second, which no run here reaches.

        With it, Snakemake looks at all waiting jobs again a second after every look, and every job that ends
        adds one: after 300 jobs it looks 300 times a second, which takes a fifth of a core. A limit that a
        user has set stays.
        """
        scheduler = self.workflow.scheduler
        limiter = scheduler.job_rate_limiter
        if limiter is not None and (limiter.max_jobs, limiter.timespan) == USUAL_LIMIT:
            scheduler.job_rate_limiter = None
            scheduler.resources["_job_count"] = sys.maxsize  # as where there is no limit

    def _wait_for(self, info, process):
        """Wait until a job has ended, record why if it failed, and tell Snakemake."""
        from workflow.support.stopped import note_end  # of the Snakefile that runs

        connection.wait([process.sentinel])
        with self.lock:  # of several threads, one may ask for an exit status
            process.join()
        status = process.exitcode
        if FORKS and status == SERVER_ENDED:
            with contextlib.suppress(ProcessLookupError):
                os.kill(process.pid, signal.SIGKILL)
            status = -signal.SIGKILL
        job = info.job
        note_end("/".join([job.rule.name, *map(str, job.wildcards)]), str(job.log[0]), status)
        self.at_work.pop(threading.current_thread())
        if status == 0:
            self.report_job_success(info)
        else:
            self.report_job_error(info)

    def shutdown(self):
        """Nothing is left to end: the run waits for its jobs."""

    def cancel(self):
        """End the jobs at work. Those that Ctrl-C has interrupted, too, end by themselves."""
        left = list(self.at_work.items())
        for thread, process in left:
            thread.join(LONGEST_END_S)
            if thread.is_alive():
                process.terminate()
        for thread, _ in left:
            thread.join()

    def get_exec_mode(self):
        """Never asked: no further Snakemake is started."""
        raise NotImplementedError

    get_python_executable = get_exec_mode

    @property
    def cores(self):
        """Number of cores of this run."""
        return self.workflow.resource_settings.cores


def _seen_by_the_script(job) -> SimpleNamespace:
    """The object ``snakemake`` of a script, with names of files as plain text."""
    files = {name: getattr(job, name) for name in ("input", "output", "log")}
    plain = {name: type(found)(toclone=found, plainstr=True) for name, found in files.items()}
    return SimpleNamespace(
        **plain,
        params=job.params,
        wildcards=job.wildcards,
        threads=job.threads,
        resources=job.resources,
        rule=job.rule.name,
    )


def run_script(script: Path, folder: Path, snakemake: SimpleNamespace) -> None:
    """Run a script in this process, which ends as a Python of its own would end."""
    threading.Thread(target=_end_with_the_run, daemon=True).start()
    os.chdir(folder)
    sys.path.insert(0, str(script.parent))
    sys.argv = [str(script)]
    try:
        runpy.run_path(str(script), {"snakemake": snakemake}, run_name="__main__")
        from workflow.support.job_outputs import end_job  # of the Snakefile that runs

        end_job(snakemake)
    except (Exception, KeyboardInterrupt):
        sys.excepthook(*sys.exc_info())
        sys.exit(FAILED)


def _end_with_the_run() -> None:
    """End this process when the one that started it has ended, also by a signal."""
    multiprocessing.parent_process().join()
    os.kill(os.getpid(), signal.SIGKILL)
