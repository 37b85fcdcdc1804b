"""Run Snakemake so that nothing stands in its way: ``python -m workflow.run`` and Snakemake's arguments.

Configuration files are read strictly before Snakemake loads them and would run code from them. After a run
that was killed, its jobs are waited for, its lock is removed, and the run goes on. If another run is at work,
this one stops.
"""

import argparse
import os
import subprocess
import sys
from pathlib import Path

from tepsipe.errors import InputError
from workflow.support import runs
from workflow.support.start import DEFAULTS
from workflow.support.yaml_file import read_settings

LONGEST_WAIT_S = 1800.0


def main(arguments: list[str]) -> int:
    """Check, remove a lock that is left over, then become Snakemake; 2 if it must not start."""
    parser = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
    parser.add_argument("--configfile", "--configfiles", nargs="+", action="extend", default=[])
    chosen, others = parser.parse_known_args(arguments)
    configured = ["--configfile", *chosen.configfile] if chosen.configfile else []
    try:
        for path in [DEFAULTS, *chosen.configfile]:
            read_settings(path)
        _refuse_another_run()
        _wait_for_jobs()
    except InputError as error:
        print(f"tepsipe: {error}", file=sys.stderr)
        return 2
    snakemake = [sys.executable, "-m", "snakemake"]
    if runs.is_locked():
        print(
            "tepsipe: the last run was killed: this one removes its lock and goes on from there",
            file=sys.stderr,
        )
        done = subprocess.run([*snakemake, "--unlock", *configured])
        if done.returncode:
            return done.returncode
        runs.forget_run()
    os.execv(sys.executable, [*snakemake, *others, "--rerun-incomplete", *configured])


def _refuse_another_run() -> None:
    alive, other = runs.runs_alive(), runs.elsewhere()
    if alive:
        raise InputError(
            f"{Path.cwd()}: expected no other run in this folder, found process {alive[0]} at work: wait for "
            f"it, or stop it with kill {alive[0]}"
        )
    if other:
        raise InputError(
            f"{Path.cwd()}: expected no other run in this folder, found one on {other}: wait for it; if it "
            f"has been killed, remove {runs.NOTE}"
        )


def _wait_for_jobs() -> None:
    alive = runs.jobs_alive()
    if not alive:
        return
    print(
        f"tepsipe: {len(alive)} jobs of a run that was killed are at work: waiting for them", file=sys.stderr
    )
    if not runs.wait_for_jobs(LONGEST_WAIT_S):
        raise InputError(
            f"{Path.cwd()}: expected jobs of the run that was killed to end, found process {alive[0]} at "
            f"work after {LONGEST_WAIT_S / 60:.0f} minutes: stop it with kill {alive[0]}, then run again"
        )


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
