"""Read a file in a child process, so that a damaged one cannot crash, stall or fill the process that asks.

The libraries that parse C3D, MATLAB and HDF5 files are compiled; one flipped byte can make them write beyond
their memory, loop, or ask for gigabytes. `guarded` forks: the child has everything that is imported already,
reads under limits of time and memory, and sends the result back through a pipe, arrays as raw bytes. That
costs a few milliseconds. Where there is no fork (Windows), or where the system's own libraries may not
survive one (macOS), the file is read directly.
"""

import contextlib
import faulthandler
import gc
import math
import os
import pickle
import select
import signal
import struct
import sys
import threading
import time
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tepsipe.errors import InputError

FORKS = hasattr(os, "fork") and sys.platform != "darwin"
# limits for an empty file, and increase per byte: some thirty times the need of the readers
SHORTEST_S, S_PER_BYTE = 1.5, 1e-6
FEWEST_BYTES, BYTES_PER_BYTE = 300_000_000, 50
# a slow disk or other processes take no processor time, so the limit on the wall is longer
WALL_S, WALL_FACTOR = 30.0, 10.0
ADVICE = "it is damaged, export or copy it again"
# an array larger than this is sent as raw bytes, not as a part of the pickle
LARGE_BYTES = 4096
PIPE_BYTES = 1 << 20
# signals that come from a person, a scheduler or a terminal, never from a file
ENDED_BY_SOMEBODY = ("SIGINT", "SIGTERM", "SIGHUP")


class _State:
    """Flag of a child process, and the lock that keeps a pipe's end out of other children."""

    inside = False
    lock = threading.Lock()


def _new_lock() -> None:
    """Another thread may have held the lock when this process was forked."""
    _State.lock = threading.Lock()


if FORKS:
    os.register_at_fork(after_in_child=_new_lock)


@dataclass(frozen=True)
class _Limits:
    """Limits of a child: processor time (s), wall-clock time (s), memory (bytes)."""

    cpu_s: float
    wall_s: float
    bytes: int


def guarded(
    function: Callable,
    *arguments: object,
    what: str | Path,
    longest_s: float | None = None,
    most_bytes: int | None = None,
):
    """Call a function that reads a file in a child process with limits, and return its result.

    Its output, warnings and side effects stay in the child. Within such a child, a call is direct.

    function: reads the file; its result can be pickled. Import what it needs beforehand, or every child
    imports it.
    what: the file, for messages and for the limits.
    longest_s: longest processor time (s); by default 1.5 s and 1 s per megabyte of the file. By the clock
    on the wall, it may take ten times as long and 30 s.
    most_bytes: most memory (bytes) beyond what this process has; by default 300 megabytes and 50 times the
    file's size.

    Returns
    -------
    object
        The function's result; its arrays are writable.
    """
    if not FORKS or _State.inside:
        return function(*arguments)
    limits = _limits(what, longest_s, most_bytes)
    try:
        child, pipe = _forked(function, arguments, limits)
    except OSError:  # the system has no room for another process
        return function(*arguments)
    status = None
    try:
        parts = _received(pipe, what, limits)
    finally:
        os.close(pipe)
        with contextlib.suppress(ProcessLookupError):
            os.kill(child, signal.SIGKILL)  # one that has ended already keeps its status
        with contextlib.suppress(ChildProcessError):  # where SIGCHLD is ignored, nobody waits for children
            status = os.waitpid(child, 0)[1]
    if parts is None:
        end = _end(status)
        if end in ENDED_BY_SOMEBODY:
            raise KeyboardInterrupt(f"{what}: {end} ended the process that read it")
        raise _refusal(what, end, limits)
    return _result(parts, what, limits)


def _limits(what: str | Path, longest_s: float | None, most_bytes: int | None) -> _Limits:
    try:
        size = Path(what).stat().st_size
    except (OSError, ValueError):  # the reader refuses it
        size = 0
    cpu_s = SHORTEST_S + S_PER_BYTE * size if longest_s is None else longest_s
    memory = FEWEST_BYTES + BYTES_PER_BYTE * size if most_bytes is None else most_bytes
    return _Limits(cpu_s, WALL_S + WALL_FACTOR * cpu_s, memory)


def _refusal(what: str | Path, end: str, limits: _Limits) -> InputError:
    expected, actual = {
        "time": (f"that is read within {limits.cpu_s:.3g} s", "that takes longer"),
        "memory": (f"that is read with {limits.bytes / 1e6:.0f} MB of memory", "that needs more"),
    }.get(end, ("that can be read", f"that crashes its reader ({end})"))
    return InputError(f"{what}: expected a file {expected}, found one {actual}: {ADVICE}")


def _end(status: int | None) -> str:
    """Reason why a child ended without a result."""
    if status is None or not os.WIFSIGNALED(status):
        return "without a result"
    number = os.WTERMSIG(status)
    if number in (signal.SIGPROF, signal.SIGXCPU):
        return "time"
    if number == signal.SIGKILL:  # of the system, which is out of memory
        return "memory"
    return signal.Signals(number).name if number in set(signal.Signals) else f"signal {number}"


# ---- the child -----------------------------------------------------------------------------------


