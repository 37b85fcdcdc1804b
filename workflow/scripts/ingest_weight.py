"""Ingest one trial with the weight on the treadmill."""

import job

job.start(snakemake)

from tepsipe.ingest.plate_treadmill import TreadmillOptions, ingest_treadmill_files
from tepsipe.io.trial import write_trial

files = dict(snakemake.params.files)
options = TreadmillOptions(**snakemake.params.ingest)
trial = ingest_treadmill_files(files, snakemake.params.marker_labels, options, snakemake.params.duration_s)
write_trial(snakemake.output.trial, trial, "weight", snakemake.wildcards.condition, files, vars(options))
