"""Runs and jobs that are at work in a folder.

A run that is killed leaves Snakemake's lock, and its jobs may go on for a while. Before the next run removes
the lock, no other may be at work here: the table of processes lists those on this computer, the note of the
run names another computer.
"""

import contextlib
import json
import os
import socket
import sys
import time
from pathlib import Path

import psutil

from workflow.support.stopped import RECORDS

NOTE = Path(".snakemake") / "tepsipe" / "run.json"
LOCKS = Path(".snakemake") / "locks"
# part of the commands of jobs: of Snakemake's own executor, and of this study's
OF_JOBS = (".snakemake/scripts/", "workflow.support.preload")
NO_RUN = {"-n", "--dry-run", "--dryrun", "--report", "--unlock", "--lint"}


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


def _processes_here() -> list[tuple[int, list[str]]]:
    """Process number and command of every process whose folder is this one."""
    folder, found = str(Path.cwd()), []
    for process in psutil.process_iter(["cmdline", "cwd", "status"]):
        own = process.info
        if own["cwd"] == folder and own["cmdline"] and own["status"] != psutil.STATUS_ZOMBIE:
            found.append((process.pid, own["cmdline"]))
    return found


def runs_alive() -> list[int]:
    """Process numbers of other Snakemakes at work in this folder."""
    return [
        pid
        for pid, command in _processes_here()
        if pid != os.getpid() and _is_snakemake(command) and not NO_RUN & set(command)
    ]


def _is_snakemake(command: list[str]) -> bool:
    names = [Path(part).name for part in command[:2]]
    script = "snakemake" in names and (names[0] == "snakemake" or names[0].startswith("python"))
    return script or command[1:3] == ["-m", "snakemake"]


def jobs_alive() -> list[int]:
    """Process numbers of jobs at work in this folder, also of those that have lost their run."""
    return [
        pid
        for pid, command in _processes_here()
        if any(name in part for part in command for name in OF_JOBS) or "--report" in command
    ]


def wait_for_jobs(longest_s: float) -> bool:
    """Wait until the jobs have ended; False if they take longer."""
    deadline = time.monotonic() + longest_s
    while jobs_alive():
        if time.monotonic() > deadline:
            return False
        time.sleep(0.2)
    return True


def warn_of_a_lock(arguments: list[str]) -> None:
    """Say how to go on where a run that was killed has left its lock; Snakemake will stop at it."""
    if is_locked() and not NO_RUN & set(arguments) and not runs_alive():
        print(
            f"tepsipe: {Path.cwd()}: expected no lock, found that of a run that was killed: go on with make, "
            "or remove it with snakemake --unlock",
            file=sys.stderr,
        )


def is_locked() -> bool:
    """Whether Snakemake has locked this folder, or a run that was killed has left its lock."""
    return LOCKS.is_dir() and any(LOCKS.iterdir())