def _forked(function: Callable, arguments: tuple, limits: _Limits) -> tuple[int, int]:
    """Number of a child that calls the function, and the end of the pipe at which its result arrives."""
    with _State.lock, _no_warning_of_threads():
        reading, writing = os.pipe()
        _widen(writing)
        try:
            child = os.fork()
        except OSError:
            os.close(reading)
            os.close(writing)
            raise
        if child == 0:
            try:
                os.close(reading)  # where the parent is killed, writing then fails and ends this process
                _serve(function, arguments, limits, writing)
            finally:  # nothing of the parent's runs twice: no test, no lock, no closing of its files
                os._exit(1)
        os.close(writing)
    return child, reading


def _widen(pipe: int) -> None:
    """Let a pipe hold a megabyte, so that the two processes seldom wait for each other."""
    import fcntl

    with contextlib.suppress(AttributeError, OSError):
        fcntl.fcntl(pipe, fcntl.F_SETPIPE_SZ, PIPE_BYTES)


@contextlib.contextmanager
def _no_warning_of_threads() -> Iterator[None]:
    """From Python 3.12 on, a fork of a process with threads warns; a child that hangs is ended here."""
    if sys.version_info < (3, 12):
        yield
        return
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        yield


def _serve(function: Callable, arguments: tuple, limits: _Limits, pipe: int) -> None:
    """Call the function in this process, a child, and send what comes of it."""
    _State.inside = True
    gc.disable()  # files that only the parent's garbage holds are closed by the parent
    faulthandler.disable()
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGPROF, signal.SIGXCPU):
        signal.signal(number, signal.SIG_DFL)
    nowhere = os.open(os.devnull, os.O_RDWR)
    for stream in {1, 2} - {pipe}:
        os.dup2(nowhere, stream)
    _start(limits)
    buffers: list[pickle.PickleBuffer] = []

    def stays(buffer: pickle.PickleBuffer) -> bool:
        if buffer.raw().nbytes <= LARGE_BYTES:
            return True
        buffers.append(buffer)
        return False

    try:
        content = pickle.dumps(("result", function(*arguments)), protocol=5, buffer_callback=stays)
    except MemoryError:
        buffers, content = [], pickle.dumps(("end", "memory"))
    except Exception as error:  # of any kind: it is raised again by the parent
        buffers, content = [], _pickled(error)
    raw = [memoryview(content), *(buffer.raw() for buffer in buffers)]
    lengths = [part.nbytes for part in raw]
    _send(pipe, memoryview(struct.pack(f"<{len(raw) + 1}Q", len(raw), *lengths)))
    for part in raw:
        _send(pipe, part)


def _start(limits: _Limits) -> None:
    """Set the limits of this process, a child, from here on."""
    import resource

    def limit(which: int, value: int) -> None:
        hard = resource.getrlimit(which)[1]
        if hard == resource.RLIM_INFINITY or hard > value:
            with contextlib.suppress(OSError, ValueError):
                resource.setrlimit(which, (value, value))

    signal.setitimer(signal.ITIMER_PROF, limits.cpu_s)
    limit(resource.RLIMIT_CPU, math.ceil(limits.cpu_s) + 1)  # where the signal of the timer is blocked
    limit(resource.RLIMIT_CORE, 0)
    with contextlib.suppress(OSError, ValueError, IndexError):
        # as plain bytes: a `Path` would write to three hundred pages of memory, which a fork copies first
        statm = os.open("/proc/self/statm", os.O_RDONLY)
        pages = int(os.read(statm, 100).split()[0])
        os.close(statm)
        limit(resource.RLIMIT_AS, pages * os.sysconf("SC_PAGE_SIZE") + limits.bytes)


def _pickled(error: Exception) -> bytes:
    """An error as it is sent; one that cannot be pickled becomes a RuntimeError that names it."""
    try:
        content = pickle.dumps(("error", error))
        pickle.loads(content)
    except Exception:  # of any kind
        content = pickle.dumps(("error", RuntimeError(f"{type(error).__name__}: {error}")))
    return content


def _send(pipe: int, content: memoryview) -> None:
    while content.nbytes:
        content = content[os.write(pipe, content) :]


# ---- the parent ----------------------------------------------------------------------------------


def _received(pipe: int, what: str | Path, limits: _Limits) -> list[np.ndarray] | None:
    """Pickle and buffers that the child sent; None if it ended before."""
    ready = select.poll()
    ready.register(pipe, select.POLLIN)
    until = time.monotonic() + limits.wall_s

    def receive(length: int) -> np.ndarray | None:
        content = np.empty(length, dtype=np.uint8)
        rest = memoryview(content)
        while rest.nbytes:
            if not ready.poll(1000.0 * max(0.0, until - time.monotonic())):
                raise _refusal(what, "time", limits)
            count = os.readv(pipe, [rest])
            if not count:
                return None
            rest = rest[count:]
        return content

    head = receive(8)
    if head is None:
        return None
    count = int(head.view("<u8")[0])
    if 8 * count > limits.bytes:
        raise _refusal(what, "memory", limits)
    lengths = receive(8 * count)
    if lengths is None:
        return None
    if sum(lengths.view("<u8").tolist()) > limits.bytes:
        raise _refusal(what, "memory", limits)
    parts = []
    for length in lengths.view("<u8").tolist():
        part = receive(length)
        if part is None:
            return None
        parts.append(part)
    return parts


def _result(parts: list[np.ndarray], what: str | Path, limits: _Limits):
    """Result of the function, or what it raised."""
    try:
        kind, content = pickle.loads(parts[0], buffers=parts[1:])
    except Exception as error:  # of any kind: the child's memory was damaged
        raise _refusal(what, type(error).__name__, limits) from error
    if kind == "result":
        return content
    raise content if kind == "error" else _refusal(what, content, limits)
