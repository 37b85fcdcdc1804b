"""Why jobs stopped: one sentence for each job that failed, also where it could say none itself."""

import contextlib
import re
import shutil
import signal
import time
from pathlib import Path

from workflow.support.runs import records_of_jobs

# less (bytes) counts as a full disk
FREE_BYTES = 65536
# signals by which the system says that a compiled library made an error
CRASHES = ("SIGSEGV", "SIGBUS", "SIGABRT", "SIGILL", "SIGFPE")
# by which it, a scheduler of a cluster or a person ends a job that takes too long
LIMITS = ("SIGTERM", "SIGXCPU", "SIGALRM", "SIGHUP", "SIGINT")


def what_stopped(jobs, run_log: str = "") -> list[str]:
    """One sentence per failed job: what its log says, its record, or the signal that ended it."""
    records = {record["log"]: record for record in records_of_jobs()}
    return [_sentence(job, records, run_log) for job in sorted(jobs, key=lambda job: str(job.log))]


def _sentence(job, records: dict[str, dict], run_log: str) -> str:
    about = "/".join([str(getattr(job, "rule", job)), *map(str, getattr(job, "wildcards", ()))])
    log = str(job.log[0]) if job.log else ""
    text = _read(log)
    if text:
        return text if text.startswith("tepsipe: ") else f"tepsipe: {about}: a bug, see {log}"
    record = records.get(log)
    if record and record["said"]:
        return record["said"].strip()
    # one that was killed at its very start has no record: any of its rule's
    script = re.escape(record["script"]) if record else rf"\w+\.{_script_of(job)}"
    stopped = _signal_of(script, run_log)
    sentence = f"tepsipe: {about}: {_of_signal(stopped, run_log)}"
    with contextlib.suppress(OSError):  # on a full disk it is among the messages of the run only
        Path(log).write_text(f"{sentence}\n", encoding="utf-8")
    return sentence


def _of_signal(name: str | None, run_log: str) -> str:
    if name is None and shutil.disk_usage(".").free < FREE_BYTES:
        return f"{Path.cwd()}: expected space for the run, found the disk full: free some, then run again"
    if name is None:
        return f"expected the job to say why it stopped, found nothing: see {run_log}, then run again"
    found = f"expected the job to end by itself, found it stopped by the signal {name}"
    if name in CRASHES:
        return f"{found}, an error in a compiled library: check the job's input files, then run again"
    if name in LIMITS:
        return f"{found}, as at a limit of time: raise the limit, then run again"
    return f"{found}, as where memory runs out: free some or run on fewer cores (-c1), then run again"


def _script_of(job) -> str:
    script = getattr(getattr(job, "rule", None), "script", None)
    return re.escape(Path(str(script)).stem) if script else re.escape(str(getattr(job, "rule", "")))


def _signal_of(script: str, run_log: str, longest_s: float = 1.0) -> str | None:
    """Signal that ended a script (a pattern), as Snakemake's log has it; that is written a little later."""
    ended = r"(?:died with <Signals\.(SIG\w+)|returned non-zero exit status (\d+))"
    pattern = re.compile(rf"{script}\.py' {ended}")
    deadline = time.monotonic() + longest_s
    while not (found := pattern.search(_read(run_log))) and time.monotonic() < deadline:
        time.sleep(0.1)
    if not found:
        return None
    if found.group(1):
        return found.group(1)
    try:
        return signal.Signals(int(found.group(2)) - 128).name
    except ValueError:
        return None


def _read(path: str) -> str:
    try:
        return Path(path).read_text(encoding="utf-8", errors="replace").strip()
    except OSError:
        return ""
