"""Impedance of ankle and hip of one person on a moving platform."""

import job

job.start(snakemake)

from tepsipe.experiments.platform.analysis import (
    PlatformOptions,
    analyse_platform,
    platform_estimates,
    platform_result,
)
from tepsipe.io.estimates import ESTIMATES
from tepsipe.io.result import write_result
from tepsipe.io.trial import read_trial

trial = read_trial(snakemake.input.trial)
options = PlatformOptions(**snakemake.params.analysis)
found = analyse_platform(trial, options)
write_result(snakemake.output.fit, platform_result(found, options, trial.signals["platform"].unit))
ESTIMATES.write(
    snakemake.output.estimates,
    platform_estimates("platform", snakemake.wildcards.condition, found, options),
)
