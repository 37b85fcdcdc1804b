"""Make one treadmill trial's raw files, nothing on the belt."""

import job

job.start(snakemake)

from pathlib import Path

import yaml

from tepsipe.virtual_lab.weight_trial import make_empty_trial

make_empty_trial(
    yaml.safe_load(Path(snakemake.input.truth).read_text(encoding="utf-8")),
    snakemake.wildcards.condition,
    snakemake.params.profile,
    snakemake.params.amplitude_m_per_s,
    snakemake.params.interval_s,
    snakemake.params.duration_s,
    Path(snakemake.output.log),
    Path(snakemake.output.calibration),
)
