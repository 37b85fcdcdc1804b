"""Validation of parameters by forward simulation (thesis section 4-1-3).

Every trial of the ankle dummy is simulated with several sets of parameters, driven by the recorded
motion of its foot, or of the belt if the foot has no markers, and compared with the recorded angle and with
the torque by inverse dynamics. A physics engine moves the leg with the sets that the thesis compares; the
others need only the equations of motion.

The simulated force of the belt on the foot is the rate of the momentum of foot and leg. The plate measures it
with the belt-induced force, which no simulation contains:

    F_y = m_f y_f'' + m y'',   y = y_f + r sin(theta)
    dF_y = F_y,measured - F_y

This is eq (3-11) with the sign of the empty belt. Errors of masses and of the simulated motion are part of
dF_y. Symbols: m_f and m masses of foot and leg (kg); y_f and y positions of the foot and of the leg's centre
of mass (m); r its distance from the ankle (m).
"""

from collections.abc import Iterable
from dataclasses import asdict, dataclass, replace
from typing import Annotated

import numpy as np

from tepsipe.errors import InputError
from tepsipe.experiments.dummy.leg_pathways import (
    DummyOptions,
    belt_fixed_position,
    leg_motion,
    prepare_dummy,
)
from tepsipe.experiments.forward.scores import ForwardScore, swing_sizes
from tepsipe.io.estimates import Estimate
from tepsipe.io.result import Result
from tepsipe.io.trial import Trial
from tepsipe.mechanics.forward_dynamics import ForwardSimulation, Joint, Start, resting, simulate_dummies
from tepsipe.mechanics.impedance_model import PARAMETER_UNITS, PARAMETERS, SMALL
from tepsipe.mechanics.inverse_dynamics import TORQUE_PATHWAYS, Foot
from tepsipe.signals.differentiation import derivative
from tepsipe.signals.perturbations import Perturbation
from tepsipe.signals.time_alignment import LONGEST_S, advanced, common_signal_delay
from tepsipe.statistics.goodness_of_fit import explained
from tepsipe.treadmill.prepared import PreparedTrial

MEASURED_TORQUES = {"tau": "leg-thesis", "tau_consistent": "leg"}
# simulated signals of thesis section 2-1-3: name -> field of `ForwardSimulation` and unit
SIGNALS = {
    "theta": ("theta", "rad"),
    "theta_d": ("theta_d", "rad/s"),
    "theta_dd": ("theta_dd", "rad/s2"),
    "tau": ("torque", "Nm"),
    "f_y": ("f_y", "N"),
    "f_z": ("f_z", "N"),
    "f_ay": ("f_ay", "N"),
    "f_az": ("f_az", "N"),
    "foot_y": ("foot_y", "m"),
    "foot_y_d": ("foot_y_d", "m/s"),
    "foot_y_dd": ("foot_y_dd", "m/s2"),
}
FROM_REST = ("theta", "tau")


@dataclass(frozen=True)
class SimulatedCondition:
    """One trial, recorded and simulated."""

    time: Annotated[np.ndarray, "(n,)", "s"]
    theta: Annotated[np.ndarray, "(n,)", "rad"]
    """Recorded leg angle from rest."""
    standing_rad: float
    """Leg angle at rest, from the vertical."""
    foot_velocity: Annotated[np.ndarray, "(n,)", "m/s"]
    """Velocity of the foot, which drives the simulations."""
    torques: dict[str, np.ndarray]
    """Torque by inverse dynamics, relative to rest (N·m): ``tau`` by the equation as printed,
    ``tau_consistent`` by the consistent equation."""
    f_y: Annotated[np.ndarray, "(n,)", "N"] | None
    """Measured force of the plate on the foot, zero at rest, on the clock of the foot; None without plate."""
    perturbations: list[Perturbation]
    """Windows (samples)."""
    joints: dict[str, Joint]
    """Parameter set -> the joint that was simulated (units in it)."""
    engines: dict[str, str]
    """Parameter set -> the engine that moved the leg."""
    simulations: dict[str, ForwardSimulation]
    """Parameter set -> simulation, on the recorded instants."""


def mean_joint(
    estimates: Iterable[Estimate],
    pathway: str,
    estimator: str | None = None,
    quantities: tuple[str, ...] = PARAMETERS,
) -> Joint:
    """Linear joint with the mean I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad) of some rows of estimates."""
    rows = [e for e in estimates if e.pathway == pathway and estimator in (None, e.estimator)]
    values = [[e.value for e in rows if e.quantity == quantity] for quantity in quantities]
    if not all(values):
        raise InputError(f"expected estimates by the pathway {pathway!r}, found none: fit the trials first")
    return Joint(*(float(np.mean(column)) for column in values))


