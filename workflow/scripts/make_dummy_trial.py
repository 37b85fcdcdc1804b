"""Make one treadmill trial's raw files, the ankle dummy on the belt."""

import job

job.start(snakemake)

from pathlib import Path

from tepsipe.virtual_lab.dummy_trial import make_dummy_trial

make_dummy_trial(
    snakemake.params.truth,
    snakemake.wildcards.condition,
    **snakemake.params.protocol,
    log=Path(snakemake.output.log),
    calibration=Path(snakemake.output.calibration),
    markers=Path(snakemake.output.markers),
    motion_file=Path(snakemake.output.motion),
)
