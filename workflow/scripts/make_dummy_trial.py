"""Make one treadmill trial's raw files, the ankle dummy on the belt."""

import job

job.start(snakemake)

from pathlib import Path

import yaml

from tepsipe.virtual_lab.dummy_trial import make_dummy_trial

make_dummy_trial(
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