def likelihood_joint(estimates: Iterable[Estimate], fit: Result, pathway: str) -> Joint | None:
    """Joint with the law that the joint likelihood fitted to a trial.

    fit: fit of the trial, with the softening among its facts.
    Returns: I, B, K of small movements, with softening if the trial showed any; None if the pathway is no
    joint likelihood.
    """
    facts = fit.facts["joint_likelihood"].get(pathway)
    if facts is None:
        return None
    joint = mean_joint(estimates, pathway, quantities=SMALL)
    if "half_softening_rad" not in facts:
        return joint
    return replace(
        joint,
        softening_Nm_per_rad=facts["softening_Nm_per_rad"],
        softened_damping_Nms_per_rad=facts["softened_damping_Nms_per_rad"],
        half_softening_rad=facts["half_softening_rad"],
    )


def simulate_condition(
    trial: Trial,
    options: DummyOptions,
    foot: Foot,
    joints: dict[str, Joint],
    step_s: float,
    engines: dict[str, str],
    belt: str | None = None,
) -> SimulatedCondition:
    """Simulate a recorded trial with every set of parameters.

    options: processing of the recording. With belt-fixed markers these move the foot, because a leg with
    little damping swings with the noise of the belt's log; without them the log does.
    joints: parameter set -> joint (units in it); its rest angle follows from the leg's angle at rest.
    step_s: step of the simulation.
    engines: parameter set -> the engine that moves the leg.
    belt: the belt on which the dummy stands, left or right; None for a recording without plate.
    Returns: recording and simulations on one clock. The simulation ends where the leg falls.
    """
    prepared, _ = prepare_dummy(trial, options, "belt velocity")
    time, velocity, at_rest = prepared.time, _foot_velocity(prepared, options), prepared.at_rest
    measured = belt is not None and "force" in trial.signals
    f_y = _measured_force(prepared, belt, velocity) if measured else None
    motion = leg_motion(prepared, options, "aligned")
    torques = {}
    for name, pathway in MEASURED_TORQUES.items():
        torque = TORQUE_PATHWAYS[pathway](
            options.leg, motion.theta, motion.theta_dd, motion.y_dd, motion.z_dd
        )
        torques[name] = torque - torque[at_rest].mean()
    standing = float(motion.theta[at_rest].mean())
    velocity = velocity - np.median(velocity[at_rest])
    simulations = {}
    for engine in dict.fromkeys(engines.values()):
        moved = {name: joint for name, joint in joints.items() if engines[name] == engine}
        rested = {name: resting(options.leg, joint, standing) for name, joint in moved.items()}
        simulations |= simulate_dummies(
            time, velocity, options.leg, foot, rested, step_s, engine, Start(standing, 0.0)
        )
    return SimulatedCondition(
        time=time,
        theta=motion.theta - standing,
        standing_rad=standing,
        foot_velocity=velocity,
        torques=torques,
        f_y=f_y,
        perturbations=prepared.perturbations,
        joints=joints,
        engines=engines,
        simulations={name: simulations[name] for name in joints},
    )


def _foot_velocity(prepared: PreparedTrial, options: DummyOptions) -> np.ndarray:
    """Velocity of the foot (m/s), shape (n,)."""
    if not options.belt_fixed_labels:
        return prepared.belt_velocity
    position = belt_fixed_position(prepared.trial, options.belt_fixed_labels, "aligned")
    return derivative(prepared.time, prepared.filtered(position))


def _measured_force(prepared: PreparedTrial, belt: str, foot_velocity: np.ndarray) -> np.ndarray:
    """Measured F_y (N), zero at rest, shape (n,).

    The plate and the log of the belt share a clock; the foot's velocity (m/s) may be on that of the markers.
    """
    delay_s, _, _ = common_signal_delay(foot_velocity, prepared.belt_velocity, prepared.rate_hz, LONGEST_S)
    return advanced(prepared.time, prepared.load_from_rest(belt)["Fy"], delay_s)


def simulated_signals(simulated: SimulatedCondition, name: str) -> dict[str, np.ndarray]:
    """Simulated signals of a parameter set (units in `SIGNALS`), each of shape (n,), NaN after a fall.

    Angle and torque are relative to rest.
    """
    simulation = simulated.simulations[name]
    after = np.full(simulated.time.size - simulation.time.size, np.nan)
    found = {}
    for key, (field, _) in SIGNALS.items():
        values = getattr(simulation, field)
        found[key] = np.concatenate([values - values[0] if key in FROM_REST else values, after])
    return found


def swing_growth(theta: np.ndarray, perturbations: list[Perturbation]) -> float:
    """Largest swing of a trial relative to the swing after the first perturbation.

    theta: angle from rest (rad), NaN after a fall.
    Returns: 1 if the first swing is the largest; infinite if the leg falls; NaN for fewer than two
    perturbations.
    """
    if len(perturbations) < 2:
        return np.nan
    swings = swing_sizes(theta, [(p.start, p.stop) for p in perturbations])
    return max(swings) / swings[0] if np.isfinite(swings).all() else np.inf


