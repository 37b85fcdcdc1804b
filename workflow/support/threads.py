"""Number of threads of a job."""

import os


def use_one_thread() -> None:
    """Let arithmetic use one thread, which gives the same numbers on any number of cores.

    To be called before anything imports numpy: the number of threads is fixed when numpy starts.
    """
    for library in ("OMP", "OPENBLAS", "MKL"):
        os.environ[f"{library}_NUM_THREADS"] = "1"
