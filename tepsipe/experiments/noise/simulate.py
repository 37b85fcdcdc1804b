"""The noise study's trials: the dummy simulated without noise on recorded belt motions (thesis 2-1-3)."""

from typing import Annotated

import numpy as np

from tepsipe.experiments.dummy.leg_pathways import DummyOptions
from tepsipe.experiments.noise.trial import SimulatedTrial
from tepsipe.io.trial import Trial
from tepsipe.mechanics.forward_dynamics import Joint, refuse_unstable, simulate_dummy
from tepsipe.mechanics.inverse_dynamics import Foot
from tepsipe.treadmill.prepared import prepare_trial


def simulate_trial(
    trial: Trial,
    name: str,
    options: DummyOptions,
    foot: Foot,
    parameters: Annotated[np.ndarray, "(3,)"],
    step_s: float,
    engine: str,
) -> SimulatedTrial:
    """Simulate the dummy, upright at rest, on the belt motion of a recorded trial.

    trial: ``belt_velocity``.
    name: Condition.
    options: filter of the belt motion, and search for perturbations and rest.
    step_s: step of the simulation.
    engine: {"pybullet", "mujoco", "equations", "auto"}: Physics engine that moves the dummy.
    """
    prepared = prepare_trial(trial, "belt velocity", options.lowpass, options.window)
    velocity = prepared.belt_velocity
    joint = Joint(*parameters)
    refuse_unstable(options.leg, joint)
    s = simulate_dummy(
        prepared.time,
        velocity - np.median(velocity[prepared.at_rest]),
        options.leg,
        foot,
        joint,
        step_s,
        engine,
    )
    return SimulatedTrial(
        name=name,
        time=s.time,
        theta=s.theta,
        theta_d=s.theta_d,
        theta_dd=s.theta_dd,
        y_leg_dd=s.y_dd,
        z_leg_dd=s.z_dd,
        y_foot=s.foot_y,
        y_foot_d=s.foot_y_d,
        y_foot_dd=s.foot_y_dd,
        f_y=s.f_y,
        f_z=s.f_z,
        m_x=s.m_x,
        windows=np.array([[p.start, p.stop] for p in prepared.perturbations]),
        leg=options.leg,
        foot=foot,
        truth=np.asarray(parameters, dtype=float),
    )
