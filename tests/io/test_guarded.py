"""Files are read in a child process: whatever happens there, the process that asks goes on."""

import contextlib
import ctypes
import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest
from builders import assert_one_sentence

from tepsipe.errors import InputError
from tepsipe.io.readers import guarded as module
from tepsipe.io.readers.guarded import guarded

pytestmark = pytest.mark.skipif(not module.FORKS, reason="files are read directly on this system")
FILE = "trial.c3d"


def crash():
    ctypes.string_at(0)


def loop():
    while True:
        pass


def allocate():
    return [np.ones(10_000_000) for _ in range(100)]


def children():
    """Process numbers of this process's children, the ended ones too, as Linux lists them."""
    path = Path(f"/proc/{os.getpid()}/task/{threading.get_native_id()}/children")
    return set(path.read_text().split()) if path.exists() else set()


def is_at_work(number):
    """Whether a process has not ended, as Linux lists it; one that nobody has waited for has ended."""
    status = Path(f"/proc/{number}/stat")
    try:
        return status.read_text().rpartition(") ")[2][0] not in "ZX"
    except OSError:
        return False


def open_files():
    return sorted(path.name for path in Path("/proc/self/fd").glob("*"))


def refused(function, *arguments, **limits):
    with pytest.raises(InputError) as caught:
        guarded(function, *arguments, what=FILE, **limits)
    assert_one_sentence(caught.value, FILE)
    return str(caught.value)


# ---- what comes back -----------------------------------------------------------------------------


def test_result_is_what_the_function_returned(rng):
    big = rng.standard_normal((3000, 7))
    sent = {
        "large": big,
        "transposed": big.T,
        "strided": big[::2, 1],
        "big-endian": big.astype(">f4"),
        "empty": np.zeros((0, 3)),
        "words": np.array(["belt", "leg"]),
        "objects": np.array([1, "a", None], dtype=object),
        "nested": [(1.5, "text"), {"x": big.astype(np.int16)}],
    }
    received = guarded(lambda: sent, what=FILE)
    assert pickle.dumps(received["nested"]) == pickle.dumps(sent["nested"])
    for name in list(sent)[:-1]:
        assert received[name].dtype == sent[name].dtype, name
        assert np.array_equal(received[name], sent[name]), name
        received[name][...] = received[name][::1]  # it is writable


def test_result_was_made_in_another_process_with_the_arguments_given():
    process, total = guarded(lambda *numbers: (os.getpid(), sum(numbers)), 1, 2, 3, what=FILE)
    assert process != os.getpid()
    assert total == 6


class Damaged:
    """An object that cannot be made again."""

    def __reduce__(self):
        return int, ("damaged",)


def test_result_that_cannot_be_made_again_is_refused():
    assert "ValueError" in refused(Damaged)


def test_result_that_shares_its_memory_is_refused_by_its_size():
    shared = np.zeros(10**7)
    assert len(guarded(lambda: [shared[k:] for k in range(3)], what=FILE)) == 3
    assert "memory" in refused(lambda: [shared[k:] for k in range(5)])
    assert "memory" in refused(lambda: [shared[k:] for k in range(3)], most_bytes=16)


def test_guard_within_a_guard_does_not_fork_again():
    outer, inner = guarded(lambda: (os.getpid(), guarded(os.getpid, what=FILE)), what=FILE)
    assert outer == inner != os.getpid()


def test_error_of_the_function_is_raised_again():
    def refuse():
        raise InputError("a.c3d: expected 3 markers, found 2: name them")

    with pytest.raises(InputError, match=r"^a\.c3d: expected 3 markers, found 2: name them$"):
        guarded(refuse, what=FILE)
    with pytest.raises(KeyError, match="rate"):
        guarded(lambda: {}["rate"], what=FILE)
    with pytest.raises(FileNotFoundError):
        guarded(open, "no such file", what=FILE)


def test_error_that_cannot_be_sent_is_named():
    class LocalError(Exception):
        pass

    def fail():
        raise LocalError("of this function only")

    with pytest.raises(RuntimeError, match=r"^LocalError: of this function only$"):
        guarded(fail, what=FILE)


def test_result_that_cannot_be_sent_is_an_error_of_the_programme():
    with pytest.raises(Exception, match=r"pickle|local object"):
        guarded(lambda: lambda: 0, what=FILE)


# ---- what is survived ----------------------------------------------------------------------------


def test_crash_is_refused():
    assert "SIGSEGV" in refused(crash)
    assert "SIGABRT" in refused(os.abort)


def test_child_that_ends_by_itself_is_refused():
    refused(os._exit, 0)
    assert "memory" in refused(
        lambda: os.kill(os.getpid(), signal.SIGKILL)
    )  # as the system does when it is full


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_child_that_somebody_ends_is_no_fault_of_the_file(number):
    with pytest.raises(KeyboardInterrupt, match=number.name):
        guarded(lambda: os.kill(os.getpid(), number), what=FILE)


def test_loop_is_stopped():
    start = time.process_time()
    assert "within 0.2 s" in refused(loop, longest_s=0.2)
    assert time.process_time() - start < 0.2


def test_reader_that_waits_for_ever_is_stopped(monkeypatch):
    monkeypatch.setattr(module, "WALL_S", 0.1)
    monkeypatch.setattr(module, "WALL_FACTOR", 1.0)
    assert "longer" in refused(time.sleep, 60.0, longest_s=0.1)


def test_reader_that_fills_the_memory_is_stopped():
    assert "100 MB" in refused(allocate, most_bytes=100_000_000)


