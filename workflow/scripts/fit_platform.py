"""Impedance of ankle and hip of one person on a moving platform."""

import job

job.start(snakemake)

from tepsipe.experiments.platform import (
    PlatformOptions,
    analyse_platform,
    platform_estimates,
    platform_result,
)
from tepsipe.identification.several_joints.closed_loop import MultiJointOptions
from tepsipe.io.estimates import ESTIMATES
from tepsipe.io.result import write_result
from tepsipe.io.trial import read_trial

trial = read_trial(snakemake.input.trial)
choices = dict(snakemake.params.analysis)
estimate = MultiJointOptions(
    band_hz=tuple(choices.pop("band_hz")),
    averaged_bins=choices.pop("averaged_bins"),
    taper_fraction=choices.pop("taper_fraction"),
    delays_s=tuple(choices.pop("delays_s")),
    delay_step_s=choices.pop("delay_step_s"),
    strength=choices.pop("strength"),
)
options = PlatformOptions(estimate=estimate, models=tuple(choices.pop("models")), **choices)
found = analyse_platform(trial, options)
write_result(snakemake.output.fit, platform_result(found, options, trial.signals["platform"].unit))
ESTIMATES.write(
    snakemake.output.estimates,
    platform_estimates("platform", snakemake.wildcards.condition, found, options),
)
