"""Ingest one trial by the ingest of its experiment."""

import job

job.start(snakemake)

from importlib import import_module

from tepsipe.ingest.limits import Limits, Rig
from tepsipe.io.trial import write_trial

params, files = snakemake.params, dict(snakemake.params.files)
limits, rig = Limits(**params.plausible), Rig(**params.rig)
ingest = import_module(params.module).ingest
trial, used = ingest(files, params.section, params.duration_s, params.named_by, limits, rig)
condition = snakemake.wildcards.condition
write_trial(snakemake.output.trial, trial, params.experiment, condition, files, used | params.named)
