"""Equations of motion of a leg on a joint: spectra of foot, leg and log, and their derivatives.

About the angle at rest theta_0, with phi = theta - theta_0, b = phi + b_0 the bending of the joint,
b_0 = k_g sin(theta_0) / K where theta_0 is measured from the true vertical, k_g = m g r, p = m r,
the leg on a moving foot obeys

    J phi'' + B phi' + (K - k_g cos(theta_0)) phi = -p cos(theta_0) y'' + n
    n = k_g [sin(theta) - sin(theta_0) - phi cos(theta_0)] - p y'' [cos(theta) - cos(theta_0)]
        - p cos(theta_0) ramp'' + C (q b - q_0 b_0) - B_s q phi',      q = b^2 / (b^2 + phi_h^2)

n is small and is computed from the measured motion, without its highest frequencies. At each frequency,

    y = Y,    phi = e^(-s delay) (G Y + (N + T) / D),    v = gain e^(-s lag) s Y + jump + drift A
    D = J s^2 + B s + K - k_g cos(theta_0),    G = -p cos(theta_0) s^2 / D

Y is the foot's spectrum, unknown at every frequency. T / D is the free swing by which the trial differs
from one that repeats itself: c_1, c_2 times the spectra of the two solutions of the homogeneous equation,
sampled, which are exact. ``jump`` is the difference of the foot's position between end and start. ``drift``
is the relative difference between the clocks of log and markers: A is the spectrum of -(t - t_m) y''(t),
t_m the middle of the trial.

Symbols: J inertia of leg and joint about the ankle (kg·m²), B (N·m·s/rad), K (N·m/rad); C (N·m/rad), B_s
(N·m·s/rad) and phi_h (rad) of a joint that softens; m, r, g of the leg; delay of the angle after the foot and
lag of the log after the markers (s); gain of the log.
"""

from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
import scipy

from tepsipe.identification.likelihood.channels import Channels, smooth
from tepsipe.mechanics.inverse_dynamics import Leg

# parameters of a linear joint, and those that softening adds
LINEAR = ("J", "B", "K", "delay", "lag", "gain", "jump", "drift", "c_1", "c_2")
SOFTENING = ("C", "B_s", "b_0", "log_phi_h")


@dataclass(frozen=True)
class Motion:
    """Measured motion in the terms that are not linear."""

    phi: np.ndarray
    phi_d: np.ndarray
    phi_dd: np.ndarray
    y_dd: np.ndarray
    """Angle from rest (rad), its rate (rad/s), acceleration (rad/s²); acceleration of the foot (m/s²)."""

    @classmethod
    def measured(cls, channels: Channels, foot: np.ndarray) -> "Motion":
        """Motion (rad, m/s²) from the measured angle and a spectrum of the foot (m)."""
        n, rate = channels.angle.size, channels.rate_hz
        angle = scipy.fft.rfft(channels.angle)
        phi, phi_d, phi_dd = (smooth(angle, n, rate, order) for order in (0, 1, 2))
        return cls(phi, phi_d, phi_dd, smooth(foot, n, rate, 2) + channels.ramp)


@dataclass(frozen=True)
class Point:
    """Parameters of the model (units in the module's head); nothing of softening for a linear joint."""

    names: tuple[str, ...]
    """Those that are fitted, out of `LINEAR` and `SOFTENING`."""
    values: dict[str, float]
    """All parameters."""

    @property
    def x(self) -> np.ndarray:
        """Values of the fitted parameters, shape (p,) (kg·m², N·m·s/rad, ... as in the head)."""
        return np.array([self.values[name] for name in self.names])

    @property
    def softens(self) -> bool:
        """True if the law has the terms of a joint that softens."""
        return "C" in self.names

    def moved(self, step: np.ndarray) -> "Point":
        """The point after a step of the fitted parameters, shape (p,) (kg·m², N·m·s/rad, ...)."""
        changed = {name: self.values[name] + d for name, d in zip(self.names, step, strict=True)}
        return replace(self, values=self.values | changed)


