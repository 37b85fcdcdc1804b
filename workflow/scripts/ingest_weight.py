"""Ingest one trial with the weight on the treadmill."""

import job

job.start(snakemake)

from tepsipe.ingest_treadmill import TreadmillOptions, ingest_treadmill
from tepsipe.readers.markers import read_markers
from tepsipe.readers.treadmill_log import read_calibration_matrix, read_treadmill_log
from tepsipe.trial_file import write_trial

files = dict(snakemake.params.files)
options = TreadmillOptions(**snakemake.params.ingest)
trial = ingest_treadmill(
    read_treadmill_log(files["log"]),
    read_calibration_matrix(files["calibration"]),
    read_markers(files["markers"], snakemake.params.marker_labels),
    options,
    snakemake.params.duration_s,
    files["log"],
    files["calibration"],
    files["markers"],
)
write_trial(snakemake.output.trial, trial, "weight", snakemake.wildcards.condition, files, vars(options))
