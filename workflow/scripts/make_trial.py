"""Make one trial's raw files by a rig of the virtual laboratory."""

import job

job.start(snakemake)

from importlib import import_module
from pathlib import Path

from tepsipe.io.result import seal

params, told = snakemake.params, dict(snakemake.params.told)
module = import_module(f"tepsipe.virtual_lab.{params.made_by}")
if "protocol" in told:
    told["protocol"] = module.Protocol(**told["protocol"])
files = {kind: Path(path) for kind, path in snakemake.output.items()}
make = getattr(module, f"make_{params.made_by}")
make(truth=params.truth, condition=snakemake.wildcards.condition, files=files, **told)
if "motion" in files:  # unlike the raw files, no file of an instrument
    seal(files["motion"])
