"""Runs and jobs that are at work in a folder.

A run holds a lock of the operating system on a file of its folder, which ends with its process, also if it is
killed. Where the file system has no such locks, Snakemake's own lock is left. A run that is killed leaves
Snakemake's lock, and its jobs may go on for a while; the note of the run names its computer.
"""

import contextlib
import json
import os
import re
import shutil
import socket
import sys
import time
from pathlib import Path

import psutil

from tepsipe.errors import InputError
from workflow.support.stopped import BLOCK, RECORDS

NOTE = Path(".snakemake") / "tepsipe" / "run.json"
HELD = Path(".snakemake") / "tepsipe" / "run.lock"
LOCKS = Path(".snakemake") / "locks"
# part of the commands of jobs: of Snakemake's own executor, and of this study's
OF_JOBS = (".snakemake/scripts/", "workflow.support.preload")
# with which Snakemake starts no jobs of a run, or is a job
LOOKS = {
    *("--report", "--unlock", "--lint", "--mode", "--nolock", "--print-compilation", "--cleanup-metadata"),
    *("--summary", "-S", "--detailed-summary", "-D", "--dag", "--rulegraph", "--filegraph", "--d3dag"),
    *("--list", "-l", "--list-rules", "--list-target-rules", "--lt", "--list-untracked", "--lu"),
    *("--list-input-changes", "--list-params-changes", "--list-code-changes", "--list-changes"),
}
LONGEST_WAIT_S = 1800.0
LEAST_BYTES = 1 << 20  # for records of Snakemake's and the log of the run
# what a shell takes as it is; Snakemake's own executors give it the interpreter's path without quotes
PLAIN = re.compile(r"[\w./+@%,:=-]", re.ASCII)


def looks(arguments: list[str]) -> bool:
    """Whether Snakemake with these arguments only looks, or is a job of another one."""
    return bool(LOOKS & {argument.partition("=")[0] for argument in arguments})


def is_dry(arguments: list[str]) -> bool:
    """Whether Snakemake with these arguments only says what it would do, as with ``-n`` or ``-np``."""
    return any(re.fullmatch(r"-[A-Za-z]*n[A-Za-z]*|--dry-?r.*", argument) for argument in arguments)


def spare_pandas() -> None:
    """Keep Snakemake from importing pandas, a tenth of the time that a run with nothing to do takes.

    Before it compares a param with that of the last run, it looks whether the param is a table of pandas. As
    long as nothing has imported pandas, none is.
    """
    from snakemake import persistence

    kind = getattr(persistence, "PersistenceBase", None)
    if hasattr(kind, "_serialize_param_pandas"):  # Snakemake's own affair, which another version may not have
        kind._serialize_param = property(
            lambda records: (
                records._serialize_param_pandas
                if "pandas" in sys.modules
                else records._serialize_param_builtin
            )
        )


def begin() -> None:
    """Take the folder for this run, and wait for jobs of one that was killed.

    Raises
    ------
    InputError
        If another run is at work in the folder, or nothing can be written to it.
    """
    other = elsewhere()
    if other:
        raise InputError(
            f"{Path.cwd()}: expected no other run in this folder, found one on {other}: wait for it; if it "
            f"has been killed, remove {NOTE}"
        )
    try:
        _hold()
    except OSError as error:
        raise InputError(refused_by_the_system(error, Path.cwd() / HELD.parts[0])) from error
    if NOTE.exists():  # of a run that was killed
        _wait_for_jobs()


def refused_by_the_system(error: OSError, place: str | Path) -> str:
    """Sentence for a file that cannot be written before the first job, as where the disk is full."""
    return (
        f"{place}: expected a folder to write to, found that the system refuses it "
        f"({error.strerror}): free space or change its permissions, then run again"
    )


def refuse_a_full_disk() -> None:
    """Refuse a folder without space for what Snakemake itself writes while it plans."""
    if shutil.disk_usage(".").free < LEAST_BYTES:
        raise InputError(
            f"{Path.cwd()}: expected space for the run, found the disk full: free some, then run again"
        )


