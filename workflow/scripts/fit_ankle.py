"""Estimate impedance, I, B, K of one trial in the position-controlled manipulator."""

import job

job.start(snakemake)

import numpy as np

from tepsipe.experiments.position_manipulator import (
    PositionManipulatorOptions,
    analyse_intrinsic_reflex,
    analyse_position_manipulator,
    intrinsic_reflex_estimates,
    position_manipulator_estimates,
    position_manipulator_result,
)
from tepsipe.identification.parallel_cascade import IntrinsicReflexOptions
from tepsipe.io.estimates import write_estimates
from tepsipe.io.result import write_result
from tepsipe.io.trial import read_trial

trial = read_trial(snakemake.input.trial)
choices = dict(snakemake.params.analysis)
reflex = IntrinsicReflexOptions(**choices.pop("intrinsic_reflex"))
options = PositionManipulatorOptions(**choices)
rng = np.random.default_rng(snakemake.params.seed)
found = analyse_position_manipulator(trial, options, rng)
told_apart = analyse_intrinsic_reflex(trial, options, reflex, rng)
names = ("ankle", snakemake.wildcards.condition)
write_result(snakemake.output.fit, position_manipulator_result(found, told_apart))
write_estimates(
    snakemake.output.estimates,
    position_manipulator_estimates(*names, found) + intrinsic_reflex_estimates(*names, told_apart),
)
