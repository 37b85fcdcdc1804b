"""Simulate the dummy on one trial's belt motion, with the joints of the noise study."""

import job

job.start(snakemake)

from tepsipe.experiments.dummy.leg_pathways import DummyOptions
from tepsipe.experiments.noise.simulate import simulate_trials
from tepsipe.experiments.noise.trial import simulated_result
from tepsipe.io.result import write_result
from tepsipe.io.trial import read_trial
from tepsipe.mechanics.inverse_dynamics import Foot

geometry, joint = snakemake.params.geometry, snakemake.params.joint
trial = read_trial(snakemake.input.trial)
options = DummyOptions.from_settings(geometry, snakemake.params.analysis)
foot = Foot.from_settings(geometry)
joints = {
    f"K_{stiffness:g}": (joint["inertia_Nms2_per_rad"], joint["damping_Nms_per_rad"], stiffness)
    for stiffness in joint["stiffness_Nm_per_rad"]
}
simulated = simulate_trials(
    trial,
    snakemake.wildcards.condition,
    options,
    foot,
    joints,
    snakemake.params.step_s,
    snakemake.params.engine,
)
write_result(snakemake.output.fit, simulated_result(simulated))
