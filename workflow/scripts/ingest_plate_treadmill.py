"""Ingest one trial of the treadmill with the ankle dummy, the weight or nothing on its belt."""

import job

job.start(snakemake)

from tepsipe.arguments import options_of
from tepsipe.ingest.limits import Limits, Rig
from tepsipe.ingest.plate_treadmill import TreadmillOptions, ingest_treadmill_files
from tepsipe.ingest.plausibility import plausible_trial
from tepsipe.ingest.whole_trial import RecordingOptions, ingest_recording_files
from tepsipe.io.trial import write_trial

params, names, files = snakemake.params, snakemake.wildcards, dict(snakemake.params.files)
options, recording = TreadmillOptions(**params.ingest), params.recording
if "calibration" in files:
    trial = ingest_treadmill_files(files, params.marker_labels, options, params.duration_s)
else:
    use = options_of(RecordingOptions, recording)
    trial = ingest_recording_files(files, params.marker_labels, options, use, params.duration_s)
trial = plausible_trial(trial, Limits(**params.plausible), Rig(**params.rig), files)
used = vars(options) | dict(params.named) | ({} if recording is None else {"recording": recording})
write_trial(snakemake.output.trial, trial, names.experiment, names.condition, files, used)
