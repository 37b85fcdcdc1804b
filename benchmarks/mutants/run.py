"""Small faults put into the library one at a time: do the tests of the package notice?

    .venv/bin/python benchmarks/mutants/run.py --into benchmarks/mutants/drawn.tsv
    .venv/bin/python benchmarks/mutants/run.py --list --count 200 > mutants.tsv
    .venv/bin/python benchmarks/mutants/run.py --only mutants.tsv

Every mutant is applied in a scratch copy of the project, where the tests of the mutated package then run
until the first one fails. `--only` repeats the mutants of a list, or of a table of results, on another
version of the project: it finds their functions by code and name, in whatever file.
"""

import argparse
import ast
import csv
import hashlib
import os
import queue
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter, defaultdict
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))

from benchmarks.mutants.sites import OPERATORS, Site, mutated, sites

ROOT = Path(__file__).parents[2]
PACKAGES = ("signals", "mechanics", "identification", "statistics", "treadmill", "ingest", "io")
NOT_COPIED = (".venv", ".git", ".snakemake", "__pycache__", "results", "recordings", "*.egg-info")
MARKS = "not study"
IDENTITY = ("package", "function", "operator", "ordinal", "fingerprint", "before", "after")
RESULT = (*IDENTITY, "file", "line", "outcome", "test", "seconds")


@dataclass(frozen=True)
class Mutant:
    """A site, its package, and its module's path from the root."""

    package: str
    path: str
    site: Site

    def row(self) -> dict[str, str]:
        """Row of a table."""
        identity = {name: getattr(self.site, name) for name in IDENTITY[1:]}
        return {"package": self.package, **identity, "file": self.path, "line": str(self.site.line)}


def all_mutants(root: Path) -> list[Mutant]:
    """Return every mutant of the library."""
    paths = {path: path.relative_to(root) for path in sorted((root / "tepsipe").glob("*/**/*.py"))}
    return [
        Mutant(inside.parts[1], inside.as_posix(), site)
        for path, inside in paths.items()
        for site in sites(path.read_text(encoding="utf-8"))
    ]


def draw(mutants: list[Mutant], count: int, seed: int) -> list[Mutant]:
    """Draw mutants: packages and operators take turns, and no function comes twice while others are left.

    A hash of the mutant and the seed orders them, so that a draw changes little if the library does.
    """

    def rank(mutant: Mutant) -> str:
        identity = [mutant.row()[name] for name in IDENTITY[:5]]
        return hashlib.sha256(repr([seed, *identity]).encode()).hexdigest()

    waiting = defaultdict(list)
    for mutant in sorted(mutants, key=rank):
        waiting[mutant.package, mutant.site.operator].append(mutant)
    drawn, used = [], set()
    for k in range(count):
        package, turn = PACKAGES[k % len(PACKAGES)], k % len(OPERATORS)
        operators = OPERATORS[turn:] + OPERATORS[:turn]
        rest = [one for operator in operators for one in waiting[package, operator] if one not in drawn]
        rest.sort(key=lambda one: (one.path, one.site.function) in used)
        drawn += rest[:1]
        used |= {(one.path, one.site.function) for one in rest[:1]}
    return drawn


def find(wanted: dict[str, str], mutants: list[Mutant]) -> Mutant | str:
    """Find the mutant of a list in this version of the library, or say why there is none.

    The function is known by its code, or else by its name in the package. If its code has changed, the place
    must have the same text, or the function as many places of the operator as before.
    """

    def same(mutant: Mutant, *names: str) -> bool:
        return all(mutant.row()[name] == wanted[name] for name in names)

    alike = [one for one in mutants if same(one, "fingerprint", "operator", "ordinal", "before")]
    if alike:
        return max(alike, key=lambda one: (same(one, "package"), same(one, "function")))
    named = [one for one in mutants if same(one, "package", "function", "operator")]
    if len({one.path for one in named}) > 1:
        return "several functions of this name, all with other code"
    for names in (("ordinal", "before", "after"), ("before", "after"), ("ordinal",)):
        fitting = [one for one in named if same(one, *names)]
        if len(fitting) == 1:
            return fitting[0]
    return "place not found in the function" if named else "function not found"


