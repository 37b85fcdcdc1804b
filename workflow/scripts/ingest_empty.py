"""Ingest one trial with the treadmill's belt empty."""

import job

job.start(snakemake)

from tepsipe.ingest_treadmill import TreadmillOptions, ingest_treadmill
from tepsipe.readers.treadmill_log import read_calibration_matrix, read_treadmill_log
from tepsipe.trial_file import write_trial

files = dict(snakemake.params.files)
options = TreadmillOptions(**snakemake.params.ingest)
trial = ingest_treadmill(
    read_treadmill_log(files["log"]),
    read_calibration_matrix(files["calibration"]),
    None,
    options,
    snakemake.params.duration_s,
    files["log"],
    files["calibration"],
    None,
)
write_trial(snakemake.output.trial, trial, "empty", snakemake.wildcards.condition, files, vars(options))
