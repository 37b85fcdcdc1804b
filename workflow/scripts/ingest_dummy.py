"""Ingest one trial of the ankle dummy on the treadmill."""

import job

job.start(snakemake)

from tepsipe.ingest.plate_treadmill import TreadmillOptions, ingest_treadmill_files
from tepsipe.io.trial import write_trial

files = dict(snakemake.params.files)
options = TreadmillOptions(**snakemake.params.ingest)
trial = ingest_treadmill_files(files, snakemake.params.marker_labels, options, snakemake.params.duration_s)
write_trial(snakemake.output.trial, trial, "dummy", snakemake.wildcards.condition, files, vars(options))
