"""Kill a small study at random moments, resume it with make, compare every result with an undisturbed run.

    .venv/bin/python benchmarks/soak/kills.py --kills 20 --seed 1

Each time one of three is killed with SIGKILL: Snakemake alone (its jobs must end with it), Snakemake and all
its jobs (as at a power cut), or one job (as where memory runs out). It is a violation if a resumed run fails,
if a job that was killed is not named with its signal, or if a result differs by a byte. Logs and the HTML
report, which holds times, are not compared. A study that is complete before all kills are done is compared,
removed and made again.
"""

import argparse
import hashlib
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np
import psutil

ROOT = Path(__file__).parents[2]
sys.path[:0] = [str(ROOT), str(ROOT / "tests")]

from study_builders import copy_project  # noqa: E402

TARGETS = ("snakemake", "snakemake and jobs", "one job")
# after the start of Snakemake: the configuration is read in the first seconds (s)
EARLIEST_S, LATEST_S = 0.5, 14.0
NOT_COMPARED = ("logs/",)
SAID = "said.txt"
PRELOADED = "workflow.support.preload"  # in the command of the fork server and of its forks
SIGKILL = "found it stopped by the signal SIGKILL"


@dataclass
class Kill:
    """One kill and what followed; ``files`` are the results that were there."""

    kill: int
    target: str
    moment_s: float
    files: int = 0
    violation: str = ""


def run(seed: int = 1, kills: int = 20, cores: int = 2, folder: Path | None = None) -> list[dict]:
    """Kill a study so many times; rows of kills, and a last one for the comparison.

    Parameters
    ----------
    seed : int
        Seed of moments and targets.
    kills : int
        Number of kills.
    cores : int
        Number of cores of every run.
    folder : Path, optional
        Folder of both studies; a temporary folder, which is removed, if left out.
    """
    if folder is None:
        with tempfile.TemporaryDirectory(prefix="tepsipe-kills-") as name:
            return run(seed, kills, cores, Path(name))
    rng = np.random.default_rng(seed)
    undisturbed, killed = (_project(folder / name) for name in ("undisturbed", "killed"))
    if _make(undisturbed, cores).wait():
        raise RuntimeError(f"the undisturbed study fails:\n{_said(undisturbed)}")
    wanted = digests(undisturbed)
    rows, differing = [], set()
    while len(rows) < kills:
        row = Kill(
            len(rows) + 1, TARGETS[rng.integers(3)], round(float(rng.uniform(EARLIEST_S, LATEST_S)), 2)
        )
        process = _make(killed, cores)
        if not _kill(process, killed, row, rng):  # the study was complete before
            differing |= _differing(wanted, killed)
            shutil.rmtree(killed / "results")
            continue
        row.files = len(digests(killed))
        rows.append(row)
        line = f"{row.kill:3d}  {row.target:18s} {row.moment_s:6.2f} s  {row.files:4d} files"
        print(line, row.violation, flush=True)
    if _make(killed, cores).wait():
        rows[-1].violation = f"the resumed study fails: {_said(killed)[-2000:]}"
    differing |= _differing(wanted, killed)
    end = {"kill": "comparison", "target": "all results", "moment_s": 0.0, "files": len(wanted)}
    violation = f"{len(differing)} differ: {', '.join(sorted(differing)[:10])}" if differing else ""
    return [*map(asdict, rows), end | {"violation": violation}]


def digests(project: Path) -> dict[str, str]:
    """Path -> checksum of every result that is compared."""
    results = project / "results"
    return {
        name: hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(results.rglob("*"))
        if path.is_file() and not (name := path.relative_to(results).as_posix()).startswith(NOT_COMPARED)
    }


def _differing(wanted: dict[str, str], project: Path) -> set[str]:
    present = digests(project)
    return {name for name in wanted.keys() | present.keys() if wanted.get(name) != present.get(name)}


def _project(target: Path) -> Path:
    project = copy_project(target)
    for name in ("Makefile", "pyproject.toml"):
        shutil.copy(ROOT / name, project / name)
    (project / ".venv").symlink_to(Path(sys.prefix))
    return project


