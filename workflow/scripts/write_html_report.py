"""Snakemake's own interactive report of the outputs that exist by now."""

import job

job.start(snakemake)

import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

with tempfile.TemporaryDirectory() as folder:
    # a copy, because a configuration among the results is refused
    settings = shutil.copy(snakemake.input.config, Path(folder) / "config.yaml")
    command = [sys.executable, "-m", "snakemake", *snakemake.input.outputs]
    command += ["--report", snakemake.output.html, "--configfile", settings, "--nolock"]
    done = subprocess.run(command, capture_output=True, text=True)
if done.returncode:
    raise RuntimeError(f"{' '.join(map(str, command))}\n{done.stdout}\n{done.stderr}")
