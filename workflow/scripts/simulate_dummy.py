"""Simulate one trial of the ankle dummy with the parameters of both experiments, and compare."""

import job

job.start(snakemake)

from tepsipe.experiments.dummy.leg_pathways import DummyOptions
from tepsipe.experiments.forward.scores import write_forward
from tepsipe.experiments.forward.study import (
    forward_scores,
    mean_parameters,
    simulate_condition,
    simulation_result,
)
from tepsipe.io.estimates import read_estimates
from tepsipe.io.result import write_result
from tepsipe.io.trial import read_trial
from tepsipe.mechanics.inverse_dynamics import Foot

geometry, condition = snakemake.params.geometry, snakemake.wildcards.condition
in_manipulator = [row for path in snakemake.input.wristalyzer for row in read_estimates(path)]
on_belt = read_estimates(snakemake.input.estimates)
joints = {
    "wristalyzer": mean_parameters(in_manipulator, "admittance", "spectral-fit"),
    "tep": mean_parameters(on_belt, snakemake.params.as_printed),
    "corrected": mean_parameters(on_belt, snakemake.params.recommended),
}
simulated = simulate_condition(
    read_trial(snakemake.input.trial),
    DummyOptions.from_settings(geometry, snakemake.params.analysis),
    Foot.from_settings(geometry),
    joints,
    snakemake.params.step_s,
    snakemake.params.engine,
)
write_result(snakemake.output.fit, simulation_result(simulated))
write_forward(snakemake.output.forward, forward_scores(condition, simulated))