def test_allowance_grows_with_the_file(tmp_path):
    small, large = tmp_path / "small", tmp_path / "large"
    small.write_bytes(b"")
    with large.open("wb") as file:
        file.truncate(10_000_000)
    few, many = (module._limits(path, None, None) for path in (small, large))
    assert (few.cpu_s, few.bytes) == (1.5, 300_000_000)
    assert (many.cpu_s, many.bytes) == (11.5, 800_000_000)


# ---- what is left as it was ----------------------------------------------------------------------


def test_no_child_and_no_open_file_is_left():
    before, files = children(), open_files()
    for function in (int, crash, os._exit):
        for _ in range(3):
            with contextlib.suppress(InputError):
                guarded(function, *([1] if function is os._exit else []), what=FILE)
    assert children() == before
    assert open_files() == files


def test_interrupt_ends_the_child_too():
    def interrupted(_, frame):
        # not within os.fork, which would lose the error and keep the locks that it has taken
        if frame.f_code.co_name == "receive":
            raise KeyboardInterrupt

    before, previous = children(), signal.signal(signal.SIGALRM, interrupted)
    try:
        signal.setitimer(signal.ITIMER_REAL, 0.1, 0.1)
        with pytest.raises(KeyboardInterrupt):
            guarded(time.sleep, 60.0, what=FILE)
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0.0)
        signal.signal(signal.SIGALRM, previous)
    assert children() == before


def test_signal_handlers_limits_and_output_stay(capfd):
    import resource

    kinds = (resource.RLIMIT_AS, resource.RLIMIT_CPU, resource.RLIMIT_CORE)
    numbers = (signal.SIGINT, signal.SIGTERM, signal.SIGPROF, signal.SIGXCPU, signal.SIGCHLD, signal.SIGPIPE)
    handlers = [signal.getsignal(number) for number in numbers]
    limits = [resource.getrlimit(kind) for kind in kinds]
    refused(crash)
    guarded(lambda: os.write(1, b"printed by a library"), what=FILE)
    assert [signal.getsignal(number) for number in numbers] == handlers
    assert [resource.getrlimit(kind) for kind in kinds] == limits
    assert signal.getitimer(signal.ITIMER_PROF) == (0.0, 0.0)
    assert capfd.readouterr() == ("", "")


def test_memory_of_the_parent_holds_the_result_once():
    resource = pytest.importorskip("resource")
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    result = guarded(np.zeros, 12_500_000, what=FILE)
    assert result.nbytes == 100_000_000
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before < 130_000  # kB


def test_threads_do_not_disturb_each_other():
    results = {}

    def read(number):
        try:
            results[number] = guarded(crash if number % 4 == 0 else np.full, 20_000, number, what=FILE)
        except (InputError, TypeError) as error:
            results[number] = error

    threads = [threading.Thread(target=read, args=(number,)) for number in range(12)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for number, result in results.items():
        if number % 4:
            assert np.array_equal(result, np.full(20_000, number))
        else:
            assert isinstance(result, TypeError)
    assert len(results) == 12


def _read_in_a_worker(queue):
    queue.put(guarded(os.getpid, what=FILE) != os.getpid())


@pytest.mark.slow
@pytest.mark.parametrize("method", ["fork", "spawn"])
def test_worker_that_may_have_no_children_can_still_read(method):
    context = multiprocessing.get_context(method)
    queue = context.Queue()
    worker = context.Process(target=_read_in_a_worker, args=(queue,), daemon=True)
    worker.start()
    assert queue.get(timeout=60)
    worker.join()


def test_where_there_is_no_fork_the_file_is_read_directly(monkeypatch):
    monkeypatch.setattr(module, "FORKS", False)
    assert guarded(os.getpid, what=FILE) == os.getpid()


def test_where_no_process_can_be_started_the_file_is_read_directly(monkeypatch):
    def full():
        raise BlockingIOError

    files = open_files()
    monkeypatch.setattr(os, "fork", full)
    assert guarded(os.getpid, what=FILE) == os.getpid()
    assert open_files() == files


def test_nothing_that_costs_is_added_to_a_good_file():
    """In a process of its own, because the cost of a child grows with the memory of its parent."""
    code = (
        "import os, numpy as np\n"
        "from tepsipe.io.readers.guarded import guarded\n"
        "start = os.times()\n"
        "for _ in range(10):\n"
        f"    guarded(np.ones, 100_000, what={FILE!r})\n"
        "spent = os.times()\n"
        "print(sum(spent[:4]) - sum(start[:4]))\n"
    )
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert float(ran.stdout) < 10 * 0.05


@pytest.mark.slow
@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="processes are listed on Linux only")
def test_a_child_ends_with_the_process_that_reads(tmp_path):
    def read_slowly():
        (tmp_path / "child").write_text(str(os.getpid()))
        time.sleep(0.5)
        return np.ones(10_000_000)  # more than a pipe holds

    parent = os.fork()
    if parent == 0:
        guarded(read_slowly, what=FILE)
        os._exit(0)
    while not (tmp_path / "child").is_file() or not (tmp_path / "child").read_text():
        time.sleep(0.01)
    os.kill(parent, signal.SIGKILL)
    os.waitpid(parent, 0)
    child = int((tmp_path / "child").read_text())
    deadline = time.monotonic() + 10.0
    while is_at_work(child) and time.monotonic() < deadline:
        time.sleep(0.05)
    left = is_at_work(child)
    if left:
        os.kill(child, signal.SIGKILL)
    assert not left, "the child has not ended"
