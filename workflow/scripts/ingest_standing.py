"""Ingest one trial of a person standing on the treadmill."""

import job

job.start(snakemake)

from tepsipe.arguments import options_of
from tepsipe.ingest.limits import Limits, Rig
from tepsipe.ingest.plate_treadmill import TreadmillOptions
from tepsipe.ingest.plausibility import plausible_trial
from tepsipe.ingest.standing import ingest_standing_files
from tepsipe.ingest.whole_trial import RecordingOptions
from tepsipe.io.trial import write_trial

files = dict(snakemake.params.files)
options = TreadmillOptions(**snakemake.params.ingest)
recording = snakemake.params.recording
trial = ingest_standing_files(
    files,
    snakemake.params.marker_labels,
    snakemake.params.emg_channels,
    snakemake.params.emg_trigger,
    snakemake.params.emg_trigger_threshold,
    options,
    snakemake.params.duration_s,
    options_of(RecordingOptions, recording or {}),
)
trial = plausible_trial(trial, Limits(**snakemake.params.plausible), Rig(**snakemake.params.rig), files)
used = vars(options) | dict(snakemake.params.named) | ({} if recording is None else {"recording": recording})
write_trial(snakemake.output.trial, trial, "standing", snakemake.wildcards.condition, files, used)
