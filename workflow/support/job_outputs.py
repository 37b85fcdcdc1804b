"""What jobs have made and read: records of outputs and recordings, by which later runs notice a change.

Snakemake takes a result that exists and is newer than its inputs for what a job has made. The records tell
whether it is missing, damaged, or edited. A job removes what its last run made and this one did not, such as
a figure that the study no longer has. Files are compared by size and time, and by their contents only if
one of these differs.

Recordings, whose times are those of other computers, are no inputs of Snakemake's, which would compare them
by time. Their contents are params of the rules that read them, so that a recording with other contents is
analysed again, whatever its time.
"""

import contextlib
import hashlib
import json
import stat
import subprocess
import sys
import tempfile
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path

from tepsipe.errors import InputError

RECORDS = Path(".snakemake") / "tepsipe" / "made"
READ = RECORDS.parent / "read.json"
FORMER = ".former"  # ending of the record that a job at work has set aside


@dataclass
class Changes:
    """Files that are no longer what a job has made."""

    missing: list[str] = field(default_factory=list)
    damaged: list[str] = field(default_factory=list)
    edited: list[str] = field(default_factory=list)


def begin_job(log: str) -> None:
    """Set the record of a job aside: its outputs change from now on."""
    record = _record_of(log)
    with contextlib.suppress(OSError):
        record.replace(record.with_suffix(FORMER))


def end_job(snakemake) -> None:
    """Write the record of a job that has ended well; remove what only its last run has made."""
    log = str(snakemake.log[0])
    record = _record_of(log)
    former = _read(record.with_suffix(FORMER))
    content = {"log": log, "condition": dict(snakemake.wildcards.items()).get("condition")}
    with contextlib.suppress(OSError):  # without space for the record, the job has ended well all the same
        content["files"] = {str(path): _seen(str(path)) for path in snakemake.output}
        record.parent.mkdir(parents=True, exist_ok=True)
        record.write_text(json.dumps(content), encoding="utf-8")
        for path, seen in former.get("files", {}).items():
            if path not in content["files"] and _is(path, seen):
                Path(path).unlink()
        record.with_suffix(FORMER).unlink(missing_ok=True)


def changes(logs: str) -> Changes:
    """Compare all files that jobs with logs in this folder have made with their records.

    Files that were only touched or copied keep their times: a later one would hide from Snakemake that the
    library was edited in between.
    """
    found = Changes()
    for record, content in _records(logs):
        touched = False
        for path, seen in content["files"].items():
            try:
                status = Path(path).stat()
            except OSError:
                found.missing.append(path)
                continue
            if [status.st_size, status.st_mtime_ns] == seen[:2]:
                continue
            if not stat.S_ISREG(status.st_mode):  # a folder, or a pipe or device, which is not read
                found.edited.append(path)
            elif _is(path, seen):  # touched or copied
                content["files"][path], touched = _seen(path), True
            else:
                (found.damaged if _is_damaged(path, status.st_size) else found.edited).append(path)
        if touched:
            _write(record, content)
    return found


def contents(paths: Iterable[str], dry: bool) -> tuple[dict[str, str | None], list[str]]:
    """SHA-256 of recordings (None of one that is missing), and those that have changed since the last run.

    A file is hashed again only if its size or one of its times differs from the record. One of them is the
    time at which the system saw it change: a file that replaces another one may have the same date and size.
    """
    record = _read(READ)
    files = dict(record.get("files", {}))
    found: dict[str, str | None] = {}
    changed = []
    for path in paths:
        known, found[path] = files.get(path), None
        with contextlib.suppress(OSError):  # its job says why it cannot be read
            status = Path(path).stat()
            if not stat.S_ISREG(status.st_mode):
                continue
            seen = [status.st_size, status.st_mtime_ns, status.st_ctime_ns]
            if known is None or known[:3] != seen:
                seen.append(_digest(path))
                if known is not None and known[3] != seen[3]:
                    changed.append(path)
                if not (dry and path in changed):
                    files[path] = seen
                known = seen
            found[path] = known[3]
    if files != record.get("files", {}):
        with contextlib.suppress(OSError):
            READ.parent.mkdir(parents=True, exist_ok=True)
        _write(READ, {"files": files})
    return found, changed


def refuse_edited(found: Changes) -> None:
    """Raise one sentence for results that have been edited."""
    if found.edited:
        path, others = found.edited[0], len(found.edited) - 1
        more = (
            f", as {others} more ({', '.join(found.edited[1:4])}{', ...' * (others > 3)})" if others else ""
        )
        raise InputError(
            f"{path}: expected the result as a job has written it, found it edited since then{more}: delete "
            "it to have it made again; to keep it, move it out of the results"
        )