def forward_scores(condition: str, simulated: SimulatedCondition) -> list[ForwardScore]:
    """Compare every simulation with the recording (%).

    After a fall the error is taken as the recorded signal itself: VAF 0 from there on.
    """
    scores = []
    for name, simulation in simulated.simulations.items():
        signals = simulated_signals(simulated, name)
        growth = swing_growth(signals["theta"], simulated.perturbations)
        pairs = {"theta": (simulated.theta, signals["theta"])}
        pairs |= {key: (torque, signals["tau"]) for key, torque in simulated.torques.items()}
        if simulated.f_y is not None:
            pairs["f_y"] = (simulated.f_y, signals["f_y"])
        for quantity, (measured, simulated_values) in pairs.items():
            predicted = np.where(np.isnan(simulated_values), 0.0, simulated_values)
            windows = [slice(p.start, p.stop) for p in simulated.perturbations]
            scores.append(
                ForwardScore(
                    condition,
                    name,
                    simulated.engines[name],
                    quantity,
                    float(np.mean([explained(measured[w], predicted[w]) for w in windows])),
                    explained(measured, predicted),
                    simulation.state,
                    growth,
                )
            )
    return scores


def engine_differences(simulated: SimulatedCondition, other: SimulatedCondition) -> dict[str, float]:
    """Largest differences between simulations of one trial by different engines, over all sets.

    Returns: those of angle and torque, in percent of the largest of the set, and of any VAF, in percentage
    points.
    """
    found = dict.fromkeys(("theta_percent", "tau_percent"), 0.0)
    for name in simulated.simulations:
        signals, others = (simulated_signals(one, name) for one in (simulated, other))
        for key in FROM_REST:
            signal = signals[key]
            difference = np.nanmax(np.abs(signal - others[key])) / np.nanmax(np.abs(signal))
            found[f"{key}_percent"] = max(found[f"{key}_percent"], 100.0 * float(difference))
    scores, others = (
        np.array([(s.vaf_perturbation, s.vaf_trial) for s in forward_scores("", one)])
        for one in (simulated, other)
    )
    return found | {"vaf_points": float(np.abs(scores - others).max())}


def simulation_result(simulated: SimulatedCondition, differences: dict[str, float] | None = None) -> Result:
    """Arrays and facts of one trial, for figures and the page of the report.

    differences: those of `engine_differences`, where other engines simulated the trial as well.
    """
    signals = {
        "time": (simulated.time, "s"),
        "theta": (simulated.theta, "rad"),
        "foot_velocity": (simulated.foot_velocity, "m/s"),
        "windows": ([[p.start, p.stop] for p in simulated.perturbations], "samples"),
    }
    signals |= {name: (torque, "Nm") for name, torque in simulated.torques.items()}
    if simulated.f_y is not None:
        signals["f_y"] = (simulated.f_y, "N")
    for name in simulated.simulations:
        for key, x in simulated_signals(simulated, name).items():
            signals[f"{name}/{key}"] = (x if key in FROM_REST else x.astype(np.float32), SIGNALS[key][1])
        joint = simulated.joints[name]
        constants = [joint.inertia_Nms2_per_rad, joint.damping_Nms_per_rad, joint.stiffness_Nm_per_rad]
        signals[f"{name}/parameters"] = (constants, PARAMETER_UNITS)
    facts = {
        "parameter_sets": list(simulated.simulations),
        "engines": simulated.engines,
        "engine_differences": differences,
        "standing_rad": simulated.standing_rad,
        "joints": {name: _constants(joint) for name, joint in simulated.joints.items()},
        "softens": [name for name, joint in simulated.joints.items() if joint.softens],
        "measured_growth": _finite(swing_growth(simulated.theta, simulated.perturbations)),
        "pulse_interval_s": _finite(_pulse_interval(simulated)),
        "periods_s": {name: _finite(s.period_s) for name, s in simulated.simulations.items()},
        "states": {name: s.state for name, s in simulated.simulations.items()},
        "growth_per_s": {name: s.growth_per_s for name, s in simulated.simulations.items()},
        "fell_at_s": {name: s.fell_at_s for name, s in simulated.simulations.items()},
    }
    return Result.of(signals, facts)


def _constants(joint: Joint) -> dict[str, float]:
    """Constants of a joint (units in their names); those of softening only if the joint softens."""
    softening = ("softening_Nm_per_rad", "softened_damping_Nms_per_rad", "half_softening_rad")
    return {name: value for name, value in asdict(joint).items() if joint.softens or name not in softening}


def _pulse_interval(simulated: SimulatedCondition) -> float:
    """Median time between onsets of neighbouring perturbations (s); NaN for fewer than two."""
    onsets = [simulated.time[p.start] for p in simulated.perturbations]
    return float(np.median(np.diff(onsets))) if len(onsets) > 1 else np.nan


def _finite(value: float) -> float | None:
    """The value (its unit), None if it is infinite or undefined."""
    return value if np.isfinite(value) else None
