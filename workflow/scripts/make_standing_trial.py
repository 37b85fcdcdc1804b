"""Make one trial's raw files, a person standing on the belt."""

import job

job.start(snakemake)

from pathlib import Path

from tepsipe.virtual_lab.standing_trial import make_standing_trial
from tepsipe.virtual_lab.treadmill_trial import Protocol

make_standing_trial(
    snakemake.params.truth,
    snakemake.wildcards.condition,
    snakemake.params.task,
    Protocol(**snakemake.params.protocol),
    {
        "log": Path(snakemake.output.log),
        "calibration": Path(snakemake.output.calibration),
        "markers": Path(snakemake.output.markers),
        "emg": Path(snakemake.output.emg),
        "motion": Path(snakemake.output.motion),
    },
    snakemake.params.belt,
)
