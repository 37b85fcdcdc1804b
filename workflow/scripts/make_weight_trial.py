"""Make one treadmill trial's raw files, the weight on the belt, or nothing, which has no markers."""

import job

job.start(snakemake)

from pathlib import Path

from tepsipe.virtual_lab.weight_trial import make_weight_trial

markers = getattr(snakemake.output, "markers", None)
make_weight_trial(
    snakemake.params.truth,
    snakemake.wildcards.condition,
    **snakemake.params.protocol,
    log=Path(snakemake.output.log),
    calibration=Path(snakemake.output.calibration),
    markers=None if markers is None else Path(markers),
)
