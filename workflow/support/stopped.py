"""Why jobs stopped: a record of each job at work, and one sentence for each that failed.

A job writes its record when it starts, and again if it stops with an error. What ends a job without a word,
such as a signal, is added by the executor, which sees how the process ends. Records of jobs that end well are
removed; those that remain are reported when the run ends.
"""

import contextlib
import hashlib
import json
import shutil
import signal
from pathlib import Path

RECORDS = Path(".snakemake") / "tepsipe" / "jobs"
# a record of this size (bytes) has a block of its own, and can be written over when the disk is full
BLOCK = 4096
# less (bytes) counts as a full disk
FREE_BYTES = 65536
# signals by which the system says that a compiled library made an error
CRASHES = ("SIGSEGV", "SIGBUS", "SIGABRT", "SIGILL", "SIGFPE")
# by which it, a scheduler of a cluster or a person ends a job that takes too long
LIMITS = ("SIGTERM", "SIGXCPU", "SIGALRM", "SIGHUP", "SIGINT")
SENTENCE = "tepsipe: "  # how a sentence begins; a trace begins otherwise


def write_record(about: str, log: str, said: str = "", lasting: bool = False) -> None:
    """Write the record of a job in place; without space for it the job goes on without.

    ``said`` is the text of the log, of which the last line is kept. ``lasting`` means that the same would
    happen again: it is not due to a signal or a full disk.
    """
    lines = said.splitlines()
    content = {"about": about, "log": log, "said": lines[-1] if lines else "", "lasting": lasting}
    record = _record_of(log)
    with contextlib.suppress(OSError):
        record.parent.mkdir(parents=True, exist_ok=True)
        with open(record, "r+" if record.exists() else "w", encoding="utf-8") as file:
            file.write(json.dumps(content).ljust(BLOCK))
            file.truncate()


def forget(log: str) -> None:
    """Remove the record of a job that has ended well."""
    with contextlib.suppress(OSError):
        _record_of(log).unlink(missing_ok=True)


def note_end(about: str, log: str, status: int) -> None:
    """Note how the process of a job has ended: its exit status, or minus the signal that ended it."""
    if status == 0:
        forget(log)
        return
    record = _read(_record_of(log)) or {"about": about, "said": ""}
    if record["said"]:
        return
    text = ""
    with contextlib.suppress(OSError):
        text = Path(log).read_text(encoding="utf-8", errors="replace")
    if status < 0 and not text:
        text = f"{SENTENCE}{record['about']}: {_of_signal(-status)}\n"
        with contextlib.suppress(OSError):
            Path(log).write_text(text, encoding="utf-8")
    write_record(record["about"], log, text)


def records(folder: Path | str = ".") -> list[dict]:
    """Records of the jobs of a run in a folder that are at work or have stopped, by their logs."""
    found = (_read(path) for path in (folder / RECORDS).glob("*.json"))
    return sorted((record for record in found if record), key=lambda record: record["log"])


def what_stopped(run_log: str) -> list[str]:
    """One sentence per job that has stopped, at the end of a run with this log of Snakemake."""
    full = shutil.disk_usage(".").free < FREE_BYTES
    if full:
        nothing = f"{Path.cwd()}: expected space for the run, found the disk full: free some, then run again"
    else:
        nothing = f"expected the job to say why it stopped, found nothing: see {run_log}, then run again"
    sentences = [_sentence(record, nothing) for record in records()]
    return sentences or [f"{SENTENCE}{nothing}"]


def _sentence(record: dict, nothing: str) -> str:
    said, about = record["said"], record["about"]
    if said.startswith(SENTENCE):
        return said
    return f"{SENTENCE}{about}: a bug, see {record['log']}" if said else f"{SENTENCE}{about}: {nothing}"


def _of_signal(number: int) -> str:
    name = signal.Signals(number).name if number in set(signal.Signals) else str(number)
    found = f"expected the job to end by itself, found it stopped by the signal {name}"
    if name in CRASHES:
        return f"{found}, an error in a compiled library: check the job's input files, then run again"
    if name in LIMITS:
        return f"{found}, as at a limit of time: raise the limit, then run again"
    return f"{found}, as where memory runs out: free some or run on fewer cores (-c1), then run again"


def _record_of(log: str) -> Path:
    return RECORDS / f"{hashlib.sha1(log.encode()).hexdigest()}.json"


def _read(path: Path) -> dict | None:
    """A record; none of a damaged one, as where the disk is full."""
    with contextlib.suppress(OSError, ValueError):
        found = json.loads(path.read_text(encoding="utf-8"))
        return found if isinstance(found, dict) else None
    return None