def _make(project: Path, cores: int) -> subprocess.Popen:
    command = ["make", "-o", "environment", "study", f"CORES={cores}", "CONFIG=config/tiny.yaml"]
    # to a file, because jobs that have lost their run would hold a pipe open
    with open(project / SAID, "w", encoding="utf-8") as said:
        return subprocess.Popen(command, cwd=project, start_new_session=True, stdout=said, stderr=said)


def _said(project: Path) -> str:
    return (project / SAID).read_text(encoding="utf-8")


def _kill(process: subprocess.Popen, project: Path, row: Kill, rng: np.random.Generator) -> bool:
    """Wait for the moment and kill; False if the run has ended before, without a failure."""
    started, victims = None, []
    while process.poll() is None and not victims:
        time.sleep(0.02)
        runs, jobs = _at_work(project)
        if started is None and runs:
            started = time.monotonic()
        if started is None or time.monotonic() - started < row.moment_s:
            continue
        if row.target == "one job":  # it may take a while until one is at work
            victims = [jobs[rng.integers(len(jobs))]] if jobs else []
        else:
            victims = runs + (jobs if row.target == "snakemake and jobs" else [])
    for victim in victims:
        try:
            os.kill(victim, signal.SIGKILL)
        except ProcessLookupError:  # it has just ended
            row.target += ", which had ended"
    process.wait()
    if row.target == "snakemake" and not _jobs_end(project):
        row.violation = "jobs go on without their run"
    said = _said(project)
    if not victims and process.returncode == 0:
        return False
    # where a job was killed the run goes on with the others, and names it in the end
    if row.target == "one job" and process.returncode and SIGKILL not in said:
        row.violation = f"the job is not named: {said[-1000:]}"
    if not victims or "Traceback" in said:
        row.violation = f"the run failed by itself: {said[-2000:]}"
    return True


def _jobs_end(project: Path, longest_s: float = 20.0) -> bool:
    """Wait until no job is at work; False if one takes longer."""
    deadline = time.monotonic() + longest_s
    while any(_at_work(project)):
        if time.monotonic() > deadline:
            return False
        time.sleep(0.05)
    return True


def _at_work(project: Path) -> tuple[list[int], list[int]]:
    """Process numbers of Snakemake, without those that unlock, and of its jobs."""
    runs, forked = [], {}
    for process in psutil.process_iter(["cmdline", "cwd", "ppid"]):
        command = process.info["cmdline"] or []
        if process.info["cwd"] != str(project.resolve()):
            continue
        if any(PRELOADED in part for part in command):
            forked[process.pid] = process.info["ppid"]
        elif command[1:3] == ["-m", "snakemake"] and "--unlock" not in command:
            runs.append(process.pid)
    # the fork server is no job, nor are children of jobs, which read files under guard
    servers = {pid for pid, parent in forked.items() if parent not in forked}
    return runs, [pid for pid, parent in forked.items() if parent in servers]


def table(rows: list[dict]) -> str:
    """Kills by what was killed, and the comparison, as Markdown."""
    lines = ["| Killed | Kills | Moments (s) | Results there | Violations |", "|---|---|---|---|---|"]
    for target in dict.fromkeys(row["target"] for row in rows):
        of = [row for row in rows if row["target"] == target]
        moments, files = [row["moment_s"] for row in of], [row["files"] for row in of]
        violations = sum(bool(row["violation"]) for row in of)
        last = of[0]["kill"] == "comparison"
        cells = [
            "comparison of all results" if last else target,
            "" if last else str(len(of)),
            "" if last else f"{min(moments):.1f} to {max(moments):.1f}",
            str(files[0]) if last else f"{min(files)} to {max(files)}",
            str(violations),
        ]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def main() -> int:
    """Command line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--cores", type=int, default=2)
    given = parser.parse_args()
    rows = run(given.seed, given.kills, given.cores)
    violations = [row for row in rows if row["violation"]]
    print(f"\n{table(rows)}\n")
    for row in violations:
        print(f"{row['kill']}: {row['violation']}")
    return int(bool(violations))


if __name__ == "__main__":
    sys.exit(main())
