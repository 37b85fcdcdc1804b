"""A sample of the campaign of mutations, and the campaign's own promises."""

import ctypes
import time

import pytest

from benchmarks.soak import mutations
from benchmarks.soak.readers import READERS, Reader
from tepsipe.errors import InputError
from tepsipe.io.readers.guarded import FORKS

pytestmark = pytest.mark.skipif(not FORKS, reason="workers are forked")


@pytest.mark.slow
@pytest.mark.parametrize("reader", READERS)
def test_damaged_file_is_read_or_refused_in_one_sentence(reader):
    count = 100 if READERS[reader].text else 40  # what is read in a child takes longer
    outcome = mutations.run(reader, count, seed=2, cores=1)
    assert outcome.violations == []
    assert outcome.read + outcome.refused + outcome.ended == outcome.mutations == count
    assert outcome.read > 3
    assert outcome.refused + outcome.ended > 8


def test_mutation_is_the_same_whenever_it_is_repeated(tmp_path):
    files = READERS["calibration"].make(tmp_path)
    first, again, other = (mutations.damaged("calibration", files, 1, k)[1] for k in (7, 7, 8))
    assert first == again != other


def good(folder):
    path = folder / "good.csv"
    path.write_text("".join(f"{k},{k + 1}\n" for k in range(50)))
    return [path]


def campaign(monkeypatch, read, check=lambda found: None, count=40):
    monkeypatch.setitem(READERS, "invented", Reader(good, read, check, text=True))
    return mutations.run("invented", count, cores=1)


def unlike_the_good_one(path):
    return path.read_bytes() != "".join(f"{k},{k + 1}\n" for k in range(50)).encode()


def test_other_errors_are_violations(monkeypatch):
    def read(path):
        if unlike_the_good_one(path):
            raise KeyError("rate")

    outcome = campaign(monkeypatch, read)
    assert len(outcome.violations) > 30
    assert "KeyError" in outcome.violations[0]


def test_message_without_the_file_is_a_violation(monkeypatch):
    def read(path):
        if unlike_the_good_one(path):
            raise InputError("expected a number, found none: correct it")

    assert "good.csv" in campaign(monkeypatch, read).violations[0]


def test_broken_promise_is_a_violation(monkeypatch):
    def check(size):
        assert size == 0, "numbers"

    outcome = campaign(monkeypatch, lambda path: int(unlike_the_good_one(path)), check)
    assert "numbers" in outcome.violations[0]


@pytest.mark.slow
def test_crash_and_loop_are_violations_and_the_next_file_is_read(monkeypatch):
    monkeypatch.setattr(mutations, "STUCK_S", 0.3)

    def read(path):
        content = path.read_bytes()
        if not unlike_the_good_one(path):
            return
        if len(content) % 7 == 0:
            ctypes.string_at(0)
        if len(content) % 7 == 1:
            time.sleep(60.0)

    outcome = campaign(monkeypatch, read, count=12)
    ended = [v for v in outcome.violations if "ended" in v]
    stopped = [v for v in outcome.violations if "stopped" in v]
    assert len(ended) > 0
    assert len(ended) + len(stopped) == len(outcome.violations) == outcome.mutations - outcome.read


def test_slow_reader_is_a_violation(monkeypatch):
    monkeypatch.setattr(mutations, "LONGEST_S", 0.01)

    def read(path):
        until = time.process_time() + 0.02 * unlike_the_good_one(path)
        while time.process_time() < until:
            pass

    assert "it took" in campaign(monkeypatch, read, count=10).violations[0]
