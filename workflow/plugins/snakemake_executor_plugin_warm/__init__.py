"""Snakemake executor ``warm``: the scripts of all jobs, one after the other, in forks of one warm process.

A job of Snakemake's own executor is a new Python, which takes 1.3 s to import what it needs. A fork has it
already. Everything else is Snakemake's: the graph, its checks, outputs of jobs that stop, records of what has
been done. A run takes one core, however many it is given: laboratories run side by side, not their jobs.

    PYTHONPATH=workflow/plugins snakemake --executor warm -c1

What stopped a job stands in ``.snakemake/tepsipe/stopped.json``: its rule, log, sentence, and whether the
same would happen again (``lasting``), or not, as after a signal or with a full disk.
"""

import importlib
import json
import os
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[3]))

from snakemake.script import Snakemake
from snakemake_interface_executor_plugins.executors.base import SubmittedJobInfo
from snakemake_interface_executor_plugins.executors.real import RealExecutor
from snakemake_interface_executor_plugins.settings import CommonSettings

from workflow.support.forks import FAILED, run_script, use_one_thread, warm_up

common_settings = CommonSettings(
    non_local_exec=False,
    implies_no_shared_fs=False,
    job_deploy_sources=False,
    pass_envvar_declarations_to_cmd=True,
    auto_deploy_default_storage_provider=False,
)

STOPPED = Path(".snakemake") / "tepsipe" / "stopped.json"
SCRIPTS = Path(__file__).parents[2] / "scripts"


class Executor(RealExecutor):
    """Runs one job at a time, and returns when it has ended."""

    def __post_init__(self):
        use_one_thread()
        sys.path.insert(0, str(SCRIPTS))
        warm_up()
        # a fork reads what this run has written, and a fork that crashes ends nothing else
        importlib.import_module("tepsipe.io.hdf5_file").read_directly()

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


def _in_a_fork(job) -> int:
    """Exit status of the job's script: 0, `FAILED`, `PASSED`, or minus the signal that ended it."""
    sys.stdout.flush()
    sys.stderr.flush()
    child = os.fork()
    if child == 0:
        os._exit(_run(job))
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def _run(job) -> int:
    """Run the script as Snakemake does it, in this process."""
    script = SCRIPTS / Path(str(job.rule.script)).name
    name = str(script.with_name(f"{job.jobid}.{script.name}"))
    return run_script(script, name, {"snakemake": _seen_by_the_script(job)})


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
