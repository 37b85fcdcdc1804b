"""Run by the study itself: one process that has imported what jobs need, and forks for each of them.

Snakemake starts every job as a Python of its own. Its script hands itself over (`hand_over`) to this process,
waits for the fork that runs it in its place, and ends as the fork has ended. Whoever kills the one ends the
other; if this process is not there, the script runs by itself.
"""

import array
import contextlib
import ctypes
import importlib
import json
import os
import select
import selectors
import signal
import socket
import struct
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

# a run of fewer jobs does without: importing everything takes as long as starting these
FEWEST_JOBS = 6
VARIABLE = "TEPSIPE_WARM"
LENGTH = struct.Struct("!i")
STREAMS = (0, 1, 2)
LONGEST_END_S = 10.0
PR_SET_PDEATHSIG = 1  # of prctl.h


@dataclass
class _Server:
    """The process of this run, if it has one."""

    process: subprocess.Popen | None = None


def start(jobs: int) -> None:
    """Start the process for a run of so many jobs (-); jobs find it by a variable of the environment."""
    os.environ.pop(VARIABLE, None)
    if jobs < FEWEST_JOBS or sys.platform != "linux":
        return
    name = f"tepsipe-{os.getpid()}-{os.urandom(8).hex()}"
    with contextlib.suppress(OSError):
        listener = socket.socket(socket.AF_UNIX)
        with listener:
            listener.bind(f"\0{name}")
            listener.listen(256)
            command = [sys.executable, str(Path(__file__)), str(listener.fileno())]
            _Server.process = subprocess.Popen(
                command,
                stdin=subprocess.PIPE,
                stdout=subprocess.DEVNULL,
                stderr=subprocess.DEVNULL,
                pass_fds=[listener.fileno()],
            )
        os.environ[VARIABLE] = json.dumps([name, sys.executable])


def stop() -> None:
    """End the process at the end of the run."""
    os.environ.pop(VARIABLE, None)
    process, _Server.process = _Server.process, None
    if process is None:
        return
    process.stdin.close()
    try:
        process.wait(LONGEST_END_S)
    except subprocess.TimeoutExpired:
        process.kill()
        process.wait()


def hand_over() -> None:
    """Have a fork of the warm process run this script, and end as it ends; return where there is none."""
    try:
        name, python = json.loads(os.environ.pop(VARIABLE, "null"))
    except (TypeError, ValueError):
        return
    if python != sys.executable:
        return
    with _interrupts() as woken, socket.socket(socket.AF_UNIX) as server:
        try:
            server.connect(f"\0{name}")
            call = {"script": sys.argv[0], "folder": str(Path.cwd()), "environment": dict(os.environ)}
            request = json.dumps(call).encode()
            streams = array.array("i", STREAMS)
            server.sendmsg([LENGTH.pack(len(request))], [(socket.SOL_SOCKET, socket.SCM_RIGHTS, streams)])
            server.sendall(request)
            child = _received(server)
        except OSError:
            return
        if child is None:
            return
        while server not in (ready := select.select([server, woken], [], [])[0]):
            if woken in ready and signal.SIGINT in woken.recv(4096):
                with contextlib.suppress(ProcessLookupError):
                    os.kill(child, signal.SIGINT)
        status = None
        with contextlib.suppress(OSError):
            status = _received(server)
    _end_as(-signal.SIGKILL if status is None else status)


@contextlib.contextmanager
def _interrupts() -> Iterator[socket.socket]:
    """A socket that gives the numbers of signals as bytes; interrupts do nothing else meanwhile."""
    woken, wake = socket.socketpair()
    with woken, wake:
        wake.setblocking(False)
        before = signal.signal(signal.SIGINT, lambda *_: None)
        signal.set_wakeup_fd(wake.fileno(), warn_on_full_buffer=False)
        try:
            yield woken
        finally:
            signal.set_wakeup_fd(-1)
            signal.signal(signal.SIGINT, before)
            if signal.SIGINT in _at_once(woken):  # nobody has seen it
                signal.raise_signal(signal.SIGINT)


def _at_once(source: socket.socket) -> bytes:
    """What a socket holds already."""
    source.setblocking(False)
    try:
        return source.recv(4096)
    except BlockingIOError:
        return b""


def _received(connection: socket.socket) -> int | None:
    """A number from the other side; None if it has gone."""
    data = b""
    while len(data) < LENGTH.size:
        part = connection.recv(LENGTH.size - len(data))
        if not part:
            return None
        data += part
    return LENGTH.unpack(data)[0]


