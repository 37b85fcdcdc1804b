"""Estimate impedance, I, B, K of one trial in the position-controlled manipulator."""

import job

job.start(snakemake)

import numpy as np

from tepsipe.estimates import write_estimates
from tepsipe.position_manipulator import (
    PositionManipulatorOptions,
    analyse_position_manipulator,
    position_manipulator_estimates,
    position_manipulator_result,
)
from tepsipe.result_file import write_result
from tepsipe.trial_file import read_trial

found = analyse_position_manipulator(
    read_trial(snakemake.input.trial),
    PositionManipulatorOptions(**snakemake.params.analysis),
    np.random.default_rng(snakemake.params.seed),
)
write_result(snakemake.output.fit, position_manipulator_result(found))
write_estimates(
    snakemake.output.estimates,
    position_manipulator_estimates("ankle", snakemake.wildcards.condition, found),
)