def imported(path: Path, public: dict[str, str]) -> set[str]:
    """Return the modules that a test file imports, also by the public names of the library."""
    modules = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            modules |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            modules |= {node.module, *(f"{node.module}.{alias.name}" for alias in node.names)}
    return modules | {public[name] for name in modules if name in public}


def tests_of(root: Path, package: str, module: str = "") -> list[str]:
    """Return the test files of a package, those that import the module first.

    They lie in ``tests/<package>``; without this folder, they are all that import from the package.
    """
    public = (root / "tepsipe/__init__.py").read_text(encoding="utf-8")
    public = {f"tepsipe.{name}": place for name, place in re.findall(r'"(\w+)": "(tepsipe[\w.]+)"', public)}
    folder = root / "tests" / package
    files = sorted((folder if folder.is_dir() else root / "tests").rglob("test_*.py"))
    imports = {file: imported(file, public) for file in files}
    if not folder.is_dir():
        wanted = f"tepsipe.{package}."
        files = [file for file in files if any(f"{name}.".startswith(wanted) for name in imports[file])]
    files.sort(key=lambda file: module not in imports[file])
    return [file.relative_to(root).as_posix() for file in files]


def run_tests(tree: Path, files: list[str], limit_s: float, *options: str) -> tuple[str, str]:
    """Run test files in a copy of the project: survived, killed or timeout, and the first test that fails."""
    command = [sys.executable, "-m", "pytest", "-q", "--tb=no", "-p", "no:cacheprovider", "-m", MARKS]
    command += [f"--basetemp={tree.parent / 'tmp'}", *options, *files]
    environment = {"TEPSIPE_REAL_DATA": str(ROOT.parent / "shared" / "real-data"), **os.environ}
    # modules are compiled before, without a mutant
    environment |= {"PYTHONPATH": str(tree), "PYTHONDONTWRITEBYTECODE": "1"}
    into = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
    with subprocess.Popen(command, cwd=tree, env=environment, start_new_session=True, **into) as process:
        try:
            said = process.communicate(timeout=limit_s)[0]
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            return "timeout", ""
    if process.returncode == 0:
        return "survived", ""
    if process.returncode in (3, 4, 5):
        raise RuntimeError(f"pytest could not run in {tree}:\n{said[-3000:]}")
    failed = re.search(r"^(?:FAILED|ERROR) (.+?)(?: - .*)?$", said, re.MULTILINE)
    return "killed", failed[1] if failed else f"pytest ended with {process.returncode}"


class Copies:
    """Scratch copies of the project, one for each process that tests."""

    def __init__(self, folder: Path, count: int):
        self.free: queue.Queue[Path] = queue.Queue()
        for k in range(count):
            tree = folder / str(k) / "project"
            shutil.copytree(ROOT, tree, ignore=shutil.ignore_patterns(*NOT_COPIED), symlinks=True)
            subprocess.run([sys.executable, "-m", "compileall", "-q", tree], check=True)
            self.free.put(tree)

    def time(self, package: str) -> float:
        """Run all tests of a package without a mutant; return the seconds that they take."""
        tree, start = self.free.get(), time.monotonic()
        try:
            outcome, test = run_tests(tree, tests_of(tree, package), 1800.0)
        finally:
            self.free.put(tree)
        if outcome != "survived":
            raise SystemExit(f"tests of {package} without a mutant: {outcome} {test}")
        return time.monotonic() - start

    def attempt(self, mutant: Mutant, limit_s: float) -> dict[str, str]:
        """Run the tests of the mutant's package with the mutant."""
        tree, start = self.free.get(), time.monotonic()
        path = tree / mutant.path
        source, stamp = path.read_bytes(), path.stat().st_mtime_ns
        module = mutant.path.removesuffix(".py").removesuffix("/__init__").replace("/", ".")
        try:
            path.write_text(mutated(source.decode(), mutant.site), encoding="utf-8")
            outcome, test = run_tests(tree, tests_of(tree, mutant.package, module), limit_s, "-x")
        finally:
            path.write_bytes(source)
            os.utime(path, ns=(stamp, stamp))  # so that the compiled module is valid again
            self.free.put(tree)
        row = mutant.row() | {"outcome": outcome, "test": test, "seconds": f"{time.monotonic() - start:.0f}"}
        print(outcome, f"{row['file']}:{row['line']}", row["before"], "->", row["after"], test, flush=True)
        return row


