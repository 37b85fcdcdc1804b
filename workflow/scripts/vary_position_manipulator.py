"""Impedance that changes within one trial in the position-controlled manipulator."""

import job

job.start(snakemake)

import numpy as np

from tepsipe.experiments.position_manipulator.options import TimeVaryingOptions
from tepsipe.experiments.position_manipulator.time_varying import (
    VARYING_ROWS,
    analyse_time_varying,
    varying_rows,
)
from tepsipe.io.result import read_result
from tepsipe.io.trial import read_trial

found = analyse_time_varying(
    read_trial(snakemake.input.trial),
    read_result(snakemake.input.fit),
    TimeVaryingOptions(**snakemake.params.options),
    np.random.default_rng(snakemake.params.seed),
)
VARYING_ROWS.write(
    snakemake.output.rows, varying_rows("position_manipulator", snakemake.wildcards.condition, found)
)
