"""Scripts of jobs in forks of one warm process, which has imported what they need.

A job that is a new Python takes up to 1.3 s to import what it needs, most of a short job. A fork has it.
"""

import atexit
import ctypes
import gc
import importlib
import os
import pkgutil
import runpy
import sys
from collections.abc import Callable, Mapping
from contextlib import suppress
from pathlib import Path

# errors of the machine, not of the study: the same job may succeed when it is run again
PASSING = (OSError, MemoryError, KeyboardInterrupt)
FAILED, PASSED = 1, 3
# packages of the library that scripts of rules import
LIBRARY = (
    "experiments",
    "identification",
    "io",
    "mechanics",
    "signals",
    "statistics",
    "treadmill",
    "virtual_lab",
)
OF_SCIPY = ("fft", "interpolate", "io", "linalg", "ndimage", "optimize", "signal", "special", "stats")
OF_FIGURES = ("matplotlib.figure", "matplotlib.backends.backend_svg", "matplotlib.backends.backend_agg")
# of malloc.h
M_TRIM_THRESHOLD, M_TOP_PAD, M_MMAP_THRESHOLD = -1, -2, -3


def use_one_thread() -> None:
    """One thread for arithmetic, which gives the same numbers on any number of cores.

    To be called before anything imports numpy: the number of threads is fixed when numpy starts.
    """
    for library in ("OMP", "OPENBLAS", "MKL"):
        os.environ[f"{library}_NUM_THREADS"] = "1"


def warm_up(figures: bool = False) -> None:
    """Import once what scripts need, and let forks use their memory again and again.

    What cannot be imported is left to the jobs that need it, which say so.
    """
    names = ["ezc3d", "h5py", *(f"scipy.{name}" for name in OF_SCIPY), "tepsipe.reporting.recovery"]
    names += [*OF_FIGURES, "pandas"] if figures else []
    for name in names:
        _imported(name)
    for package in (*LIBRARY, *(("ingest", "reporting") if figures else ())):
        found = _imported(f"tepsipe.{package}")
        for module in pkgutil.walk_packages(found.__path__, f"{found.__name__}.") if found else ():
            _imported(module.name)
    _keep_memory()
    # a collection in a fork would copy every page that this process shares with it
    gc.freeze()


def _imported(name: str):
    with suppress(Exception):
        return importlib.import_module(name)


def _keep_memory() -> None:
    """Let the C library keep what arrays free: giving it back costs a fault per page at the next array."""
    with suppress(OSError, AttributeError):
        mallopt = ctypes.CDLL(None).mallopt
        for option, bytes_ in (
            (M_MMAP_THRESHOLD, 32 << 20),
            (M_TRIM_THRESHOLD, 512 << 20),
            (M_TOP_PAD, 16 << 20),
        ):
            mallopt(option, bytes_)


def run_script(script: str | Path, name: str, given: Mapping[str, Callable] | None = None) -> int:
    """Run a script in this process, a fork, and everything that it wants done at exit; return its status.

    ``name`` is what the script finds as its own in ``sys.argv``; ``given`` are names that it finds defined.
    """
    atexit._clear()
    sys.argv = [name]
    status = 0
    try:
        runpy.run_path(str(script), dict(given or {}), run_name="__main__")
    except SystemExit as error:
        status = FAILED if error.code else 0
    except BaseException as error:
        sys.excepthook(*sys.exc_info())
        status = PASSED if isinstance(error, PASSING) else FAILED
    atexit._run_exitfuncs()
    sys.stdout.flush()
    sys.stderr.flush()
    return status
