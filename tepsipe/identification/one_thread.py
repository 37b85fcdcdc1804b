"""One thread for the linear algebra of a fit.

Matrices of a fit have a few dozen columns. More threads spend their time on waiting for each other, above all
where other programs run; and with one, the numbers are the same on any number of cores.
"""

from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from importlib import import_module
from threading import Lock

from threadpoolctl import ThreadpoolController

_LOCK = Lock()
# number of fits that run, and the limit that the first of them set
_running, _limit = 0, None


@contextmanager
def one_thread() -> Iterator[None]:
    """Limit BLAS to one thread while a fit runs; ``@one_thread()`` decorates its function.

    Fits in threads of their own share the limit. The last one restores the number that the first one found.
    """
    global _running, _limit
    with _LOCK:
        if not _running:
            _limit = _controller().limit(limits=1, user_api="blas")
        _running += 1
    try:
        yield
    finally:
        with _LOCK:
            _running -= 1
            if not _running:
                _limit.restore_original_limits()


@cache
def _controller() -> ThreadpoolController:
    """Threads of NumPy and of SciPy, whose own BLAS is loaded together with its linear algebra."""
    import_module("scipy.linalg")
    return ThreadpoolController()
