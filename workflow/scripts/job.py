"""Start of every job: one thread for arithmetic, and one sentence in the log if the job must stop.

Import it before anything that imports numpy: the number of threads is fixed when numpy starts. One
thread gives the same numbers on any number of cores.

A record of the job lies in ``.snakemake/tepsipe/jobs`` while it runs, and remains if the job stops: the run
reports it at its end (`workflow/support/stopped.py`).
"""

import atexit
import errno
import os
import re
import shutil
import sys
import traceback
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))

from workflow.support.threads import use_one_thread

use_one_thread()

from tepsipe.errors import InputError
from workflow.support.job_outputs import begin_job, end_job
from workflow.support.stopped import forget, write_record

FULL = (errno.ENOSPC, errno.EDQUOT)
READ_ONLY = (errno.EROFS, errno.EACCES, errno.EPERM)
FREE_BYTES = 65536


def start(snakemake) -> None:
    """Report unusable input, a full disk or refused access by one sentence in the log, a bug by its trace."""
    about = "/".join([snakemake.rule, *snakemake.wildcards])
    trial = getattr(snakemake.input, "trial", None)
    if trial:
        about += f": {trial}"
    log, outputs = str(snakemake.log[0]), Path(snakemake.output[0]).parent

    def say(kind, error, trace):
        sentence = sentence_of(error, outputs)
        if sentence is None:
            text = "".join(traceback.format_exception(kind, error, trace))
        else:
            text = f"tepsipe: {about}: {sentence}\n"
        try:
            Path(log).write_text(text, encoding="utf-8")
        except OSError:
            print(text, file=sys.stderr)
        # what the system refused may pass: the same job may succeed when it is run again
        lasting = isinstance(error, InputError) if sentence else not isinstance(error, OSError)
        write_record(about, log, text, lasting)
        atexit.unregister(forget)
        atexit.unregister(end_job)

    write_record(about, log)
    begin_job(log)
    # in a Python of its own; where jobs are forked, their executor does the same
    atexit.register(forget, log)
    atexit.register(end_job, snakemake)
    sys.excepthook = say
    open(log, "w").close()


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