def _hold() -> None:
    """Lock the file of the folder until this process ends, also where it becomes another program."""
    HELD.parent.mkdir(parents=True, exist_ok=True)
    try:
        import fcntl
    except ImportError:  # Windows
        return
    file = open(HELD, "a+", encoding="utf-8")
    try:
        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError:
        file.seek(0)
        other = file.read().strip()
        file.close()
        if other == str(os.getpid()):  # taken by `make` before this process became Snakemake
            return
        raise InputError(
            f"{Path.cwd()}: expected no other run in this folder, found process {other or '(just started)'} "
            f"at work: wait for it, or stop it with kill {other}".rstrip()
        ) from None
    except OSError:  # a file system without locks
        file.close()
        return
    file.truncate(0)
    file.write(str(os.getpid()).ljust(BLOCK))
    file.flush()
    os.set_inheritable(file.fileno(), True)
    _hold.file = file  # type: ignore[attr-defined]  # open as long as this process


def note_run() -> None:
    """Note which computer a run of this folder is on, and since when; forget jobs of earlier runs."""
    content = {"computer": socket.gethostname(), "started": time.strftime("%Y-%m-%d %H:%M:%S")}
    with contextlib.suppress(OSError):  # on a full disk the run goes on to say so
        NOTE.parent.mkdir(parents=True, exist_ok=True)
        for record in RECORDS.glob("*.json"):
            record.unlink(missing_ok=True)
        NOTE.write_text(json.dumps(content), encoding="utf-8")


def forget_run() -> None:
    """Remove the note when the run ends."""
    with contextlib.suppress(OSError):
        NOTE.unlink(missing_ok=True)


def elsewhere() -> str | None:
    """Computer and start of a run on another computer, if one is noted that has not ended."""
    try:
        note = json.loads(NOTE.read_text(encoding="utf-8"))
        return (
            None
            if note["computer"] == socket.gethostname()
            else f"{note['computer']} since {note['started']}"
        )
    except (OSError, ValueError, KeyError, TypeError):
        return None


def jobs_alive() -> list[int]:
    """Process numbers of jobs at work in this folder, also of those that have lost their run."""
    folder, found = str(Path.cwd()), []
    for process in psutil.process_iter(["cmdline", "cwd", "status"]):
        own = process.info
        if own["cwd"] != folder or not own["cmdline"] or own["status"] == psutil.STATUS_ZOMBIE:
            continue
        if any(name in part for part in own["cmdline"] for name in OF_JOBS):
            found.append(process.pid)
    return found


def wait_for_jobs(longest_s: float) -> bool:
    """Wait until the jobs have ended; False if they take longer."""
    deadline = time.monotonic() + longest_s
    while jobs_alive():
        if time.monotonic() > deadline:
            return False
        time.sleep(0.2)
    return True


def _wait_for_jobs() -> None:
    alive = jobs_alive()
    if not alive:
        return
    print(
        f"tepsipe: {len(alive)} jobs of a run that was killed are at work: waiting for them", file=sys.stderr
    )
    if not wait_for_jobs(LONGEST_WAIT_S):
        raise InputError(
            f"{Path.cwd()}: expected jobs of the run that was killed to end, found process {alive[0]} at "
            f"work after {LONGEST_WAIT_S / 60:.0f} minutes: stop it with kill {alive[0]}, then run again"
        )


def refuse_a_lock() -> None:
    """Refuse the lock that a run which was killed has left, at which Snakemake would stop."""
    if is_locked():
        raise InputError(
            f"{Path.cwd()}: expected no lock, found that of a run that was killed: remove it with snakemake "
            "--unlock, then run again, or go on with tepsipe run or make, which do both"
        )


def is_locked() -> bool:
    """Whether Snakemake has locked this folder, or a run that was killed has left its lock."""
    return LOCKS.is_dir() and any(LOCKS.iterdir())


def refuse_interpreter() -> None:
    """Refuse an interpreter whose path a shell would not take as it is, where a shell starts the jobs.

    The study's own executor needs no shell.
    """
    plugin = sys.modules.get("snakemake_executor_plugin_tepsipe")
    refused = sorted(set(PLAIN.sub("", sys.executable)))
    if refused and not (plugin and plugin.Executor.in_use):
        raise InputError(
            f"{sys.executable}: expected the path of an interpreter that a shell takes as it is, found "
            f"{' '.join(map(repr, refused))} in it, and an executor that starts jobs by a shell: run with "
            "--executor tepsipe, or put the environment "
            "elsewhere"
        )
