"""Ingest one trial of the treadmill with the ankle dummy, the weight or nothing on its belt."""

import job

job.start(snakemake)

from tepsipe.ingest.limits import Limits, Rig
from tepsipe.ingest.plate_treadmill import TreadmillOptions
from tepsipe.ingest.plausibility import plausible_trial
from tepsipe.ingest.recording_options import RecordingOptions
from tepsipe.ingest.whole_trial import ingest_files
from tepsipe.io.trial import write_trial

files, names = dict(snakemake.params.files), snakemake.wildcards
options = TreadmillOptions(**snakemake.params.ingest)
recording = snakemake.params.recording
trial = ingest_files(
    files,
    snakemake.params.marker_labels,
    options,
    RecordingOptions.from_settings(recording),
    snakemake.params.duration_s,
)
trial = plausible_trial(trial, Limits(**snakemake.params.plausible), Rig(**snakemake.params.rig), files)
used = vars(options) | dict(snakemake.params.named) | ({} if recording is None else {"recording": recording})
write_trial(snakemake.output.trial, trial, names.experiment, names.condition, files, used)
