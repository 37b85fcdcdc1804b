"""Run Snakemake so that nothing stands in its way: ``python -m workflow.run`` and Snakemake's arguments.

``make`` and ``tepsipe run`` start it.

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
from tepsipe.new_study.start import OWN
from workflow.support import runs
from workflow.support.checked_study import shipped
from workflow.support.yaml_file import read_settings


def main(arguments: list[str]) -> int:
    """Check, remove a lock that is left over, then become Snakemake; 2 if it must not start."""
    parser = argparse.ArgumentParser(add_help=False, allow_abbrev=False)
    parser.add_argument("--configfile", "--configfiles", nargs="+", action="extend", default=[])
    chosen, others = parser.parse_known_args(arguments)
    configured = ["--configfile", *chosen.configfile] if chosen.configfile else []
    try:
        # without further files, Snakemake takes that which the profile of a study names
        own = [path for path in (OWN,) if not chosen.configfile and Path(path).is_file()]
        for path in [shipped(), *chosen.configfile, *own]:
            read_settings(path)
        runs.begin()
    except InputError as error:
        print(f"tepsipe: {error}", file=sys.stderr)
        return 2
    safe = ["-P"] if sys.flags.safe_path else []
    snakemake = [sys.executable, *safe, "-m", "snakemake"]
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


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
