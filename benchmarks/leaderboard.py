"""Leaderboard of a benchmark: all baselines, and entries from elsewhere, on the same problems.

    .venv/bin/python benchmarks/leaderboard.py benchmarks/enter_with_sysidentpy.py > benchmarks/leaderboard.md

makes the problems of the practice round in a temporary folder, runs the baselines and every script that is
named (called with the folder and the table of answers to write), and prints the page. What each step takes is
printed to the standard error.
"""

import argparse
import hashlib
import subprocess
import sys
import tempfile
import time
from contextlib import contextmanager
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from tepsipe.experiments.benchmark.baselines import METHODS, answer_all  # noqa: E402
from tepsipe.experiments.benchmark.problems import ANSWERS, QUANTITIES, read_problems  # noqa: E402
from tepsipe.reporting.benchmark import (  # noqa: E402
    NOMINAL,
    read_answers,
    read_truth,
    scores_of,
    table_of,
)
from workflow.benchmark import make_benchmark  # noqa: E402
from workflow.support.yaml_file import read_constants  # noqa: E402

# of the practice round, whose truth is no secret
SEED, PER_KIND = 20261129, 10

PAGE = """\
# Leaderboard of the benchmark

Practice round: {per_kind} problems of each of {kinds} kinds, {spoiled} of them spoiled, made with the seed
{seed}. SHA-256 of the truth:

    {digest}

The page [Benchmark](../docs/benchmark.md) explains problems, methods and scores. Bias, errors,
coverage and interval score are those of nominal problems. `benchmarks/leaderboard.py` made this
page.
"""


@contextmanager
def timed(what: str):
    """Print what a step takes."""
    start, cpu = time.perf_counter(), time.process_time()
    yield
    seconds, cpu = time.perf_counter() - start, time.process_time() - cpu
    print(f"{what}: {seconds:.1f} s, {cpu:.1f} CPU-s of this process", file=sys.stderr, flush=True)


def main() -> None:
    """Print the page as Markdown."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("entries", nargs="*", type=Path, help="scripts, called with FOLDER and ANSWERS.csv")
    parser.add_argument("--seed", type=int, default=SEED)
    parser.add_argument("--per-kind", type=int, default=PER_KIND)
    chosen = parser.parse_args()
    with tempfile.TemporaryDirectory() as temporary:
        folder, file = Path(temporary) / "problems", Path(temporary) / "truth.json"
        with timed("make"):
            constants = read_constants(ROOT / "config/virtual_lab.yaml")
            make_benchmark(folder, file, chosen.seed, chosen.per_kind, constants)
        answers = []
        with timed("baselines"):
            for method, rows in answer_all(read_problems(folder), METHODS).items():
                answers.append(Path(temporary) / f"{method}.csv")
                ANSWERS.write(answers[-1], rows)
        for script in chosen.entries:
            answers.append(Path(temporary) / f"{script.stem.removeprefix('enter_with_')}.csv")
            with timed(script.name):
                subprocess.run([sys.executable, script, folder, answers[-1]], check=True)
        truth, digest = read_truth(file), hashlib.sha256(file.read_bytes()).hexdigest()
        rows = [row for path in answers for row in scores_of(path.stem, read_answers(path, truth), truth)]
    spoiled = sum(hidden.fault != NOMINAL for hidden in truth.values())
    print(
        PAGE.format(
            per_kind=chosen.per_kind, kinds=len(QUANTITIES), spoiled=spoiled, seed=chosen.seed, digest=digest
        )
    )
    print(f"## By kind\n\n{table_of(rows)}\n")
    print(f"## By quantity\n\n{table_of(rows, by_quantity=True)}")


if __name__ == "__main__":
    main()
