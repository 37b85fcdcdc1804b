"""Random damage to every kind of file: a reader gives a result or refuses the file in one sentence.

    .venv/bin/python benchmarks/soak/mutations.py --mutations 10000 --seed 1
    .venv/bin/python benchmarks/soak/mutations.py --reader edf-emg --only 1234

The second line repeats one mutation, with its traceback: every mutation has a seed of its own. Workers are
forked once and read one damaged file after the other. It is a violation if a reader raises anything else than
`InputError`, if its message is no sentence that names the file and what is wrong, if a successful read lacks
what the reader promises, if it takes more than 2 s of processor time or 500 MB, and if it ends its worker or
stops it for a minute.
"""

import argparse
import faulthandler
import multiprocessing
import os
import resource
import sys
import tempfile
import time
import traceback
import warnings
from dataclasses import dataclass, field
from multiprocessing.sharedctypes import RawArray
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).parents[2]))

from benchmarks.soak.damage import mutate
from benchmarks.soak.readers import READERS, Reader
from tepsipe.errors import InputError

# messages about a reader that crashed, or was stopped, in its child process
OF_THE_GUARD = ("crashes its reader", "that takes longer", "that needs more")
LONGEST_S, MOST_MB, STUCK_S = 2.0, 500.0, 60.0
OWN_MB = 300.0  # beyond what a worker holds from the start, for example of a long run of tests
# what workers write down while they read: next mutation, when it started, and sums
NEXT, STARTED, READ, REFUSED, ENDED, LONGEST, MEMORY = range(7)


@dataclass
class Outcome:
    """Sums over the mutations of one reader."""

    reader: str
    mutations: int = 0
    read: int = 0
    refused: int = 0
    ended: int = 0
    longest_s: float = 0.0
    memory_mb: float = 0.0
    violations: list[str] = field(default_factory=list)


def damaged(reader: str, files: list[Path], seed: int, k: int) -> tuple[Path, bytes]:
    """The file and the contents of one mutation."""
    rng = np.random.default_rng([seed, *reader.encode(), k])
    path = files[int(rng.integers(len(files)))]
    text = READERS[reader].text or path.name.endswith((".txt", ".csv", ".txt.gz", ".json"))
    return path, mutate(path.read_bytes(), rng, text)


def sentence_lacks(message: str, path: Path) -> str:
    """Part of a readable sentence that a message lacks; empty if none."""
    words = (str(path),) if ": unknown " in message else (str(path), "expected", "found")
    lacking = [repr(word) for word in words if word not in message]
    if "\n" in message:
        lacking.append("one line")
    if len(message) > 600 + len(str(path)):
        lacking.append("brevity")
    return ", ".join(lacking)


def attempt(reader: Reader, path: Path) -> tuple[int, str]:
    """Read one file: READ, REFUSED or ENDED, and what is wrong with that (empty if nothing)."""
    try:
        content = reader.read(path)
    except InputError as error:
        lacking = sentence_lacks(str(error), path)
        how = ENDED if any(words in str(error) for words in OF_THE_GUARD) else REFUSED
        return how, f"the message lacks {lacking}: {error}" if lacking else ""
    except Exception as error:  # this is what is looked for
        frame = traceback.extract_tb(error.__traceback__)[-1]
        return REFUSED, f"{type(error).__name__} at {Path(frame.filename).name}:{frame.lineno}: {error}"
    try:
        reader.check(content)
    except AssertionError as error:
        return READ, f"the result lacks what is promised: {error}"
    except Exception as error:  # of any kind: what was read cannot be looked at
        return READ, f"the result ends its check: {type(error).__name__}: {error}"
    return READ, ""


def used() -> tuple[float, float]:
    """Processor time (s) and most memory (MB) of this process and its children so far."""
    both = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(u.ru_utime + u.ru_stime for u in both), max(u.ru_maxrss for u in both) / 1e3


def work(name: str, files: list[Path], seed: int, ks: range, folder: Path, notes) -> None:
    """Read damaged files one after the other, starting with the next one."""
    warnings.simplefilter("ignore")
    faulthandler.disable()  # a crash is noted by whoever waits for this process
    allowed_mb = max(MOST_MB, used()[1] + OWN_MB)
    while (k := int(notes[NEXT])) < len(ks):
        path, content = damaged(name, files, seed, ks[k])
        path = folder / path.name
        path.write_bytes(content)
        before, memory = used()
        notes[STARTED] = time.monotonic()
        how, wrong = attempt(READERS[name], path)
        took, most = used()[0] - before, used()[1]
        if not wrong and took > LONGEST_S:
            wrong = f"it took {took:.2f} s"
        if not wrong and most > max(memory, allowed_mb):
            wrong = f"it took {most:.0f} MB"
        if wrong:
            report(folder, ks[k], wrong)
        notes[how] += 1
        notes[LONGEST], notes[MEMORY] = max(notes[LONGEST], took), max(notes[MEMORY], most)
        notes[NEXT] = k + 1
    os._exit(0)