def _end_as(status: int) -> None:
    """End with an exit status, or by the signal of a negative one."""
    sys.stdout.flush()
    sys.stderr.flush()
    if status < 0:
        number = -status
        if number != signal.SIGKILL:
            signal.signal(number, signal.SIG_DFL)
        os.kill(os.getpid(), number)
    os._exit(status)


def serve(listener: socket.socket) -> None:
    """Fork for every script that is handed over, until the run has ended and the last of them."""
    woken, wake = socket.socketpair()
    for end in (woken, wake):
        end.setblocking(False)
    signal.set_wakeup_fd(wake.fileno(), warn_on_full_buffer=False)
    signal.signal(signal.SIGCHLD, lambda *_: None)
    signal.signal(signal.SIGINT, lambda *_: None)  # the scripts end by themselves
    at_work: dict[int, socket.socket] = {}
    with selectors.DefaultSelector() as selector:
        for source in (listener, woken, sys.stdin.buffer.raw):
            selector.register(source, selectors.EVENT_READ)
        open_ = True
        while open_ or at_work:
            for key, _ in selector.select():
                if key.fileobj is listener:
                    connection = listener.accept()[0]
                    child = _forked(connection)
                    if child is None:
                        connection.close()
                        continue
                    at_work[child] = connection
                    selector.register(connection, selectors.EVENT_READ, child)
                elif key.fileobj is woken:
                    _at_once(woken)
                elif key.data is None:  # the run has ended, or was killed
                    open_ = False
                    selector.unregister(key.fileobj)
                    selector.unregister(listener)
                    listener.close()
                else:  # the script was killed
                    with contextlib.suppress(ProcessLookupError):
                        os.kill(key.data, signal.SIGKILL)
                    selector.unregister(key.fileobj)
            _tell_of_ends(at_work, selector)


def _tell_of_ends(at_work: dict[int, socket.socket], selector: selectors.BaseSelector) -> None:
    """Send the exit status of every fork that has ended to its script."""
    while at_work:
        try:
            child, status = os.waitpid(-1, os.WNOHANG)
        except ChildProcessError:
            return
        if child == 0:
            return
        connection = at_work.pop(child)
        with contextlib.suppress(KeyError):
            selector.unregister(connection)
        with connection, contextlib.suppress(OSError):
            connection.sendall(LENGTH.pack(os.waitstatus_to_exitcode(status)))


def _forked(connection: socket.socket) -> int | None:
    """Process number of a fork that runs the script of a connection; None of a stranger's or a broken one."""
    peer = connection.getsockopt(socket.SOL_SOCKET, socket.SO_PEERCRED, struct.calcsize("3i"))
    if struct.unpack("3i", peer)[1] != os.getuid():
        return None
    try:
        head, streams, _, _ = socket.recv_fds(connection, LENGTH.size, len(STREAMS))
        request = b""
        while len(request) < LENGTH.unpack(head)[0]:
            part = connection.recv(1 << 16)
            if not part:
                return None
            request += part
        child = os.fork()
        if child == 0:
            _run(json.loads(request), streams, connection)
        for stream in streams:
            os.close(stream)
        connection.sendall(LENGTH.pack(child))
    except (OSError, struct.error):
        return None
    return child


def _run(call: dict, streams: list[int], connection: socket.socket) -> None:
    """Run the script in this process, a fork, with folder, environment and streams of the one before."""
    from workflow.support.forks import run_script

    status = 1
    try:
        parent = os.getppid()
        signal.set_wakeup_fd(-1)
        signal.signal(signal.SIGCHLD, signal.SIG_DFL)
        signal.signal(signal.SIGINT, signal.default_int_handler)
        with contextlib.suppress(OSError, AttributeError):  # end with the process that started it
            ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
        if os.getppid() == parent:
            os.setpgid(0, 0)  # a terminal interrupts the script, and that this fork
            connection.close()
            for target, stream in zip(STREAMS, streams, strict=True):
                os.dup2(stream, target)
                os.close(stream)
            os.chdir(call["folder"])
            os.environ.clear()
            os.environ.update(call["environment"])
            sys.path[0] = str(Path(call["script"]).parent)
            status = run_script(call["script"], call["script"])
    finally:
        os._exit(status)


if __name__ == "__main__":
    sys.path[0] = str(Path(__file__).parents[2])
    from workflow.support.forks import use_one_thread, warm_up

    use_one_thread()
    # of the lines that Snakemake puts before a script
    for package in ("snakemake.logging", "snakemake.script"):
        importlib.import_module(package)
    warm_up(figures=True)
    with socket.socket(fileno=int(sys.argv[1])) as own:
        serve(own)
