"""Make one treadmill trial's raw files, the ankle dummy on the belt."""

import job

job.start(snakemake)

from pathlib import Path

from tepsipe.virtual_lab.dummy_trial import make_dummy_trial
from tepsipe.virtual_lab.treadmill_trial import Protocol

make_dummy_trial(
    snakemake.params.truth,
    snakemake.wildcards.condition,
    Protocol(**snakemake.params.protocol),
    {
        "log": Path(snakemake.output.log),
        "calibration": Path(snakemake.output.calibration),
        "markers": Path(snakemake.output.markers),
        "motion": Path(snakemake.output.motion),
    },
)