def write_table(rows: list[dict[str, str]], names: tuple[str, ...], file) -> None:
    """Write rows as a table with tabs; quotes stand as they are."""
    print(*names, sep="\t", file=file)
    for row in rows:
        print(*(row[name] for name in names), sep="\t", file=file)


def scores(rows: list[dict[str, str]]) -> str:
    """Return a table of the score per package: killed and timeout of all that ran."""
    lines = ["| Package | Mutants | Killed | Timeout | Survived | Score |", "|---|---|---|---|---|---|"]
    for package in (*dict.fromkeys(row["package"] for row in rows), "all"):
        outcomes = Counter(row["outcome"] for row in rows if package in (row["package"], "all"))
        score = 1.0 - outcomes["survived"] / outcomes.total()
        counts = [outcomes.total(), outcomes["killed"], outcomes["timeout"], outcomes["survived"]]
        lines.append(f"| {package} | {' | '.join(map(str, counts))} | {score:.0%} |")
    return "\n".join(lines)


def main() -> int:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=40, help="number of mutants (default: 40)")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--cores", type=int, default=2, help="test processes at a time (default: 2)")
    parser.add_argument("--list", action="store_true", help="print the mutants and run nothing")
    parser.add_argument("--only", type=Path, metavar="FILE", help="mutants of this table, not drawn ones")
    parser.add_argument("--into", type=Path, metavar="FILE", help="write the table of results")
    given = parser.parse_args()

    mutants, skipped = all_mutants(ROOT), []
    if given.only:
        with open(given.only, newline="", encoding="utf-8") as file:
            wanted = list(csv.DictReader(file, delimiter="\t", quoting=csv.QUOTE_NONE))
        matches = [find(row, mutants) for row in wanted]
        chosen = [one for one in matches if isinstance(one, Mutant)]
        for row, why in zip(wanted, matches, strict=True):
            if isinstance(why, str):
                row |= {"file": "", "line": "", "outcome": "skipped", "test": why, "seconds": ""}
                skipped.append(row)
                print("skipped", row["package"], row["function"], row["before"], why, file=sys.stderr)
    else:
        chosen = draw(mutants, given.count, given.seed)
    if given.list:
        write_table([mutant.row() for mutant in chosen], IDENTITY, sys.stdout)
        return 0

    with tempfile.TemporaryDirectory(prefix="mutants-") as folder, ThreadPoolExecutor(given.cores) as pool:
        copies = Copies(Path(folder), given.cores)
        packages = sorted({mutant.package for mutant in chosen})
        took_s = dict(zip(packages, pool.map(copies.time, packages), strict=True))
        print("without a mutant:", *(f"{name} {took:.0f} s" for name, took in took_s.items()), flush=True)
        limits_s = [60.0 + 3.0 * took_s[mutant.package] for mutant in chosen]
        rows = list(pool.map(copies.attempt, chosen, limits_s))
    print(scores(rows))
    if given.into:
        with open(given.into, "w", encoding="utf-8") as file:
            write_table(rows + skipped, RESULT, file)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
