"""Import what jobs need, in the process from which they are forked.

The variable TEPSIPE_MODULES names the modules of this project that jobs of the run may import; the executor
sets it.
A module that cannot be imported is left to the jobs that need it, which report the reason.
"""

import ctypes
import gc
import importlib
import os
import sys
from contextlib import suppress

from workflow.support.threads import use_one_thread

use_one_thread()  # before numpy is imported

MODULES = os.environ.get("TEPSIPE_MODULES", "").split()
OTHERS = (
    *("edfio", "ezc3d", "h5py"),
    *(f"scipy.{name}" for name in ("fft", "interpolate", "io", "linalg", "ndimage", "optimize", "signal")),
    *("scipy.special", "scipy.stats"),
)
DRAW = "tepsipe.drawing.style" in MODULES
FOR_FIGURES = ("pandas", *(f"matplotlib.{name}" for name in ("figure", "backends.backend_svg", "mathtext")))
ENGINES = "tepsipe.mechanics.engines."  # few jobs need one, and none needs all
for name in (*OTHERS, *FOR_FIGURES * DRAW, *(name for name in MODULES if not name.startswith(ENGINES))):
    with suppress(Exception):
        importlib.import_module(name)
if DRAW:  # what reads the formulas in figures, which the first formula of a process makes
    with suppress(Exception):
        sys.modules["matplotlib.mathtext"].MathTextParser("agg").parse("$x$")
# the C library returns large arrays to the system, and clearing the pages of the next ones takes up to a
# fifth of the time of a fit; with these limits, the next arrays get the same memory
M_TRIM_THRESHOLD, M_MMAP_THRESHOLD, BYTES = -1, -3, 2**30
with suppress(Exception):  # a C library other than glibc
    for parameter in (M_TRIM_THRESHOLD, M_MMAP_THRESHOLD):
        ctypes.CDLL(None).mallopt(parameter, BYTES)
# a garbage collection in a fork would copy every page that it shares with this process
gc.freeze()
