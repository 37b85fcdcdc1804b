"""Ingest one trial of the treadmill with the ankle dummy, the weight or nothing on its belt."""

import job

job.start(snakemake)

from tepsipe.ingest.limits import Limits, Rig
from tepsipe.ingest.plate_treadmill import TreadmillOptions, ingest_treadmill_files
from tepsipe.ingest.plausibility import plausible_trial
from tepsipe.io.trial import write_trial

files, names = dict(snakemake.params.files), snakemake.wildcards
options = TreadmillOptions(**snakemake.params.ingest)
trial = ingest_treadmill_files(files, snakemake.params.marker_labels, options, snakemake.params.duration_s)
trial = plausible_trial(trial, Limits(**snakemake.params.plausible), Rig(**snakemake.params.rig), files)
write_trial(snakemake.output.trial, trial, names.experiment, names.condition, files, vars(options))
