"""Make one treadmill trial's raw files, the weight on the belt."""

import job

job.start(snakemake)

from pathlib import Path

import yaml

from tepsipe.virtual_lab.weight_trial import make_weight_trial

make_weight_trial(
    yaml.safe_load(Path(snakemake.input.truth).read_text(encoding="utf-8")),
    snakemake.wildcards.condition,
    snakemake.params.profile,
    snakemake.params.amplitude_m_per_s,
    snakemake.params.interval_s,
    snakemake.params.duration_s,
    Path(snakemake.output.log),
    Path(snakemake.output.calibration),
    Path(snakemake.output.markers),
)