def softening_forces(
    phi: np.ndarray, phi_d: np.ndarray, rest: Annotated[float, "rad"], half: Annotated[float, "rad"]
) -> dict[str, np.ndarray]:
    """Torque of softening in n per unit of C and B_s, and its derivatives with respect to log(phi_h), b_0.

    phi, phi_d: angle from rest (rad) and its rate (rad/s).
    rest: b_0.
    Returns: ``C`` (rad), ``B_s`` (rad/s), ``C_half``, ``B_s_half`` (the same), ``C_rest``, ``B_s_rest``
    (1/s).
    """
    bent = phi + rest
    share = bent**2 / (bent**2 + half**2)
    at_rest = rest**2 / (rest**2 + half**2)
    slope = -2.0 * share * (1.0 - share)
    return {
        "C": share * bent - at_rest * rest,
        "B_s": -share * phi_d,
        "C_half": slope * bent + 2.0 * at_rest * (1.0 - at_rest) * rest,
        "B_s_half": -slope * phi_d,
        "C_rest": share * (3.0 - 2.0 * share) - at_rest * (3.0 - 2.0 * at_rest),
        "B_s_rest": -2.0 * bent * (half / (bent**2 + half**2)) ** 2 * phi_d,
    }


@dataclass(frozen=True)
class Spectra:
    """Model at one point, at m frequencies."""

    response: Annotated[np.ndarray, "(3, m)"]
    """h: foot, angle and log per motion of the foot (1, 1/m, 1/s)."""
    independent: Annotated[np.ndarray, "(3, m)"]
    """m: the parts that do not depend on the foot (m, rad, m/s times samples)."""
    response_slopes: Annotated[np.ndarray, "(p, 3, m)"]
    independent_slopes: Annotated[np.ndarray, "(p, 3, m)"]
    """Their derivatives with respect to the fitted parameters."""


