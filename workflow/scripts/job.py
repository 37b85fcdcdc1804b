"""Start of every job: one thread for arithmetic, and one sentence in the log if the job must stop.

Import it before anything that imports numpy: the number of threads is fixed when numpy starts. One
thread gives the same numbers on any number of cores.

A record of the job lies in ``.snakemake/tepsipe/jobs`` while it runs. If a signal stops the job, the record
remains, and the run names the signal.
"""

import atexit
import errno
import json
import os
import re
import shutil
import sys
import traceback
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))

from workflow.support.forks import use_one_thread

use_one_thread()

from tepsipe.errors import InputError
from workflow.support.warm import hand_over

RECORDS = Path(".snakemake") / "tepsipe" / "jobs"
# a record of this size (bytes) has a block of its own, and can be written over when the disk is full
BLOCK = 4096
FULL = (errno.ENOSPC, errno.EDQUOT)
READ_ONLY = (errno.EROFS, errno.EACCES, errno.EPERM)
FREE_BYTES = 65536


def start(snakemake) -> None:
    """Report unusable input, a full disk or refused access by one sentence in the log, a bug by its trace.

    Where the run has a warm process, a fork of it goes on from here, and this process ends as the fork ends.
    """
    hand_over()
    about = "/".join([snakemake.rule, *snakemake.wildcards])
    trial = getattr(snakemake.input, "trial", None)
    if trial:
        about += f": {trial}"
    record = RECORDS / f"{Path(sys.argv[0]).stem}.json"
    content = {"about": about, "log": snakemake.log[0], "said": None}
    outputs = Path(snakemake.output[0]).parent

    def say(kind, error, trace):
        sentence = sentence_of(error, outputs)
        if sentence is None:
            text = "".join(traceback.format_exception(kind, error, trace))
        else:
            text = f"tepsipe: {about}: {sentence}\n"
        try:
            with open(snakemake.log[0], "w", encoding="utf-8") as log:
                log.write(text)
        except OSError:
            print(text, file=sys.stderr)
            _write(record, content | {"said": text})
            atexit.unregister(_forget)

    _write(record, content)
    atexit.register(_forget, record)
    sys.excepthook = say
    open(snakemake.log[0], "w").close()


def sentence_of(error: BaseException, folder: Path) -> str | None:
    """What to say of an error; None of a bug."""
    if isinstance(error, InputError):
        return str(error)
    if isinstance(error, KeyboardInterrupt):
        return "expected the job to end, found it interrupted: run again, the study goes on from there"
    if isinstance(error, MemoryError):
        return "expected enough memory, found none left: run on fewer cores, for example snakemake -c1"
    number = _number(error)
    named = getattr(error, "filename", None) or folder
    if number in FULL or (number is not None and _is_full(folder)):
        return f"{named}: expected space for the outputs, found the disk full: free some, then run again"
    if number == errno.EFBIG:
        return f"{named}: expected to write the output, found the limit of file sizes: raise it (ulimit -f)"
    if number in READ_ONLY:
        return (
            f"{named}: expected permission to read or write it, found none ({os.strerror(number)}): change "
            "its permissions, or name another folder in pathvars"
        )
    return None


def _number(error: BaseException | None) -> int | None:
    """Number of the operating system's error that lies behind an error of a library, if any."""
    seen = set()
    while error is not None and id(error) not in seen:
        seen.add(id(error))
        if isinstance(error, OSError) and error.errno:
            return error.errno
        found = re.search(r"errno = (\d+)", str(error))  # as HDF5 writes it
        if found:
            return int(found.group(1))
        for number in (*FULL, *READ_ONLY, errno.EFBIG):  # as a compiled library may write it
            if os.strerror(number) in str(error):
                return number
        error = error.__cause__ or error.__context__
    return None


def _is_full(folder: Path) -> bool:
    try:
        return shutil.disk_usage(folder).free < FREE_BYTES
    except OSError:
        return False


def _write(record: Path, content: dict) -> None:
    """Write a record in place; without space for it the job goes on without."""
    text = json.dumps(content).ljust(BLOCK)
    try:
        record.parent.mkdir(parents=True, exist_ok=True)
        with open(record, "r+" if record.exists() else "w", encoding="utf-8") as file:
            file.write(text)
    except OSError:
        return


def _forget(record: Path) -> None:
    """The job has ended by itself."""
    try:
        record.unlink(missing_ok=True)
    except OSError:
        return
