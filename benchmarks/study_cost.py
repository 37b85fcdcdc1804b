"""Cost of a study: seconds of its jobs by rule, its critical path, and CPU time with all processes.

    .venv/bin/python benchmarks/study_cost.py
    .venv/bin/python benchmarks/study_cost.py --cores 1 --configfile config/passive-cameras/config.yaml

Runs the study in a temporary folder, so that nothing is there yet and the results of the project stay as they
are, and prints its table. The seconds of a job end with the last file that it writes; the path is the longest
chain of jobs that need each other's files.
"""

import argparse
import base64
import ctypes
import json
import os
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from collections import Counter, defaultdict
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
SUBREAPER = 36  # prctl's PR_SET_CHILD_SUBREAPER


@dataclass
class Job:
    """A job of a run."""

    rule: str
    inputs: set[str]
    outputs: set[str] = field(default_factory=set)
    began: float = float("inf")
    ended: float = 0.0
    """Begin and end (s)."""

    @property
    def seconds(self) -> float:
        """Time that it took (s)."""
        return self.ended - self.began


def jobs_of(records: Path) -> list[Job]:
    """Jobs of a run, from Snakemake's records, one for each output, whose name is the record's path."""
    jobs: dict[tuple, Job] = {}
    for path in (path for path in records.rglob("*") if path.is_file()):
        record = json.loads(path.read_text(encoding="utf-8"))
        if record.get("starttime") is None:
            continue
        key = record["rule"], *record["log"]
        job = jobs.setdefault(key, Job(record["rule"], set(record["input"])))
        # Snakemake cuts long names into folders that begin with @
        name = "".join(part.removeprefix("@") for part in path.relative_to(records).parts)
        job.outputs.add(base64.b64decode(name).decode())
        job.began, job.ended = min(job.began, record["starttime"]), max(job.ended, record["endtime"])
    return list(jobs.values())


def critical_path(jobs: list[Job]) -> list[Job]:
    """Longest chain of jobs that need each other's outputs, in the order in which they ran."""
    makers = {output: job for job in jobs for output in job.outputs}
    longest: dict[int, tuple[float, list[Job]]] = {}
    for job in sorted(jobs, key=lambda job: job.ended):
        needed = [longest[id(makers[name])] for name in job.inputs if name in makers]
        before, chain = max(needed, key=lambda found: found[0], default=(0.0, []))
        longest[id(job)] = before + job.seconds, [*chain, job]
    return max(longest.values(), key=lambda found: found[0])[1]


def run(arguments: list[str], folder: str) -> tuple[float, float]:
    """Run a study with its files in a folder; its time and the CPU time of all its processes (s).

    The server from which jobs are forked outlives Snakemake. This process adopts it, so that its time, and
    that of its jobs, are counted when it has ended.
    """
    ctypes.CDLL(None).prctl(SUBREAPER, 1, 0, 0, 0)
    shutil.copytree(ROOT / "config", Path(folder) / "config")
    began = time.monotonic()
    snakefile = ["--snakefile", str(ROOT / "Snakefile"), "--directory", folder, "--workflow-profile"]
    command = [sys.executable, "-m", "snakemake", *snakefile, str(ROOT / "profiles/default")]
    subprocess.run([*command, *arguments], cwd=ROOT, check=True, stdout=subprocess.DEVNULL)
    seconds = time.monotonic() - began
    with suppress(ChildProcessError):
        while True:
            os.wait()
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return seconds, used.ru_utime + used.ru_stime


def main() -> None:
    """Run the study and print its costs."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cores", type=int, default=2, help="number of cores (default: %(default)s)")
    chosen, others = parser.parse_known_args()
    with tempfile.TemporaryDirectory() as folder:
        seconds, cpu = run([f"-c{chosen.cores}", *others], folder)
        jobs = jobs_of(Path(folder) / ".snakemake/metadata")
    total, path = sum(job.seconds for job in jobs), critical_path(jobs)
    print(
        f"{len(jobs)} jobs, {chosen.cores} cores: {seconds:.0f} s, {total:.0f} job-seconds, "
        f"{cpu:.0f} CPU-s with all processes.\n\nCritical path, {sum(job.seconds for job in path):.0f} s: "
        + ", ".join(f"{job.rule} {job.seconds:.1f}" for job in path)
        + ".\n\n| Rule | Jobs | Seconds | Share (%) |\n|---|---|---|---|"
    )
    spent, count = defaultdict(float), Counter(job.rule for job in jobs)
    for job in jobs:
        spent[job.rule] += job.seconds
    for rule in sorted(spent, key=spent.get, reverse=True):
        if spent[rule] >= 0.01 * total:
            print(f"| {rule} | {count[rule]} | {spent[rule]:.1f} | {100.0 * spent[rule] / total:.0f} |")


if __name__ == "__main__":
    main()
