"""Validation of parameters by forward simulation (thesis section 4-1-3).

Every trial of the ankle dummy is simulated with several sets of parameters, driven by its recorded belt
motion, and compared with the recorded angle and with the torque by inverse dynamics.
"""

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from tepsipe.errors import InputError
from tepsipe.experiments.dummy.leg_pathways import DummyOptions, leg_motion
from tepsipe.experiments.forward.scores import ForwardScore
from tepsipe.io.estimates import Estimate
from tepsipe.io.result import Result
from tepsipe.io.trial import Trial
from tepsipe.mechanics.forward_dynamics import (
    ForwardSimulation,
    Joint,
    Start,
    rest_angle_of_standing,
    simulate_dummy,
)
from tepsipe.mechanics.impedance_model import PARAMETERS
from tepsipe.mechanics.inverse_dynamics import TORQUE_PATHWAYS, Foot
from tepsipe.signals.perturbations import Perturbation
from tepsipe.statistics.goodness_of_fit import vaf
from tepsipe.treadmill.prepared import prepare_trial

MEASURED_TORQUES = {"tau": "leg-thesis", "tau_consistent": "leg"}


@dataclass(frozen=True)
class SimulatedCondition:
    """One trial, recorded and simulated.

    Attributes
    ----------
    time : ndarray, shape (n,)
        Instants (s).
    theta : ndarray, shape (n,)
        Recorded leg angle (rad).
    torques : dict of str to ndarray, shape (n,)
        Torque by inverse dynamics, relative to rest (N·m): ``tau`` by the equation as printed,
        ``tau_consistent`` by the consistent equation.
    perturbations : list of Perturbation
        Windows (samples).
    joints : dict of str to ndarray, shape (3,)
        Parameter set -> I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad).
    simulations : dict of str to ForwardSimulation
        Parameter set -> simulation, on the recorded instants.
    """

    time: np.ndarray
    theta: np.ndarray
    torques: dict[str, np.ndarray]
    perturbations: list[Perturbation]
    joints: dict[str, np.ndarray]
    simulations: dict[str, ForwardSimulation]


def mean_parameters(estimates: Iterable[Estimate], pathway: str, estimator: str | None = None) -> np.ndarray:
    """Mean I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad) over some rows of estimates, shape (3,).

    Raises
    ------
    InputError
        If the rows hold no estimate of the pathway.
    """
    rows = [e for e in estimates if e.pathway == pathway and estimator in (None, e.estimator)]
    values = [[e.value for e in rows if e.quantity == quantity] for quantity in PARAMETERS]
    if not all(values):
        raise InputError(f"expected estimates by the pathway {pathway!r}, found none: fit the trials first")
    return np.array([float(np.mean(column)) for column in values])


def simulate_condition(
    trial: Trial,
    options: DummyOptions,
    foot: Foot,
    joints: dict[str, np.ndarray],
    step_s: float,
    engine: str,
) -> SimulatedCondition:
    """Simulate a recorded trial with every set of parameters.

    Parameters
    ----------
    trial : Trial
        Markers (m) and belt velocity (m/s).
    options : DummyOptions
        Processing of the recording.
    foot : Foot
        The foot (kg, m).
    joints : dict of str to ndarray, shape (3,)
        Parameter set -> I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad).
    step_s : float
        Step of the simulation (s).
    engine : {"pybullet", "mujoco", "equations", "auto"}
        Physics engine that moves the dummy.

    Returns
    -------
    SimulatedCondition
        Recording and simulations on one clock. The simulation ends where the leg falls.

    Raises
    ------
    InputError
        If the recording cannot be processed, or the dummy cannot be simulated.
    """
    prepared = prepare_trial(trial, "belt velocity", options.lowpass, options.window)
    time, velocity, at_rest = prepared.time, prepared.belt_velocity, prepared.at_rest
    motion = leg_motion(prepared, options, "aligned")
    torques = {}
    for name, pathway in MEASURED_TORQUES.items():
        torque = TORQUE_PATHWAYS[pathway](
            options.leg, motion.theta, motion.theta_dd, motion.y_dd, motion.z_dd
        )
        torques[name] = torque - torque[at_rest].mean()
    standing = float(motion.theta[at_rest].mean())
    simulations = {}
    for name, (inertia, damping, stiffness) in joints.items():
        reference = rest_angle_of_standing(options.leg, stiffness, standing)
        simulations[name] = simulate_dummy(
            time,
            velocity - np.median(velocity[at_rest]),
            options.leg,
            foot,
            Joint(inertia, damping, stiffness, reference),
            step_s,
            engine,
            Start(standing, 0.0),
        )
    return SimulatedCondition(
        time=time,
        theta=motion.theta - standing,
        torques=torques,
        perturbations=prepared.perturbations,
        joints=joints,
        simulations=simulations,
    )


def simulated_signals(simulated: SimulatedCondition, name: str) -> dict[str, np.ndarray]:
    """Simulated angle (rad) and torque (N·m) of a parameter set relative to rest, (n,), NaN after a fall."""
    simulation = simulated.simulations[name]
    missing = simulated.time.size - simulation.time.size
    theta = simulation.theta - simulation.theta[0]
    torque = simulation.torque - simulation.torque[0]
    return {
        key: np.concatenate([x, np.full(missing, np.nan)]) for key, x in (("theta", theta), ("tau", torque))
    }


def forward_scores(condition: str, simulated: SimulatedCondition) -> list[ForwardScore]:
    """Compare every simulation with the recording (%).

    After a fall the error is taken as the recorded signal itself: VAF 0 from there on.
    """
    scores = []
    for name, simulation in simulated.simulations.items():
        signals = simulated_signals(simulated, name)
        pairs = {"theta": (simulated.theta, signals["theta"])}
        pairs |= {key: (torque, signals["tau"]) for key, torque in simulated.torques.items()}
        for quantity, (measured, simulated_values) in pairs.items():
            predicted = np.where(np.isnan(simulated_values), 0.0, simulated_values)
            windows = [slice(p.start, p.stop) for p in simulated.perturbations]
            scores.append(
                ForwardScore(
                    condition,
                    name,
                    quantity,
                    float(np.mean([vaf(measured[w], predicted[w]) for w in windows])),
                    vaf(measured, predicted),
                    simulation.state,
                )
            )
    return scores


def simulation_result(simulated: SimulatedCondition) -> Result:
    """Arrays and facts of one trial, for figures."""
    arrays: dict[str, np.ndarray] = {
        "time": simulated.time,
        "theta": simulated.theta,
        "windows": np.array([[p.start, p.stop] for p in simulated.perturbations]),
    }
    units = {"time": "s", "theta": "rad", "windows": "samples"}
    for name, torque in simulated.torques.items():
        arrays[name], units[name] = torque, "Nm"
    for name in simulated.simulations:
        for key, x in simulated_signals(simulated, name).items():
            arrays[f"{name}/{key}"], units[f"{name}/{key}"] = x, {"theta": "rad", "tau": "Nm"}[key]
        arrays[f"{name}/parameters"] = np.asarray(simulated.joints[name], dtype=float)
        units[f"{name}/parameters"] = "Nms2/rad, Nms/rad, Nm/rad"
    facts = {
        "parameter_sets": list(simulated.simulations),
        "states": {name: s.state for name, s in simulated.simulations.items()},
        "growth_per_s": {name: s.growth_per_s for name, s in simulated.simulations.items()},
        "fell_at_s": {name: s.fell_at_s for name, s in simulated.simulations.items()},
    }
    return Result(arrays, units, facts)