def report(folder: Path, k: int, wrong: str) -> None:
    """Note a violation where it survives the worker."""
    with (folder / "violations.txt").open("a", encoding="utf-8") as file:
        file.write(f"mutation {k}: {' '.join(wrong.split())[:400]}\n")


def run(reader: str, mutations: int, seed: int = 1, cores: int = 2, first: int = 0) -> Outcome:
    """Damage the good files of a reader so many times, and read them.

    Parameters
    ----------
    reader : str
        One of READERS.
    mutations : int
        Number of mutations.
    seed : int
        Seed of all random choices.
    cores : int
        Number of workers.
    first : int
        Number of the first mutation.
    """
    outcome = Outcome(reader, mutations)
    context = multiprocessing.get_context("fork")
    with tempfile.TemporaryDirectory(dir="/dev/shm" if os.access("/dev/shm", os.W_OK) else None) as name:
        good = Path(name) / "good"
        good.mkdir()
        files = READERS[reader].make(good)
        for path in files:
            how, wrong = attempt(READERS[reader], path)
            if how != READ or wrong:
                outcome.violations.append(f"the good file {path.name} is not read: {wrong}")
        workers = []
        for core in range(cores):
            folder = Path(name) / str(core)
            folder.mkdir()
            notes = RawArray("d", 7)
            notes[STARTED] = time.monotonic()
            arguments = (reader, files, seed, range(first + core, first + mutations, cores), folder, notes)
            workers.append([context.Process(target=work, args=arguments), arguments])
            workers[-1][0].start()
        while workers:
            time.sleep(0.02)
            workers = [again for worker in workers if (again := _looked_after(worker, context, outcome))]
    return outcome


def _looked_after(worker: list, context, outcome: Outcome) -> list | None:
    """Replace a worker that ended or stalled in a mutation; None when all its work is done."""
    process, arguments = worker
    *_, ks, folder, notes = arguments
    stuck = time.monotonic() - notes[STARTED] > STUCK_S
    if process.is_alive() and not stuck:
        return worker
    done = process.exitcode == 0
    process.kill()
    process.join()
    if not done:
        k = int(notes[NEXT])
        report(folder, ks[k], f"it {'stopped' if stuck else f'ended ({process.exitcode})'} its worker")
        notes[NEXT], notes[STARTED] = k + 1, time.monotonic()
        process = context.Process(target=work, args=arguments)
        process.start()
        return [process, arguments]
    outcome.read += int(notes[READ])
    outcome.refused += int(notes[REFUSED])
    outcome.ended += int(notes[ENDED])
    outcome.longest_s = max(outcome.longest_s, notes[LONGEST])
    outcome.memory_mb = max(outcome.memory_mb, notes[MEMORY])
    if (folder / "violations.txt").exists():
        outcome.violations += (folder / "violations.txt").read_text(encoding="utf-8").splitlines()
    return None


def table(outcomes: list[Outcome]) -> str:
    """Outcomes as a table in Markdown."""
    lines = [
        "| Reader | Mutations | Read | Refused | Ended | Longest (s) | Most memory (MB) | Violations |",
        "|---|---:|---:|---:|---:|---:|---:|---:|",
    ]
    lines += [
        f"| {o.reader} | {o.mutations} | {o.read} | {o.refused} | {o.ended} | {o.longest_s:.2f} | "
        f"{o.memory_mb:.0f} | {len(o.violations)} |"
        for o in outcomes
    ]
    return "\n".join(lines)


def again(reader: str, seed: int, k: int) -> None:
    """Repeat one mutation in this process, with its traceback."""
    with tempfile.TemporaryDirectory() as name:
        path, content = damaged(reader, READERS[reader].make(Path(name)), seed, k)
        path.write_bytes(content)
        kept = Path(tempfile.gettempdir()) / f"mutation-{reader}-{k}{''.join(path.suffixes)}"
        kept.write_bytes(content)
        print(f"{kept}: {len(content)} bytes, made from {path.name}")
        result = READERS[reader].read(path)
        READERS[reader].check(result)
        print("read")


def main() -> int:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--mutations", type=int, default=10000, help="per reader (default 10000)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--reader", choices=list(READERS), action="append", help="only this one")
    parser.add_argument("--cores", type=int, default=2, help="number of workers (default 2)")
    parser.add_argument("--first", type=int, default=0, help="number of the first mutation (default 0)")
    parser.add_argument("--only", type=int, help="number of the one mutation of --reader to be repeated")
    parser.add_argument("--show", type=int, default=10, help="most violations to be shown per reader")
    given = parser.parse_args()
    if given.only is not None:
        again(given.reader[0], given.seed, given.only)
        return 0
    outcomes = []
    for reader in given.reader or READERS:
        outcome = run(reader, given.mutations, given.seed, given.cores, given.first)
        outcomes.append(outcome)
        print(table(outcomes).splitlines()[-1], flush=True)
        for violation in outcome.violations[: given.show]:
            print(f"  {violation}", flush=True)
    print(table(outcomes))
    return int(any(o.violations for o in outcomes))


if __name__ == "__main__":
    sys.exit(main())
