"""Snakemake's own interactive report of the outputs that exist by now."""

import job

job.start(snakemake)

import subprocess
import sys

command = [sys.executable, "-m", "snakemake", *snakemake.input.outputs]
command += ["--report", snakemake.output.html, "--configfile", snakemake.input.config, "--nolock"]
done = subprocess.run(command, capture_output=True, text=True)
if done.returncode:
    raise RuntimeError(f"{' '.join(command)}\n{done.stdout}\n{done.stderr}")
