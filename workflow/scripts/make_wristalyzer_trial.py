"""Make one Wristalyzer trial's raw files."""

import job

job.start(snakemake)

from pathlib import Path

from tepsipe.virtual_lab.wristalyzer_trial import make_wristalyzer_trial

make_wristalyzer_trial(
    snakemake.params.truth,
    snakemake.wildcards.condition,
    snakemake.params.factor,
    snakemake.params.duration_s,
    Path(snakemake.output.log),
    Path(snakemake.output.command),
    Path(snakemake.output.motion),
)