class LegModel:
    """The equations for one trial, its measured motion (rad, m/s²) and one leg (kg, m)."""

    def __init__(self, channels: Channels, leg: Leg):
        """Keep what does not change (units in `Channels` and `Leg`)."""
        self.channels, self.leg = channels, leg
        self._forces: dict = {}
        self.s, self.bins = channels.s, channels.bins
        self.coupling = leg.mass_kg * leg.com_m * np.cos(channels.theta_0_rad)
        self.weight = leg.mass_kg * leg.com_m * leg.gravity_m_per_s2
        self.leg_inertia = leg.inertia_kgm2 + leg.mass_kg * leg.com_m**2

    def bending_at_rest(self, stiffness: float) -> float:
        """b_0 (rad) of a joint of K (N·m/rad)."""
        return self.weight * float(np.sin(self.channels.theta_0_rad)) / stiffness

    def _spectrum(self, signal: np.ndarray) -> np.ndarray:
        return scipy.fft.rfft(signal)[self.bins]

    def observe(self, motion: Motion) -> None:
        """Take the measured motion (rad, m/s²) for the terms that are not linear."""
        self.motion, self._forces = motion, {None: self._geometric(motion)}
        samples = motion.y_dd.size
        since = (np.arange(samples) - 0.5 * (samples - 1)) / self.channels.rate_hz
        self._drift = -self._spectrum(since * motion.y_dd)

    def _geometric(self, motion: Motion) -> np.ndarray:
        """Spectrum of n of a linear joint (N·m times samples), shape (m,)."""
        rest = self.channels.theta_0_rad
        theta = motion.phi + rest
        bent = self.weight * (np.sin(theta) - np.sin(rest) - motion.phi * np.cos(rest))
        pushed = self.coupling / np.cos(rest) * motion.y_dd * (np.cos(theta) - np.cos(rest))
        return self._spectrum(bent - pushed - self.coupling * self.channels.ramp)

    def free_swings(self, point: Point) -> tuple[np.ndarray, np.ndarray]:
        """Spectra of the two free swings and of their rates, shape (2, m) (rad, rad/s times samples)."""
        v = point.values
        elastic = v["K"] - self.weight * np.cos(self.channels.theta_0_rad)
        poles = np.roots([v["J"], v["B"], elastic]).astype(complex)
        step, samples = 1.0 / self.channels.rate_hz, self.channels.foot.size
        ends = np.minimum(poles.real * step * samples, 30.0) + 1j * poles.imag * step * samples
        each = (1.0 - np.exp(ends))[:, None] / (1.0 - np.exp((poles[:, None] - self.s) * step))
        swings = abs(poles[0].imag) > 0.0
        mix = np.array([[0.5, 0.5], [-0.5j, 0.5j]]) if swings else np.eye(2, dtype=complex)
        return mix @ each, mix @ (poles[:, None] * each)

    def _softening(self, half: float, rest: float) -> dict[str, np.ndarray]:
        """Spectra of `softening_forces` for phi_h and b_0 (rad)."""
        if (half, rest) not in self._forces:
            forces = softening_forces(self.motion.phi, self.motion.phi_d, rest, half)
            self._forces[half, rest] = {name: self._spectrum(f) for name, f in forces.items()}
        return self._forces[half, rest]

    def spectra(self, point: Point) -> Spectra:
        """Model and derivatives at a point (units in `Spectra`)."""
        v, s, names = point.values, self.s, point.names
        elastic = v["K"] - self.weight * np.cos(self.channels.theta_0_rad)
        inverse = 1.0 / (v["J"] * s**2 + v["B"] * s + elastic)
        late, later = np.exp(-s * v["delay"]), np.exp(-s * v["lag"])
        swings, rates = self.free_swings(point)
        free, free_d = v["c_1"] * swings[0] + v["c_2"] * swings[1], v["c_1"] * rates[0] + v["c_2"] * rates[1]
        free_dd = -(v["B"] * free_d + elastic * free) / v["J"]
        force, forces = self._forces[None], {}
        if "log_phi_h" in v:
            forces = self._softening(float(np.exp(v["log_phi_h"])), v["b_0"])
            force = force + v["C"] * forces["C"] + v["B_s"] * forces["B_s"]
        gain, forced = -self.coupling * s**2 * inverse, force * inverse
        one, none = np.ones_like(s), np.zeros_like(s)
        # derivatives of both parts; the angle's derivatives by J, B, K are -phi'', -phi', -phi over D
        of_angle = {
            "J": (-(s**2) * inverse * gain, -inverse * (s**2 * forced + free_dd)),
            "B": (-s * inverse * gain, -inverse * (s * forced + free_d)),
            "K": (-inverse * gain, -inverse * (forced + free)),
            "delay": (-s * gain, -s * (forced + free)),
            "c_1": (none, swings[0]),
            "c_2": (none, swings[1]),
        }
        if forces:
            half_slope = v["C"] * forces["C_half"] + v["B_s"] * forces["B_s_half"]
            of_angle |= {"C": (none, forces["C"] * inverse), "B_s": (none, forces["B_s"] * inverse)}
            rest_slope = v["C"] * forces["C_rest"] + v["B_s"] * forces["B_s_rest"]
            of_angle |= {"log_phi_h": (none, half_slope * inverse), "b_0": (none, rest_slope * inverse)}
        logged = v["gain"] * later * s
        of_log = {
            "lag": (-s * logged, none),
            "gain": (later * s, none),
            "jump": (none, one),
            "drift": (none, self._drift),
        }
        slopes = np.zeros((2, len(names), 3, s.size), dtype=complex)
        for k, name in enumerate(names):
            for part in (0, 1):
                if name in of_angle:
                    slopes[part, k, 1] = late * of_angle[name][part]
                else:
                    slopes[part, k, 2] = of_log[name][part]
        return Spectra(
            np.array([one, late * gain, logged]),
            np.array([none, late * (forced + free), v["jump"] * one + v["drift"] * self._drift]),
            *slopes,
        )
