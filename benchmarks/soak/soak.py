"""The whole campaign: damaged files, bad inputs, kills, other processors; its tables go to results.md.

    make soak                                       # at most 60 minutes on two cores
    .venv/bin/python benchmarks/soak/soak.py --part mutations --seed 2

A part is a script of this folder that prints its table and ends with 0 if there is no violation.
"""

import argparse
import contextlib
import datetime
import os
import platform
import subprocess
import sys
import threading
import time
from pathlib import Path

import psutil

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
TITLES = {
    "mutations": "Damaged files",
    "bad_inputs": "Bad inputs",
    "kills": "Kills",
    "core_types": "Other processors",
}


def arguments(part: str, given: argparse.Namespace) -> list[str]:
    """Arguments of a part's script."""
    options = {
        "mutations": ["--seed", str(given.seed), "--mutations", str(given.mutations)],
        "bad_inputs": ["--seed", str(given.seed)],
        "kills": ["--seed", str(given.seed), "--kills", str(given.kills)],
        "core_types": [],
    }
    return [*options[part], "--cores", str(given.cores)]


def perform(part: str, given: argparse.Namespace, until: float) -> tuple[int, str, float]:
    """Run a part: its exit code, what it printed, how long it took (s); it is stopped when time is up."""
    start, said = time.monotonic(), []
    command = [sys.executable, str(HERE / f"{part}.py"), *arguments(part, given)]
    environment = dict(os.environ, OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1", PYTHONUNBUFFERED="1")
    process = subprocess.Popen(
        command, cwd=ROOT, env=environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    stop = threading.Timer(max(1.0, until - start), _kill, [process.pid])
    stop.start()
    try:
        for line in process.stdout:
            print(line, end="", flush=True)
            said.append(line)
        process.wait()
    finally:
        stop.cancel()
        if process.poll() is None:
            _kill(process.pid)
            process.wait()
    return process.returncode, "".join(said), time.monotonic() - start


def _kill(number: int) -> None:
    """Kill a process and all that it started."""
    with contextlib.suppress(psutil.NoSuchProcess):
        process = psutil.Process(number)
        for each in [process, *process.children(recursive=True)]:
            with contextlib.suppress(psutil.NoSuchProcess):
                each.kill()


def commit() -> str:
    """Commit of the checkout, marked where files differ from it."""
    git = ["git", "describe", "--always", "--dirty", "--abbrev=12", "--exclude=*"]
    done = subprocess.run(git, cwd=ROOT, capture_output=True, text=True)
    return done.stdout.strip() or "unknown"


def tables(said: str) -> str:
    """The last table that a part printed, and what stands under it."""
    lines = said.rstrip().splitlines()
    heads = [k for k, line in enumerate(lines) if line.startswith("|---")]
    return "\n".join(lines[max(0, heads[-1] - 1) :]) if heads else "\n".join(f"    {line}" for line in lines)


def main() -> int:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--part", choices=list(TITLES), action="append", help="only this part")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--mutations", type=int, default=10000, help="per reader (default 10000)")
    parser.add_argument("--kills", type=int, default=20, help="of a small study (default 20)")
    parser.add_argument("--cores", type=int, default=2)
    parser.add_argument("--minutes", type=float, default=60.0, help="longest time of all (default 60)")
    parser.add_argument("--into", type=Path, default=HERE / "results.md", help="file of the tables")
    given = parser.parse_args()
    until = time.monotonic() + 60.0 * given.minutes
    now = datetime.datetime.now(datetime.UTC)
    report = [
        "# Results of the soak campaign",
        f"Commit {commit()}, seed {given.seed}, {now:%Y-%m-%d}, Python {platform.python_version()}, "
        f"{platform.system()} on {platform.machine()}, cores: {given.cores}.\n"
        "Made by `make soak`. [README.md](README.md) defines a violation.",
    ]
    failed = []
    for part in given.part or TITLES:
        code, said, took = perform(part, given, until)
        end = "without violations" if code == 0 else f"with violations or stopped (exit code {code})"
        failed += [part] if code else []
        report += [f"## {TITLES[part]}", f"{took / 60.0:.1f} minutes, {end}.", tables(said)]
        given.into.write_text("\n\n".join(report) + "\n", encoding="utf-8")
    print(f"{given.into}: {'no violations' if not failed else 'violations in ' + ', '.join(failed)}")
    return int(bool(failed))


if __name__ == "__main__":
    sys.exit(main())
