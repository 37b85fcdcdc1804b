"""What every job does first: one thread for its arithmetic, and one sentence where it must stop.

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
    """From here on, unusable input ends the job with one sentence in its log; a bug with its trace."""
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