def remade(found: Changes, config: dict, snakefile: str, arguments: list[str], dry: bool) -> list[str]:
    """Results to be made again: missing ones, and damaged ones, which are removed unless the run is dry.

    Snakemake makes an intermediate again only if it is asked for. It is asked for what the present study
    makes; a result with another origin is forgotten.
    """
    logs = config["pathvars"]["logs"]
    if not dry:
        for path in found.damaged:
            Path(path).unlink(missing_ok=True)
    lost = {*found.missing, *found.damaged}
    recorded = {path for _, content in _records(logs) for path in content["files"]}
    # a run that is given targets makes what they need; without any result, everything is made anyway
    if not lost or lost == recorded or recorded & set(arguments):
        return []
    made = _made_by(config, snakefile)
    if not made:  # the run itself will say why
        return []
    again = sorted(lost & made)
    if not dry:
        _forget(lost - made, logs)
    for paths, what in ((found.missing, "missing"), (found.damaged, "damaged")):
        paths = [path for path in paths if path in made]
        if paths:
            more = f" and {len(paths) - 1} more" if len(paths) > 1 else ""
            print(f"tepsipe: {what}, made again: {paths[0]}{more}", file=sys.stderr)
    return again


def of_no_trial(logs: str, trials, experiments) -> list[str]:
    """Results of conditions that are not in the trial sheet: (experiment, condition) of ``trials``."""
    conditions, found = {condition for _, condition in trials}, []
    for _, content in _records(logs):
        for path in content["files"] if content["condition"] else ():
            experiment = next((part for part in Path(path).parts if part in experiments), None)
            known = (experiment, content["condition"]) in trials
            if not (known if experiment else content["condition"] in conditions) and Path(path).exists():
                found.append(path)
    return sorted(found)


def _made_by(config: dict, snakefile: str) -> set[str]:
    """All files that the rules make with this configuration."""
    with tempfile.TemporaryDirectory() as folder:
        settings = Path(folder) / "config.json"
        settings.write_text(json.dumps(config), encoding="utf-8")
        return set(planned(["--snakefile", snakefile, "--configfile", str(settings)]))


def planned(arguments: list[str]) -> dict[str, bool]:
    """All files that the rules make, as ``snakemake --summary`` lists them: whether a run would make each."""
    command = [sys.executable, "-m", "snakemake", "--summary", *arguments]
    done = subprocess.run(command, capture_output=True, text=True)
    lines = [line.split("\t") for line in done.stdout.splitlines()]
    return {line[0]: line[-1] != "no update" for line in lines if line[0] != "output_file"}


def _records(logs: str) -> list[tuple[Path, dict]]:
    """Records of the jobs whose logs are below a folder, and where they lie."""
    found = [(path, _read(path)) for path in sorted(RECORDS.glob("*.json"))]
    return [(path, content) for path, content in found if content.get("log", "").startswith(f"{logs}/")]


def _forget(paths: set[str], logs: str) -> None:
    for record, content in _records(logs):
        if paths & set(content["files"]):
            content["files"] = {path: seen for path, seen in content["files"].items() if path not in paths}
            _write(record, content)


def _write(record: Path, content: dict) -> None:
    with contextlib.suppress(OSError):
        record.write_text(json.dumps(content), encoding="utf-8")


def _seen(path: str) -> list:
    """Size (bytes), time (ns) and SHA-256 of a file."""
    status = Path(path).stat()
    return [status.st_size, status.st_mtime_ns, _digest(path)]


def _digest(path: str) -> str:
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()


def _is(path: str, seen: list) -> bool:
    """Whether a file has the contents that were recorded."""
    with contextlib.suppress(OSError):
        return Path(path).stat().st_size == seen[0] and _digest(path) == seen[2]
    return False


def _is_damaged(path: str, size: int) -> bool:
    """True for an empty file, and for an HDF5 file that cannot be opened, as after a full disk."""
    if size == 0 or not path.endswith(".h5"):
        return size == 0
    import h5py

    try:
        h5py.File(path, "r").close()
    except OSError:
        return True
    return False


def _record_of(log: str) -> Path:
    return RECORDS / f"{hashlib.sha1(log.encode()).hexdigest()}.json"


def _read(path: Path) -> dict:
    """A record; empty where there is none, or a damaged one."""
    with contextlib.suppress(OSError, ValueError):
        found = json.loads(path.read_text(encoding="utf-8"))
        if isinstance(found, dict) and isinstance(found.get("files", {}), dict):
            return found
    return {}
