"""A simulated trial of the ankle dummy, and its apparent impedance by the thesis's equation of the foot."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from tepsipe.io.result import Result
from tepsipe.mechanics.impedance_model import PARAMETER_UNITS
from tepsipe.mechanics.inverse_dynamics import TORQUE_PATHWAYS, Foot, Leg, foot_torque, foot_torque_as_printed

JOINT = "joint"
TORQUES = ("foot-thesis", "foot", *TORQUE_PATHWAYS, JOINT)


@dataclass(frozen=True)
class SimulatedTrial:
    """Signals of a simulated trial of the ankle dummy, without noise, on a regular clock."""

    name: str
    """Condition."""
    time: Annotated[np.ndarray, "(n,)", "s"]
    theta: np.ndarray
    theta_d: np.ndarray
    theta_dd: np.ndarray
    """Leg angle from its rest (rad), rate (rad/s) and acceleration (rad/s²) of the joint's sensor."""
    y_leg_dd: Annotated[np.ndarray, "(n,)", "m/s²"]
    z_leg_dd: Annotated[np.ndarray, "(n,)", "m/s²"]
    """Acceleration of the leg's centre of mass."""
    y_foot: Annotated[np.ndarray, "(n,)", "m"]
    y_foot_d: Annotated[np.ndarray, "(n,)", "m/s"]
    y_foot_dd: Annotated[np.ndarray, "(n,)", "m/s²"]
    """Motion of the belt, the foot and the ankle from rest."""
    f_y: Annotated[np.ndarray, "(n,)", "N"]
    f_z: Annotated[np.ndarray, "(n,)", "N"]
    """Forces of the belt on the foot."""
    m_x: Annotated[np.ndarray, "(n,)", "N·m"]
    """Moment of the belt on the foot about the rest position of the ankle, in the surface of the belt."""
    windows: Annotated[np.ndarray, "(w, 2)"]
    """First sample of every perturbation and the first after it (samples)."""
    leg: Leg
    foot: Foot
    """Masses (kg), lengths (m), inertia (kg·m²)."""
    truth: Annotated[np.ndarray, "(3,)"]
    """I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad) of the simulated joint; estimators do not read it."""

    @property
    def rate_hz(self) -> float:
        """Sampling rate (Hz)."""
        return float((self.time.size - 1) / (self.time[-1] - self.time[0]))

    @property
    def regressors(self) -> np.ndarray:
        """Angular acceleration (rad/s²), rate (rad/s), angle (rad), shape (3, n)."""
        return np.stack([self.theta_dd, self.theta_d, self.theta])

    @property
    def instruments(self) -> np.ndarray:
        """Acceleration (m/s²), velocity (m/s), position (m) of the belt, shape (3, n)."""
        return np.stack([self.y_foot_dd, self.y_foot_d, self.y_foot])

    def torque(self, pathway: str) -> np.ndarray:
        """Torque by one of the equations of `inverse_dynamics`, or the joint's own (N·m), shape (n,)."""
        if pathway == "foot-thesis":
            return foot_torque_as_printed(self.foot, self.leg, self.f_y, self.y_leg_dd)
        if pathway == "foot":
            return foot_torque(self.foot, self.f_y, self.f_z, self.m_x, self.y_foot, self.y_foot_dd)
        if pathway == JOINT:  # thesis eq (2-1): its sensor in the simulation
            return self.truth @ self.regressors
        motion = (self.theta, self.theta_dd, self.y_leg_dd, self.z_leg_dd)
        return TORQUE_PATHWAYS[pathway](self.leg, *motion)


def apparent_impedance(
    leg: Leg, foot: Foot, parameters: Annotated[np.ndarray, "(3,)"]
) -> Annotated[np.ndarray, "(3,)"]:
    """Apparent I, B, K of a joint: the result of a noise-free fit with the printed equation of the foot.

    tau* = -F_y l_f / 2 + F_Ay l_f / 2 has a = -(m_f l_f / 2 + m l_f), b = -l_f m r, c = d = 0.

    Returns: I*, B*, K* (units as ``parameters``).
    """
    inertia, damping, stiffness = parameters
    p = leg.mass_kg * leg.com_m
    about_ankle = leg.inertia_kgm2 + p * leg.com_m + inertia
    k_g = p * leg.gravity_m_per_s2
    a = -foot.height_m * (0.5 * foot.mass_kg + leg.mass_kg)
    b = -foot.height_m * p
    return np.array([b, 0.0, 0.0]) - a / p * np.array([about_ankle, damping, stiffness - k_g])


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
    """Simulations of one condition by name, as a result."""
    units = {**SIGNALS, "windows": "samples", "truth": PARAMETER_UNITS}
    signals = {
        f"{key}/{name}": (getattr(trial, name), unit)
        for key, trial in trials.items()
        for name, unit in units.items()
    }
    return Result.of(signals, {"simulations": list(trials)})


def simulated_trial(result: Result, key: str, name: str, leg: Leg, foot: Foot) -> SimulatedTrial:
    """One simulation of a file written with `simulated_result` (s, rad, m, N, N·m).

    ``key`` names the simulation, ``name`` the condition; ``leg`` and ``foot`` are the dummy's (kg, m, kg·m²).
    """
    signals = {signal: result.arrays[f"{key}/{signal}"] for signal in SIGNALS}
    windows, truth = result.arrays[f"{key}/windows"], result.arrays[f"{key}/truth"]
    return SimulatedTrial(name=name, **signals, windows=windows, leg=leg, foot=foot, truth=truth)
