"""Simulate one trial of the ankle dummy with parameters of this run and of the thesis, and compare."""

import job

job.start(snakemake)

from tepsipe.experiments.dummy.leg_pathways import DummyOptions
from tepsipe.experiments.forward.scores import EQUATIONS, FORWARD_SCORES, engine_of
from tepsipe.experiments.forward.study import (
    SimulatedCondition,
    engine_differences,
    forward_scores,
    likelihood_joint,
    mean_joint,
    simulate_condition,
    simulation_result,
)
from tepsipe.experiments.wristalyzer.names import AS_PRINTED, PATHWAY
from tepsipe.io.estimates import ESTIMATES
from tepsipe.io.result import read_result, write_result
from tepsipe.io.trial import read_trial
from tepsipe.mechanics.engines.interface import Joint
from tepsipe.mechanics.impedance_model import PARAMETERS
from tepsipe.mechanics.inverse_dynamics import Foot

params, condition = snakemake.params, snakemake.wildcards.condition
geometry = params.geometry
in_manipulator = ESTIMATES.read(*snakemake.input.wristalyzer)
on_belt = ESTIMATES.read(snakemake.input.estimates)
joints = {
    "wristalyzer": mean_joint(in_manipulator, PATHWAY, AS_PRINTED),
    "tep": mean_joint(on_belt, params.as_printed),
    "corrected": mean_joint(on_belt, params.recommended),
}
joints |= {name: Joint(*(printed[key] for key in PARAMETERS)) for name, printed in params.printed.items()}
likelihood = likelihood_joint(on_belt, read_result(snakemake.input.fit), params.quoted)
if likelihood is not None:
    joints["joint-likelihood"] = likelihood
trial = read_trial(snakemake.input.trial)
options = DummyOptions.from_settings(geometry, params.analysis, params.belt_fixed_labels)


def simulate(engines: dict[str, str]) -> SimulatedCondition:
    """Simulate the trial with every set of parameters by its engine."""
    foot = Foot.from_settings(geometry)
    return simulate_condition(trial, options, foot, joints, params.step_s, engines, params.belt)


engines = {name: engine_of(name, params.engine) for name in joints}
simulated, differences = simulate(engines), None
if params.compared and params.engine != EQUATIONS:
    # each set once more, by the engine that did not move it
    exchanged = {name: params.engine if own == EQUATIONS else EQUATIONS for name, own in engines.items()}
    differences = engine_differences(simulated, simulate(exchanged))
write_result(snakemake.output.fit, simulation_result(simulated, differences))
FORWARD_SCORES.write(snakemake.output.forward, forward_scores(condition, simulated))
