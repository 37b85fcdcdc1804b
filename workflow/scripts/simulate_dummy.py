"""Simulate one trial of the ankle dummy with the parameters of both experiments, and compare."""

import job

job.start(snakemake)

from tepsipe.experiments.dummy.leg_pathways import DummyOptions
from tepsipe.experiments.forward.scores import FORWARD_SCORES
from tepsipe.experiments.forward.study import (
    forward_scores,
    mean_parameters,
    simulate_condition,
    simulation_result,
)
from tepsipe.experiments.wristalyzer.names import AS_PRINTED, PATHWAY
from tepsipe.io.estimates import ESTIMATES
from tepsipe.io.result import write_result
from tepsipe.io.trial import read_trial
from tepsipe.mechanics.inverse_dynamics import Foot

geometry, condition = snakemake.params.geometry, snakemake.wildcards.condition
in_manipulator = ESTIMATES.read(*snakemake.input.wristalyzer)
on_belt = ESTIMATES.read(snakemake.input.estimates)
joints = {
    "wristalyzer": mean_parameters(in_manipulator, PATHWAY, AS_PRINTED),
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
FORWARD_SCORES.write(snakemake.output.forward, forward_scores(condition, simulated))
