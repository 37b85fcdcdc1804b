"""Make one trial's raw files, a person standing on the belt."""

import job

job.start(snakemake)

from pathlib import Path

import yaml

from tepsipe.virtual_lab.standing_trial import make_standing_trial

make_standing_trial(
    yaml.safe_load(Path(snakemake.input.truth).read_text(encoding="utf-8")),
    snakemake.wildcards.condition,
    snakemake.params.task,
    snakemake.params.profile,
    snakemake.params.amplitude_m_per_s,
    (snakemake.params.interval_s, snakemake.params.longest_interval_s),
    snakemake.params.duration_s,
    Path(snakemake.output.log),
    Path(snakemake.output.calibration),
    Path(snakemake.output.markers),
    Path(snakemake.output.emg),
)
