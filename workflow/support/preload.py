"""Import what jobs need, in the process from which they are forked.

A module that cannot be imported is left to the jobs that need it, which report the reason.
"""

import gc
import importlib
import pkgutil
from contextlib import suppress

from workflow.support.threads import use_one_thread

use_one_thread()  # before numpy is imported

import tepsipe  # noqa: E402

OTHERS = (
    *("edfio", "ezc3d", "h5py", "pandas"),
    *("matplotlib.figure", "matplotlib.backends.backend_svg", "matplotlib.backends.backend_agg"),
    *(f"scipy.{name}" for name in ("fft", "interpolate", "io", "linalg", "ndimage", "optimize", "signal")),
    *("scipy.special", "scipy.stats"),
)
ENGINES = "tepsipe.mechanics.engines."  # few jobs need one, and none needs all
OF_THE_STUDY = (found.name for found in pkgutil.walk_packages(tepsipe.__path__, "tepsipe."))
for name in (*OTHERS, *(name for name in OF_THE_STUDY if not name.startswith(ENGINES))):
    with suppress(Exception):
        importlib.import_module(name)
# what reads the formulas in figures, which the first formula of a process makes
with suppress(Exception):
    importlib.import_module("matplotlib.mathtext").MathTextParser("agg").parse("$x$")
# a garbage collection in a fork would copy every page that it shares with this process
gc.freeze()
