"""Start of every job: one thread for arithmetic, and one sentence in the log if the job must stop.

Import it before anything that imports numpy: the number of threads is fixed when numpy starts. One
thread gives the same numbers on any number of cores.
"""

import os
import sys
import traceback
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))

for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ[f"{library}_NUM_THREADS"] = "1"

from tepsipe.errors import InputError


def start(snakemake) -> None:
    """Report unusable input by one sentence in the job's log, and a bug by its traceback."""
    about = "/".join([snakemake.rule, *snakemake.wildcards])
    trial = getattr(snakemake.input, "trial", None)
    if trial:
        about += f": {trial}"

    def say(kind, error, trace):
        if issubclass(kind, InputError):
            text = f"tepsipe: {about}: {error}\n"
        else:
            text = "".join(traceback.format_exception(kind, error, trace))
        with open(snakemake.log[0], "w", encoding="utf-8") as log:
            log.write(text)

    open(snakemake.log[0], "w").close()
    sys.excepthook = say
