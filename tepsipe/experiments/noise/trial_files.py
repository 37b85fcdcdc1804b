"""Files of the simulated trials of the noise study."""

from tepsipe.experiments.noise.trial import SimulatedTrial
from tepsipe.io.result import Result
from tepsipe.mechanics.inverse_dynamics import Foot, Leg

SIGNALS = {
    "time": "s",
    "theta": "rad",
    "theta_d": "rad/s",
    "theta_dd": "rad/s2",
    "y_leg_dd": "m/s2",
    "z_leg_dd": "m/s2",
    "y_foot": "m",
    "y_foot_d": "m/s",
    "y_foot_dd": "m/s2",
    "f_y": "N",
    "f_z": "N",
    "m_x": "Nm",
}


def simulated_result(trials: dict[str, SimulatedTrial]) -> Result:
    """Simulations of one condition by name, as a result (units in the result)."""
    arrays, units = {}, {}
    for key, trial in trials.items():
        for name, unit in SIGNALS.items():
            arrays[f"{key}/{name}"], units[f"{key}/{name}"] = getattr(trial, name), unit
        arrays[f"{key}/windows"], units[f"{key}/windows"] = trial.windows, "samples"
        arrays[f"{key}/truth"], units[f"{key}/truth"] = trial.truth, "Nms2/rad, Nms/rad, Nm/rad"
    return Result(arrays, units, {"simulations": list(trials)})


def simulated_trial(result: Result, key: str, name: str, leg: Leg, foot: Foot) -> SimulatedTrial:
    """One simulation of a file written with `simulated_result` (s, rad, m, N, N·m).

    ``key`` names the simulation, ``name`` the condition; ``leg`` and ``foot`` are the dummy's (kg, m, kg·m²).
    """
    signals = {signal: result.arrays[f"{key}/{signal}"] for signal in SIGNALS}
    windows, truth = result.arrays[f"{key}/windows"], result.arrays[f"{key}/truth"]
    return SimulatedTrial(name=name, **signals, windows=windows, leg=leg, foot=foot, truth=truth)
