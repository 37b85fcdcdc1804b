"""Estimate impedance, I, B, K of one trial in the position-controlled manipulator."""

import job

job.start(snakemake)

import numpy as np

from tepsipe.experiments.position_manipulator.analysis import (
    PositionManipulatorOptions,
    analyse_parallel_cascade,
    analyse_position_manipulator,
    parallel_cascade_estimates,
    position_manipulator_estimates,
    position_manipulator_result,
)
from tepsipe.experiments.position_manipulator.diagnostics import diagnose
from tepsipe.identification.cascade.fit import ParallelCascadeOptions
from tepsipe.io.estimates import ESTIMATES
from tepsipe.io.result import joined, write_result
from tepsipe.io.trial import read_trial

trial = read_trial(snakemake.input.trial)
choices = dict(snakemake.params.analysis)
reflex = ParallelCascadeOptions(**choices.pop("parallel_cascade"))
options = PositionManipulatorOptions(**choices)
rng = np.random.default_rng(snakemake.params.seed)
found = analyse_position_manipulator(trial, options, rng)
told_apart = analyse_parallel_cascade(trial, options, reflex, rng)
names = ("position_manipulator", snakemake.wildcards.condition)
write_result(
    snakemake.output.fit,
    joined(position_manipulator_result(found, told_apart), diagnose(trial, options, found, told_apart)),
)
ESTIMATES.write(
    snakemake.output.estimates,
    position_manipulator_estimates(*names, found) + parallel_cascade_estimates(*names, told_apart),
)
