"""The noise study's trials: the dummy simulated without noise on recorded belt motions (thesis 2-1-3)."""

import numpy as np

from tepsipe.experiments.dummy.leg_pathways import DummyOptions
from tepsipe.experiments.noise.trial import SimulatedTrial
from tepsipe.io.trial import Trial
from tepsipe.mechanics.forward_dynamics import ForwardSimulation, Joint, refuse_unstable, simulate_dummies
from tepsipe.mechanics.inverse_dynamics import Foot, Leg
from tepsipe.treadmill.prepared import prepare_trial


def simulate_trials(
    trial: Trial,
    name: str,
    options: DummyOptions,
    foot: Foot,
    joints: dict[str, tuple[float, float, float]],
    step_s: float,
    engine: str,
) -> dict[str, SimulatedTrial]:
    """Simulate the dummy with several joints, upright at rest, on the belt motion of a recorded trial.

    trial: ``belt_velocity``.
    name: Condition.
    options: filter of the belt motion, and search for perturbations and rest.
    joints: I, B, K of each (units in `Joint`).
    step_s: step of the simulation.
    engine: {"pybullet", "mujoco", "equations", "auto"}: Physics engine that moves the dummy.
    """
    prepared = prepare_trial(trial, "belt velocity", options.lowpass, options.window)
    velocity = prepared.belt_velocity
    moved = {key: Joint(*parameters) for key, parameters in joints.items()}
    for joint in moved.values():
        refuse_unstable(options.leg, joint)
    at_rest = np.median(velocity[prepared.at_rest])
    simulations = simulate_dummies(
        prepared.time, velocity - at_rest, options.leg, foot, moved, step_s, engine
    )
    windows = np.array([[p.start, p.stop] for p in prepared.perturbations])
    return {
        key: _simulated(name, s, windows, options.leg, foot, joints[key]) for key, s in simulations.items()
    }


def _simulated(
    name: str,
    s: ForwardSimulation,
    windows: np.ndarray,
    leg: Leg,
    foot: Foot,
    parameters: tuple[float, float, float],
) -> SimulatedTrial:
    """A simulation as a trial with windows (samples) and its true I, B, K."""
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
        windows=windows,
        leg=leg,
        foot=foot,
        truth=np.asarray(parameters, dtype=float),
    )
