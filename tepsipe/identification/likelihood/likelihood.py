"""Likelihood of leg markers, foot markers and drive log together: output error with noise in every channel.

At every frequency f of the band the channels z = (foot, angle, log) of `channels` are

    z = h(f; x) Y(f) + m(f; x) + e(f),    e ~ N(0, R),    R = diag(sigma^2 G, sigma_v^2)

with h and m of the equations of motion below. The motion Y of the foot is unknown at every frequency (errors
in variables); the likelihood is maximal at Y = h^H R^-1 (z - m) / h^H R^-1 h, and the residual,

    l(x) = sum over f of |P W (z - m)|^2,    W = R^-1/2,    P = I - W h h^H W^H / |W h|^2

is minimised by Gauss-Newton steps with columns u = P W (dh Y + dm). sigma comes from the markers' residuals;
sigma_v maximises the restricted likelihood. With noise in Y, |u|^2 overstates the information by |P W dh|^2 /
|W h|^2. With F the information without that part and F_0 the whole, the covariance of x is

    F^-1 F_0 F^-1,    F_0 = 2 Re sum u^H u

(Wald). The error of d, the position of the joint relative to the markers, is added. No part of the
trial is weighted by hand, nothing is filtered, and no spline is differentiated.

A joint that softens with bending and loses more as it softens has three more parameters, C, B_s and phi_h:

    tau = I phi'' + B phi' + K phi - C q phi + B_s q phi',    q = phi^2 / (phi^2 + phi_h^2)

C and B_s are fitted whether or not they differ from 0: if a joint were taken as linear because a test
finds no softening, the intervals would be too narrow. If they lower the deviance by more than `SOFTENS`,
phi_h and b_0, the bending at rest, are fitted as well, because an error of a few milliradians in the vertical
makes the law asymmetric. Both have priors,

    log(phi_h) ~ N(log of the largest bending, _HALF_ERROR^2),    b_0 ~ N(k_g sin(theta_0) / K, _REST_ERROR^2)

so that a trial that does not determine them returns wide intervals of C and B_s, not those for a fixed phi_h.
Otherwise phi_h is the largest bending. K, B and I of this law hold for small movements. The linear parameters
at the amplitude of the perturbations are the mean over their windows of the least-squares fit of the law's
torque on the predicted motion,

    tau - tau_rest = I theta'' + B theta' + K (theta - theta_rest)

which is linear in K, B, I, C and B_s, so its covariance follows from the covariance of x.

Equations of motion of a leg on a joint: spectra of foot, leg and log, and their derivatives.

About the angle at rest theta_0, with phi = theta - theta_0, b = phi + b_0 the bending of the joint,
b_0 = k_g sin(theta_0) / K where theta_0 is measured from the true vertical, k_g = m g r, p = m r,
the leg on a moving foot obeys

    J phi'' + B phi' + (K - k_g cos(theta_0)) phi = -p cos(theta_0) y'' + n
    n = k_g [sin(theta) - sin(theta_0) - phi cos(theta_0)] - p y'' [cos(theta) - cos(theta_0)]
        - p cos(theta_0) ramp'' + C (q b - q_0 b_0) - B_s q phi',      q = b^2 / (b^2 + phi_h^2)

n is small. It is computed from the motion that the fit predicts, without the highest frequencies, and is
updated at every step: the squared noise of a measured angle would bias it. At each frequency,

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

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Annotated, NamedTuple

import numpy as np
import scipy

from tepsipe.errors import InputError
from tepsipe.identification.likelihood.channels import Channels, DummyMarkers, make_channels, smooth
from tepsipe.identification.regression.windows import undetermined
from tepsipe.mechanics.inverse_dynamics import Leg

# parameters of a linear joint, and those that softening adds
LINEAR = ("J", "B", "K", "delay", "lag", "gain", "jump", "drift", "c_1", "c_2")
FORCES = ("C", "B_s")
SOFTENING = (*FORCES, "b_0", "log_phi_h")
# parameters of the motion of angle and log per motion of the foot
OF_RESPONSE = ("J", "B", "K", "delay", "lag", "gain")


@dataclass(frozen=True)
class Motion:
    """Motion in the terms that are not linear."""

    phi: np.ndarray
    phi_d: np.ndarray
    phi_dd: np.ndarray
    y_dd: np.ndarray
    """Angle from rest (rad), its rate (rad/s), acceleration (rad/s²); acceleration of the foot (m/s²)."""

    @classmethod
    def of(cls, channels: Channels, angle: np.ndarray, foot: np.ndarray) -> "Motion":
        """Motion (rad, m/s²) from spectra of angle (rad) and foot (m) at all frequencies."""
        n, rate = channels.angle.size, channels.rate_hz
        phi, phi_d, phi_dd = (smooth(angle, n, rate, order) for order in (0, 1, 2))
        return cls(phi, phi_d, phi_dd, smooth(foot, n, rate, 2) + channels.ramp)


@dataclass(frozen=True)
class Point:
    """Parameters of the model (units in the module's head); nothing of softening for a linear joint."""

    names: tuple[str, ...]
    """Those that are fitted, out of `LINEAR` and `SOFTENING`."""
    values: dict[str, float]
    """All parameters."""
    priors: dict[str, tuple[float, float]] = field(default_factory=dict)
    """Expectation and standard deviation of fitted parameters that a trial may not determine."""

    @property
    def x(self) -> np.ndarray:
        """Values of the fitted parameters, shape (p,) (kg·m², N·m·s/rad, ... as in the head)."""
        return np.array([self.values[name] for name in self.names])

    @property
    def prior_information(self) -> np.ndarray:
        """1 over the variance of the priors, shape (p,); 0 without one."""
        return np.array([self.priors[n][1] ** -2 if n in self.priors else 0.0 for n in self.names])

    @property
    def prior_errors(self) -> np.ndarray:
        """Parameters minus their expectations, shape (p,); 0 without a prior."""
        return np.array([self.values[n] - self.priors[n][0] if n in self.priors else 0.0 for n in self.names])

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
    """Torque of softening in n per unit of C and B_s.

    phi, phi_d: angle from rest (rad) and its rate (rad/s).
    rest: b_0.
    Returns: ``C`` (rad), ``B_s`` (rad/s).
    """
    bent = phi + rest
    share = bent**2 / (bent**2 + half**2)
    at_rest = rest**2 / (rest**2 + half**2)
    return {"C": share * bent - at_rest * rest, "B_s": -share * phi_d}


def softening_slopes(phi: np.ndarray, phi_d: np.ndarray, rest: float, half: float) -> dict[str, np.ndarray]:
    """Derivatives of `softening_forces`, ``_half`` by log(phi_h) (their units), ``_rest`` by b_0 (1, 1/s)."""
    bent = phi + rest
    share = bent**2 / (bent**2 + half**2)
    at_rest = rest**2 / (rest**2 + half**2)
    slope = -2.0 * share * (1.0 - share)
    return {
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


class _Linear(NamedTuple):
    """What the model and its derivatives share at one point for any motion, in the symbols of the head."""

    elastic: float
    inverse: np.ndarray
    gain: np.ndarray
    late: np.ndarray
    later: np.ndarray
    swings: np.ndarray
    free: np.ndarray
    free_d: np.ndarray
    response: np.ndarray
    """As in `Spectra`."""


class _Parts(NamedTuple):
    """The same for one motion."""

    forces: dict[str, np.ndarray]
    """Spectra of `softening_forces`; none of a linear joint."""
    forced: np.ndarray
    independent: np.ndarray
    """As in `Spectra`."""


class LegModel:
    """The equations for one trial, its motion (rad, m/s²) and one leg (kg, m)."""

    def __init__(self, channels: Channels, leg: Leg):
        """Keep what does not change (units in `Channels` and `Leg`)."""
        self.channels, self.leg = channels, leg
        self.s, self.bins = channels.s, channels.bins
        self.coupling = leg.mass_kg * leg.com_m * np.cos(channels.theta_0_rad)
        self.weight = leg.mass_kg * leg.com_m * leg.gravity_m_per_s2
        self.leg_inertia = leg.inertia_kgm2 + leg.mass_kg * leg.com_m**2
        self._last_linear: tuple[Point, _Linear] | None = None

    def bending_at_rest(self, stiffness: float) -> float:
        """b_0 (rad) of a joint of K (N·m/rad)."""
        return self.weight * float(np.sin(self.channels.theta_0_rad)) / stiffness

    def _spectrum(self, signal: np.ndarray) -> np.ndarray:
        return scipy.fft.rfft(signal)[self.bins]

    def observe(self, motion: Motion) -> None:
        """Take a motion (rad, m/s²) for the terms that are not linear."""
        self.motion, self._force = motion, self._geometric(motion)
        self._forces: dict[tuple, dict[str, np.ndarray]] = {}
        self._last: tuple[Point, _Parts] | None = None
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

    def swing_per_foot(self, v: dict[str, float], s: np.ndarray) -> np.ndarray:
        """G (rad/m) at the frequencies ``s`` (rad/s)."""
        elastic = v["K"] - self.weight * np.cos(self.channels.theta_0_rad)
        return -self.coupling * s**2 / (v["J"] * s**2 + v["B"] * s + elastic)

    def free_swings(self, v: dict[str, float]) -> tuple[np.ndarray, np.ndarray]:
        """Spectra of the two free swings and of their rates, shape (2, m) (rad, rad/s times samples)."""
        elastic = v["K"] - self.weight * np.cos(self.channels.theta_0_rad)
        poles = np.roots([v["J"], v["B"], elastic]).astype(complex)
        step, samples = 1.0 / self.channels.rate_hz, self.channels.foot.size
        ends = np.minimum(poles.real * step * samples, 30.0) + 1j * poles.imag * step * samples
        each = (1.0 - np.exp(ends))[:, None] / (1.0 - np.exp((poles[:, None] - self.s) * step))
        swings = abs(poles[0].imag) > 0.0
        mix = np.array([[0.5, 0.5], [-0.5j, 0.5j]]) if swings else np.eye(2, dtype=complex)
        return mix @ each, mix @ (poles[:, None] * each)

    def _softening(self, v: dict[str, float], forces: Callable) -> dict[str, np.ndarray]:
        """Spectra of `softening_forces` or `softening_slopes` at a point."""
        of = forces, float(np.exp(v["log_phi_h"])), v["b_0"]
        if of not in self._forces:
            found = forces(self.motion.phi, self.motion.phi_d, v["b_0"], of[1])
            spectra = scipy.fft.rfft(np.array(list(found.values())), axis=1)[:, self.bins]
            self._forces[of] = dict(zip(found, spectra, strict=True))
        return self._forces[of]

    def _parts(self, point: Point) -> _Parts:
        if self._last is None or self._last[0] is not point:
            self._last = point, self._parts_at(point)
        return self._last[1]

    def _parts_at(self, point: Point) -> _Parts:
        v, linear, force, forces = point.values, self._linear(point), self._force, {}
        if "log_phi_h" in v:
            forces = self._softening(v, softening_forces)
            force = force + v["C"] * forces["C"] + v["B_s"] * forces["B_s"]
        forced = force * linear.inverse
        one, none = np.ones_like(self.s), np.zeros_like(self.s)
        angle = linear.late * (forced + linear.free)
        independent = np.array([none, angle, v["jump"] * one + v["drift"] * self._drift])
        return _Parts(forces, forced, independent)

    def _linear(self, point: Point) -> _Linear:
        if self._last_linear is None or self._last_linear[0] is not point:
            self._last_linear = point, self._linear_at(point.values)
        return self._last_linear[1]

    def _linear_at(self, v: dict[str, float]) -> _Linear:
        s = self.s
        elastic = v["K"] - self.weight * np.cos(self.channels.theta_0_rad)
        inverse = 1.0 / (v["J"] * s**2 + v["B"] * s + elastic)
        late, later = np.exp(-s * v["delay"]), np.exp(-s * v["lag"])
        swings, rates = self.free_swings(v)
        free, free_d = v["c_1"] * swings[0] + v["c_2"] * swings[1], v["c_1"] * rates[0] + v["c_2"] * rates[1]
        gain = -self.coupling * s**2 * inverse
        response = np.array([np.ones_like(s), late * gain, v["gain"] * later * s])
        return _Linear(elastic, inverse, gain, late, later, swings, free, free_d, response)

    def predicted(self, point: Point) -> tuple[np.ndarray, np.ndarray]:
        """Response and independent part at a point, as in `Spectra`, without derivatives."""
        return self._linear(point).response, self._parts(point).independent

    def spectra(self, point: Point, names: tuple[str, ...] | None = None) -> Spectra:
        """Model and derivatives at a point (units in `Spectra`).

        names: parameters by which it is derived; all that are fitted if left out.
        """
        names = names or point.names
        v, s, linear, parts = point.values, self.s, self._linear(point), self._parts(point)
        inverse, gain, free, late = linear.inverse, linear.gain, linear.free, linear.late
        forced, forces, none = parts.forced, parts.forces, np.zeros_like(s)
        free_dd = -(v["B"] * linear.free_d + linear.elastic * free) / v["J"]
        # derivatives of both parts; the angle's derivatives by J, B, K are -phi'', -phi', -phi over D
        of_angle = {
            "J": (-(s**2) * inverse * gain, -inverse * (s**2 * forced + free_dd)),
            "B": (-s * inverse * gain, -inverse * (s * forced + linear.free_d)),
            "K": (-inverse * gain, -inverse * (forced + free)),
            "delay": (-s * gain, -s * (forced + free)),
            "c_1": (none, linear.swings[0]),
            "c_2": (none, linear.swings[1]),
        }
        if forces:
            of_angle |= {name: (none, forces[name] * inverse) for name in ("C", "B_s")}
        if {"log_phi_h", "b_0"} & set(names):
            by = self._softening(v, softening_slopes)
            half_slope = v["C"] * by["C_half"] + v["B_s"] * by["B_s_half"]
            rest_slope = v["C"] * by["C_rest"] + v["B_s"] * by["B_s_rest"]
            of_angle |= {"log_phi_h": (none, half_slope * inverse), "b_0": (none, rest_slope * inverse)}
        of_log = {
            "lag": (-s * linear.response[2], none),
            "gain": (linear.later * s, none),
            "jump": (none, np.ones_like(s)),
            "drift": (none, self._drift),
        }
        slopes = np.zeros((2, len(names), 3, s.size), dtype=complex)
        for k, name in enumerate(names):
            for part in (0, 1):
                if name in of_angle:
                    slopes[part, k, 1] = late * of_angle[name][part]
                else:
                    slopes[part, k, 2] = of_log[name][part]
        return Spectra(linear.response, parts.independent, *slopes)


# decrease of the deviance above which phi_h and b_0 are fitted
SOFTENS = 16.0
# tried values of phi_h over the largest bending, and allowed distance of a fitted one from them
_HALVES = (0.35, 0.6, 1.0, 1.7, 3.0)
_HALF_RANGE = (0.1, 10.0)
# standard deviations of the priors of log(phi_h) and b_0 (rad)
_HALF_ERROR, _REST_ERROR = 1.0, 0.01
# number of steps, and of steps that update the noise of the log and the motion
_STEPS, _NOISE_STEPS = 60, 15


@dataclass(frozen=True)
class Eliminated:
    """Residuals at one point, without the motion of the foot."""

    point: Point
    foot: Annotated[np.ndarray, "(m,)"]
    """Estimated spectrum of the foot (m times samples)."""
    whitened: Annotated[np.ndarray, "(c, m)"]
    """P W (z - m), with unit variance."""
    direction: Annotated[np.ndarray, "(c, m)"]

    @property
    def deviance(self) -> float:
        """Twice the sum of squares, with the priors."""
        of_priors = self.point.prior_information @ self.point.prior_errors**2
        return 2.0 * float(np.sum(np.abs(self.whitened) ** 2)) + float(of_priors)


@dataclass(frozen=True)
class Residuals(Eliminated):
    """Residuals with their derivatives, as a Gauss-Newton step needs them."""

    columns: Annotated[np.ndarray, "(p, c, m)"]
    """u (1 over the units of the parameters)."""
    by_noise: Annotated[np.ndarray, "(p, c, m)"]
    """P W dh / |W h|, contribution of noise in Y to u (1 over the units of the parameters)."""

    @cached_property
    def information(self) -> np.ndarray:
        """F_0 with the priors, shape (p, p) (1 over the units of the parameters, squared)."""
        return _products(self.columns) + np.diag(self.point.prior_information)

    @cached_property
    def excess(self) -> np.ndarray:
        """Part of F_0 that is due to noise in Y, shape (p, p) (units as F_0)."""
        return _products(self.by_noise)

    @property
    def gradient(self) -> np.ndarray:
        """2 Re sum u^H P W (z - m), with the priors, shape (p,) (1 over the units of the parameters)."""
        return self.along(self.whitened) - self.point.prior_information * self.point.prior_errors

    def along(self, residual: Annotated[np.ndarray, "(c, m)"]) -> np.ndarray:
        """2 Re sum u^H r of whitened residuals r, shape (p,) (1 over the units of the parameters)."""
        columns, residual = self.columns.reshape(len(self.columns), -1), residual.ravel()
        return 2.0 * (columns.real @ residual.real + columns.imag @ residual.imag)


def _project(x: np.ndarray, direction: np.ndarray) -> np.ndarray:
    """Part of ``x``, shape (..., c, m), that the motion of the foot does not explain."""
    return x - direction * np.sum(direction.conj() * x, axis=-2)[..., None, :]


def _products(columns: np.ndarray) -> np.ndarray:
    """2 Re sum of u_i^H u_j, shape (p, p)."""
    flat = columns.reshape(len(columns), -1)
    return 2.0 * (flat.real @ flat.real.T + flat.imag @ flat.imag.T)


@dataclass(frozen=True)
class LikelihoodFit:
    """The likelihood's maximum."""

    point: Point
    """Parameters (units in `tepsipe.identification.likelihood.likelihood`)."""
    covariance: Annotated[np.ndarray, "(p, p)"]
    """Covariance of the fitted parameters."""
    residuals: Residuals
    """At the maximum."""
    log_noise_m_per_s: float | None
    """sigma_v (m/s); None without a log."""
    channels: Channels
    """Fitted channels."""
    model: LegModel
    """Its equations."""

    def value(self, name: str) -> float:
        """Value of a parameter (units in `tepsipe.identification.likelihood.likelihood`)."""
        return self.point.values[name]

    def standard_error(self, name: str) -> float:
        """Standard error of a fitted parameter."""
        k = self.point.names.index(name)
        return float(np.sqrt(self.covariance[k, k]))

    @property
    def softens(self) -> bool:
        """True if the law has the terms of a joint that softens."""
        return self.point.softens


class _Likelihood:
    """Measured spectra of a trial, their noise, and the residuals of the model at a point."""

    def __init__(self, channels: Channels, model: LegModel):
        self.channels, self.model = channels, model
        signals = [channels.foot, channels.angle, *([] if channels.log is None else [channels.log])]
        spectra = scipy.fft.rfft(np.array(signals), axis=1)
        self.measured, self._angle = spectra[:, model.bins], spectra[1]
        self._log = None if channels.log is None else spectra[2]
        self.log_noise = None
        if channels.log is not None:
            difference = self.measured[2] - model.s * self.measured[0]
            high = np.abs(model.s) > 0.5 * np.abs(model.s[-1])
            spread = np.mean(np.abs(difference[high]) ** 2) / channels.foot.size
            of_markers = channels.marker_noise_m**2 * channels.geometry[0, 0]
            expected = float(spread - of_markers * np.mean(np.abs(model.s[high]) ** 2))
            # as long as the foot's markers are noisier than the log, the log's share is small
            self.log_noise = float(np.sqrt(max(expected, 0.05 * spread, self._least**2)))
        model.observe(Motion.of(channels, self._angle, self.first_foot()))

    @property
    def _least(self) -> float:
        return 1e-7 * float(np.ptp(self.channels.log))

    def whitening(self) -> np.ndarray:
        """W, shape (c, c)."""
        sigma, samples = self.channels.marker_noise_m, self.channels.foot.size
        covariance = np.zeros((len(self.measured),) * 2)
        covariance[:2, :2] = sigma**2 * self.channels.geometry
        if self.log_noise is not None:
            covariance[2, 2] = self.log_noise**2
        return np.linalg.inv(np.linalg.cholesky(samples * covariance))

    def first_foot(self) -> np.ndarray:
        """Spectrum of the foot from markers and log, all frequencies (m times samples)."""
        foot, s = self.measured[0], self.model.s
        if self.log_noise is not None:
            trusted = np.abs(s) ** 2 / self.log_noise**2
            marked = 1.0 / (self.channels.marker_noise_m**2 * self.channels.geometry[0, 0])
            foot = (marked * foot + trusted * self.measured[2] / s) / (marked + trusted)
        return self.everywhere(foot)

    def everywhere(self, spectrum: np.ndarray) -> np.ndarray:
        """A spectrum in the band (m,) as one of all frequencies."""
        whole = np.zeros(self.channels.foot.size // 2 + 1, dtype=complex)
        whole[self.model.bins] = spectrum
        return whole

    def residuals(self, point: Point) -> Residuals:
        """Residuals at a point, with derivatives."""
        predicted, c = self.model.spectra(point), len(self.measured)
        w, size, own = self._eliminated(point, predicted.response, predicted.independent)
        columns = _project(w @ predicted.independent_slopes[:, :c], own.direction)
        by_noise = np.zeros_like(columns)
        acts = [name in OF_RESPONSE for name in point.names]
        of_response = _project(w @ predicted.response_slopes[acts, :c], own.direction)
        columns[acts] += of_response * own.foot
        by_noise[acts] = of_response / np.sqrt(size)
        return Residuals(**vars(own), columns=columns, by_noise=by_noise)

    def with_forces(self, linear: Residuals, point: Point) -> Residuals:
        """Residuals at a point that differs in phi_h only, where C and B_s, the last parameters, are 0."""
        c, w = len(self.measured), self.whitening()
        slopes = self.model.spectra(point, FORCES).independent_slopes[:, :c]
        columns = linear.columns.copy()
        columns[-len(FORCES) :] = _project(w @ slopes, linear.direction)
        return replace(linear, point=point, columns=columns)

    def eliminated(self, point: Point) -> Eliminated:
        """Residuals at a point, without derivatives."""
        return self._eliminated(point, *self.model.predicted(point))[-1]

    def _eliminated(
        self, point: Point, response: np.ndarray, independent: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray, Eliminated]:
        """W, |W h|^2 and the residuals."""
        c, w = len(self.measured), self.whitening()
        # W is the same at all frequencies
        h, z = w @ response[:c], w @ (self.measured - independent[:c])
        size = np.sum(np.abs(h) ** 2, axis=0)
        direction = h / np.sqrt(size)
        foot = np.sum(h.conj() * z, axis=0) / size
        return w, size, Eliminated(point, foot, _project(z, direction), direction)

    def update_motion(self, current: Eliminated) -> None:
        """Take the predicted motion for the terms that are not linear.

        Below the band it is measured; above, the linear joint follows the log.
        """
        v, model = current.point.values, self.model
        response, independent = model.predicted(current.point)
        late = np.exp(-model.s * v["delay"])
        angle = self.everywhere((response[1] * current.foot + independent[1]) / late)
        foot = self.everywhere(current.foot)
        low, high = model.bins[[0, -1]] + [0, 1]
        angle[:low] = self._angle[:low]
        if self._log is not None:
            s = 2j * np.pi * np.arange(high, angle.size) * self.channels.rate_hz / self.channels.foot.size
            foot[high:] = (self._log[high:] - v["jump"]) * np.exp(s * v["lag"]) / (v["gain"] * s)
            angle[high:] = foot[high:] * model.swing_per_foot(v, s)
        model.observe(Motion.of(self.channels, angle, foot))

    def update_log_noise(self, current: Eliminated) -> None:
        """One scoring step of the restricted likelihood for sigma_v."""
        if self.log_noise is None:
            return
        share = 1.0 - np.abs(current.direction[2]) ** 2
        step = (np.sum(np.abs(current.whitened[2]) ** 2) - share.sum()) / np.sum(share**2)
        self.log_noise = max(self.log_noise * float(np.exp(0.5 * np.clip(step, -1.5, 1.5))), self._least)


def maximise_likelihood(
    time: Annotated[np.ndarray, "(n,)", "s"],
    markers: DummyMarkers,
    belt_velocity: np.ndarray | None,
    leg: Leg,
    at_rest: np.ndarray,
    *,
    softening: bool = True,
) -> LikelihoodFit:
    """Maximise the likelihood of one trial.

    The result is a function of the geometry: with another ``leg``, other offsets in ``markers`` or other
    instants of one channel, it returns the estimates for that geometry (0.05 s for a trial of 70 s).

    time: instants, evenly spaced.
    markers: markers of foot and leg at these instants, not filtered.
    belt_velocity: logged velocity of the belt, not filtered (m/s); None without a log of independent noise.
    at_rest: samples at rest.
    softening: whether the joint may soften; if not, K and B are the same at all amplitudes.
    """
    channels = make_channels(time, markers, belt_velocity, at_rest)
    likelihood = _Likelihood(channels, LegModel(channels, leg))
    linear = _gauss_newton(likelihood, _start(likelihood), predicted=not softening)
    return _fit_softening(likelihood, linear) if softening else linear


def _start(likelihood: _Likelihood) -> Point:
    """J, B, K by iterated linear regression of the equation of motion (Sanathanan and Koerner 1963)."""
    s, model = likelihood.model.s, likelihood.model
    foot, angle = likelihood.first_foot()[model.bins], likelihood.measured[1]
    columns = np.array([s**2 * angle, s * angle, angle, np.ones_like(s), s])
    target = -model.coupling * s**2 * foot
    weight = 1.0 / (np.abs(s) ** 2 + (2.0 * np.pi) ** 2)
    for _ in range(15):
        stacked = np.concatenate([(columns * weight).real, (columns * weight).imag], axis=1).T
        aim = np.concatenate([(target * weight).real, (target * weight).imag])
        scale = np.linalg.norm(stacked, axis=0)
        solution = np.linalg.lstsq(stacked / scale, aim, rcond=None)[0] / scale
        solution[:3] = np.where(solution[:3] > 0.0, solution[:3], [model.leg_inertia, 1e-4, 1e-3])
        inertia, damping, elastic = solution[:3]
        weight = 1.0 / np.abs(inertia * s**2 + damping * s + elastic)
    names = tuple(
        n for n in LINEAR if likelihood.log_noise is not None or n not in ("lag", "gain", "jump", "drift")
    )
    weight_moment = model.weight * float(np.cos(likelihood.channels.theta_0_rad))
    values = dict.fromkeys(LINEAR, 0.0) | {"gain": 1.0, "J": inertia, "B": damping}
    values["K"] = elastic + weight_moment
    return Point(names, {name: float(value) for name, value in values.items()})


def _gauss_newton(
    likelihood: _Likelihood,
    point: Point,
    limits: tuple[float, float] | None = None,
    *,
    predicted: bool = True,
) -> LikelihoodFit:
    """Gauss-Newton steps, halved where the likelihood falls.

    limits: bounds of phi_h (rad).
    predicted: whether the terms that are not linear take the predicted motion, not the measured one.
    """
    own = likelihood.eliminated(point)
    for count in range(_STEPS):
        if count < _NOISE_STEPS:
            likelihood.update_log_noise(own)
            if predicted:
                likelihood.update_motion(own)
        current = likelihood.residuals(point)
        step, errors = _step_and_errors(current)
        limit = current.deviance * (1.0 + 1e-12)
        for _ in range(12):
            trial = _within(point.moved(step), limits)
            if _is_feasible(likelihood, trial):
                own = likelihood.eliminated(trial)
                if own.deviance <= limit:
                    break
            step = 0.5 * step
        else:
            break
        change, gained = np.abs(step) / errors, current.deviance - own.deviance
        point = trial
        ended = count > _NOISE_STEPS and gained < 1e-3
        if count > 3 and (change.max() < 1e-3 or ended):
            break
    else:
        raise undetermined("no convergence")
    current = likelihood.residuals(point)
    covariance = _covariance(current) + _by_offset(likelihood, current)
    return LikelihoodFit(
        point, covariance, current, likelihood.log_noise, likelihood.channels, likelihood.model
    )


def _step_and_errors(current: Residuals) -> tuple[np.ndarray, np.ndarray]:
    """Gauss-Newton step of the parameters, and their standard errors."""
    information = current.information
    scale = np.sqrt(np.diag(information))
    if not (np.isfinite(information).all() and (scale > 0.0).all()):
        raise undetermined("an angle that does not depend on the foot's motion")
    normal = information / np.outer(scale, scale)
    if np.linalg.cond(normal) > 1e12:
        raise undetermined("sensitivities that depend on each other")
    inverse = np.linalg.inv(normal)
    return inverse @ (current.gradient / scale) / scale, np.sqrt(np.diag(inverse)) / scale


def _within(point: Point, limits: tuple[float, float] | None) -> Point:
    if limits is None or "log_phi_h" not in point.values:
        return point
    half = float(np.clip(point.values["log_phi_h"], *np.log(limits)))
    return replace(point, values=point.values | {"log_phi_h": half})


def _is_feasible(likelihood: _Likelihood, point: Point) -> bool:
    """J > 0, K above the critical stiffness, and a response that does not outgrow the trial."""
    v, leg_inertia = point.values, likelihood.model.leg_inertia
    elastic = v["K"] - likelihood.model.weight * np.cos(likelihood.channels.theta_0_rad)
    longest = likelihood.channels.foot.size / likelihood.channels.rate_hz
    grows = -v["B"] / max(2.0 * v["J"], 1e-9) * longest
    return 0.05 * leg_inertia < v["J"] < 50.0 * leg_inertia and elastic > 0.0 and grows < 20.0


def _covariance(current: Residuals) -> np.ndarray:
    """F^-1 F_0 F^-1, shape (p, p)."""
    return _sandwich(current.information - current.excess, current.information)


def _sandwich(normal: np.ndarray, information: np.ndarray) -> np.ndarray:
    """Covariance for F and F_0, shape (p, p)."""
    scale = np.sqrt(np.diag(information))
    normal = normal / np.outer(scale, scale)
    if not np.isfinite(normal).all() or np.linalg.cond(normal) > 1e12:
        raise undetermined("sensitivities that depend on each other")
    inverse = np.linalg.inv(normal) / np.outer(scale, scale)
    covariance = inverse @ information @ inverse
    if not (np.diag(covariance) > 0.0).all():
        raise undetermined("sensitivities that depend on each other")
    return covariance


def _by_offset(likelihood: _Likelihood, current: Residuals, normal: np.ndarray | None = None) -> np.ndarray:
    """Contribution of the error of the joint's position to the covariance, shape (p, p)."""
    channels = likelihood.channels
    shift = np.zeros_like(likelihood.measured)
    shift[:2] = channels.joint_offset_error_m * np.outer(channels.offset_slopes, likelihood.measured[1])
    shift = likelihood.whitening() @ shift
    shift = shift - current.direction * np.sum(current.direction.conj() * shift, axis=0)
    step = _step_by(current, current.along(shift), normal)
    return np.outer(step, step)


def _step_by(current: Residuals, gradient: np.ndarray, normal: np.ndarray | None = None) -> np.ndarray:
    """Shift F^-1 g of the maximum by a gradient g, shape (p,) (units of the parameters)."""
    scale = np.sqrt(np.diag(current.information))
    normal = (current.information - current.excess if normal is None else normal) / np.outer(scale, scale)
    return np.linalg.solve(normal, gradient / scale) / scale


def _fit_softening(likelihood: _Likelihood, linear: LikelihoodFit) -> LikelihoodFit:
    """Fit of a joint that softens, from one step for the best of several phi_h."""
    largest = float(np.percentile(np.abs(likelihood.model.motion.phi), 99.9))
    tried, current = [], None
    for share in _HALVES:
        point = _with_softening(likelihood, linear, share * largest)
        current = likelihood.with_forces(current, point) if current else likelihood.residuals(point)
        step = _step_and_errors(current)[0]
        decrease = float(current.gradient @ step) - (np.log(share) / _HALF_ERROR) ** 2
        tried.append((decrease, point, point.moved(step)))
    decrease, point, moved = max(tried, key=lambda each: each[0])
    # without softening phi_h has no meaning
    fixed = point if decrease > SOFTENS else _with_softening(likelihood, linear, largest)
    if decrease > SOFTENS:
        priors = {
            "b_0": (point.values["b_0"], _REST_ERROR),
            "log_phi_h": (float(np.log(largest)), _HALF_ERROR),
        }
        start = moved if _is_feasible(likelihood, moved) else point
        start = Point((*start.names, *priors), start.values, priors)
        motion, log_noise = likelihood.model.motion, likelihood.log_noise
        try:
            return _gauss_newton(likelihood, start, (_HALF_RANGE[0] * largest, _HALF_RANGE[1] * largest))
        except InputError:  # no law of this form fits
            likelihood.model.observe(motion)
            likelihood.log_noise = log_noise
    return _gauss_newton(likelihood, fixed)


def _with_softening(likelihood: _Likelihood, linear: LikelihoodFit, half: float) -> Point:
    """The linear joint with C and B_s of 0 for phi_h (rad)."""
    rest = likelihood.model.bending_at_rest(linear.value("K"))
    added = {"C": 0.0, "B_s": 0.0, "log_phi_h": float(np.log(half)), "b_0": rest}
    return Point((*linear.point.names, *FORCES), linear.point.values | added)


# ---- without another fit ------------------------------------------------------------------------


def step_to(fit: LikelihoodFit, channels: Channels) -> Annotated[np.ndarray, "(p,)"]:
    """Shift of the maximum by slightly different channels, to first order: one step, no new fit.

    fit: the maximum; its noise levels are kept.
    channels: the same trial, for example with other instants of one marker.
    Returns: change of the fitted parameters (units in `tepsipe.identification.likelihood.likelihood`).
    """
    channels = replace(channels, marker_noise_m=fit.channels.marker_noise_m)
    likelihood = _Likelihood(channels, LegModel(channels, fit.model.leg))
    likelihood.log_noise = fit.log_noise_m_per_s
    likelihood.model.observe(fit.model.motion)
    likelihood.update_motion(likelihood.eliminated(fit.point))
    return _step_by(fit.residuals, likelihood.residuals(fit.point).gradient - fit.residuals.gradient)


@dataclass(frozen=True)
class ExpectedFit:
    """Expected fit to signals with noise."""

    fit: LikelihoodFit
    """At the true parameters, with the expected covariance of the fitted ones."""
    bound: Annotated[np.ndarray, "(p, p)"]
    """Cramer-Rao bound of this covariance: F^-1, where noise in Y adds nothing."""
    by_foot: Annotated[np.ndarray, "(p, p, m)"]
    """Information per |Y|^2 at every frequency, F without what does not depend on the foot (1 over the
    units of the parameters, over (m times samples)²)."""


def expected_fit(
    exact: LikelihoodFit, marker_noise_m: float, log_noise_m_per_s: float, *, softening: bool
) -> ExpectedFit:
    """Expected covariance of fits to noisy signals of a linear joint, from a fit to exact ones.

    exact: fit of a linear joint to signals without noise, and with a log.
    marker_noise_m, log_noise_m_per_s: noise that is to come, of a marker in one direction (m) and of a
    sample of the log (m/s).
    softening: whether the fits will allow a joint that softens.
    Returns: covariance, its bound and the information per frequency (units of the parameters).
    """
    known = exact.channels
    share = marker_noise_m / known.marker_noise_m
    offset_error = known.joint_offset_error_m * share
    channels = replace(known, marker_noise_m=marker_noise_m, joint_offset_error_m=offset_error)
    likelihood = _Likelihood(channels, exact.model)
    likelihood.log_noise = log_noise_m_per_s
    point = exact.point
    if softening:
        largest = float(np.percentile(np.abs(exact.model.motion.phi), 99.9))
        point = _with_softening(likelihood, exact, largest)
    current = likelihood.residuals(point)
    # without noise in Y, F_0 as computed is F
    normal, added = current.information, current.excess
    covariance = _sandwich(normal, normal + added) + _by_offset(likelihood, current, normal)
    bound = _sandwich(normal, normal)
    size = np.sum(
        np.abs(likelihood.whitening() @ exact.model.spectra(point).response[: len(likelihood.measured)]) ** 2,
        0,
    )
    scaled = current.by_noise * np.sqrt(size)
    by_foot = 2.0 * np.einsum("acm,bcm->abm", scaled.conj(), scaled).real
    fit = LikelihoodFit(point, covariance, current, log_noise_m_per_s, channels, exact.model)
    return ExpectedFit(fit, bound, by_foot)
