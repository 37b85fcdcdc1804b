"""Output error: joint impedance from the motion of the foot and the angle of the leg, over the whole trial.

The equation of motion of the leg on a moving foot needs neither torque nor force plate (p = m r):

    J theta'' = m g r sin(theta) - p y'' cos(theta) - B theta' - K (theta - theta_ref)

About the angle at rest theta_0, with k_g = m g r, and with the non-linear terms on the right:

    J phi'' + B phi' + (K - k_g) phi = u,    phi = theta - theta_0
    u = -p y'' cos(theta) + k_g [sin(theta) - sin(theta_0) - (theta - theta_0)]

The simulated angle is theta_0 + phi(t - delta). The parameters x = (J, B, K, theta_0, delta) minimise the
error e between measured and simulated angle; the inertia of the joint is I = J - I_l - m r^2. The
measured theta is used in the non-linear terms. y'' is the second derivative of the cubic spline through the
positions of the foot, which is linear between samples, so the simulation is exact for that spline.

The position of the foot is measured with noise, which enters u and biases least squares where perturbations
are small. The logged velocity v of the belt measures the same motion with independent noise. The
instrumental-variable (IV) estimate therefore makes e(t) orthogonal to instruments Z instead of its own
sensitivities S = d phi / d x. Z are the sensitivities of an angle that is simulated from v' instead of y''
with the least-squares parameters:

    sum Z(t)' e(t) = 0,    step of x = (sum Z' S)^-1 sum Z' e

The noise of the markers is independent of the drive's noise, so this removes the bias. An error of scale,
a delay or an offset of v changes Z only and causes no bias.

Errors are correlated in time. Let c_i be the sum of Z' e over one interval, from the onset of a
perturbation to the next. Then x_i = x + n (sum Z' S)^-1 c_i are n contributions whose mean is x, and
resampling them with replacement is the bootstrap over intervals to first order. It assumes independent
intervals: they must be longer than 2 J / B, the time for which the leg rings.

A joint that softens with bending and loses more as it softens has two more parameters, C and B_s:

    tau = K phi - C q phi + (B + B_s q) phi',    q = phi^2 / (phi^2 + phi_h^2)

They enter u with the measured phi, so the equation stays linear in them, and K and B hold for small
movements. phi_h is chosen among several by the remaining error. The joint is taken as linear unless C differs
from 0 by more than `SOFTENS` standard errors over the intervals.

Symbols: J inertia of the leg about the ankle and of the joint (kg·m²), B (N·m·s/rad), K (N·m/rad), m, r, I_l,
g as in `inverse_dynamics`; y position of the foot (m); theta leg angle, positive towards +y (rad);
theta_ref neutral angle of the joint (rad); delta delay of the angle after the foot (s).
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated

import numpy as np
import scipy

from tepsipe.errors import InputError
from tepsipe.identification.regression.windows import WindowedFits, regress_perturbations, undetermined
from tepsipe.mechanics.impedance_model import impedance_torque, simulate_angle
from tepsipe.mechanics.inverse_dynamics import Leg
from tepsipe.mechanics.segment_kinematics import SegmentMotion
from tepsipe.signals.differentiation import derivative
from tepsipe.signals.perturbations import Perturbation
from tepsipe.signals.time_alignment import LONGEST_S
from tepsipe.statistics.goodness_of_fit import explained
from tepsipe.statistics.least_squares import LinearFit

# bounds of the angular frequency (rad/s) and damping ratio of the search
_LOWEST_RAD_PER_S = 0.6
_LARGEST_RATIO = 3.0
# steps with updated instruments; they are then fixed, so that the solution is unique
_RENEWED = 2
# C over its standard error above which a joint softens: the larger of two noises in 10^4 trials
SOFTENS = 5.0
# tried values of phi_h over the largest bending
_HALVES = (0.35, 0.6, 1.0, 1.7, 3.0)


@dataclass(frozen=True)
class OutputError(WindowedFits):
    """I, B, K of the simulated angle.

    The parameters (N·m·s²/rad, N·m·s/rad, N·m/rad) are contributions of the intervals from onset to onset,
    whose mean is the estimate; torque (N·m) and VAF (%) follow pathway ``leg``, for comparison only.
    """

    angle: Annotated[np.ndarray, "(n,)", "rad"]
    simulated: Annotated[np.ndarray, "(n,)", "rad"]
    """Measured and simulated theta."""
    theta_0_rad: float
    delay_s: float
    """theta_0 (rad) and delta (s)."""
    softening: tuple[float, float, float] | None = None
    """C (N·m/rad), B_s (N·m·s/rad) and phi_h (rad) of a joint that softens; None of a linear one."""

    @property
    def vaf_angle(self) -> float:
        """VAF (%) of theta - theta_0 over the whole trial."""
        return explained(self.angle - self.theta_0_rad, self.simulated - self.theta_0_rad)


def simulate_leg(
    x: Annotated[np.ndarray, "(5,)"],
    leg: Leg,
    time: Annotated[np.ndarray, "(n,)", "s"],
    theta: Annotated[np.ndarray, "(n,)", "rad"],
    y_dd: np.ndarray,
    half_rad: float | None = None,
) -> tuple[np.ndarray, np.ndarray]:
    """Angle of the leg on a moving foot, and its sensitivities.

    x: J (kg·m²), B (N·m·s/rad), K (N·m/rad), theta_0 (rad), delta (s), and of a joint that softens C
    (N·m/rad) and B_s (N·m·s/rad).
    time: instants, evenly spaced.
    theta: measured angle, for the non-linear terms.
    y_dd: acceleration of the foot (m/s²), of the cubic spline through its positions.
    half_rad: phi_h of a joint that softens.

    Returns:
        angle: theta (rad).
        sensitivities: derivatives of it with respect to ``x`` (rad over the units of ``x``). Shape (n, 5).
    """
    p = leg.mass_kg * leg.com_m
    rest, delay = x[3:5]
    motion, rate = _motion(x, leg), _rate_hz(time)
    beyond = np.sin(theta) - np.sin(rest) - (theta - rest)
    forces = []
    if x.size > 5:
        forces = _softening_forces(theta - rest, derivative(time, theta - rest), half_rad)
    push = p * leg.gravity_m_per_s2 * beyond - p * y_dd * np.cos(theta)
    phi = simulate_angle(motion, push + sum(c * f for c, f in zip(x[5:], forces, strict=True)), rate)
    phi_d = derivative(time, phi)
    phi_dd = derivative(time, phi_d)
    # the same equation, differentiated with respect to J, B, K, C and B_s
    forces = [-phi_dd, -phi_d, -phi, *forces]
    responses = [phi, phi_d, *(simulate_angle(motion, force, rate) for force in forces)]
    late = _delayed(time, responses, delay)
    sensitivities = np.column_stack([late[:, 2:5], np.ones(time.size), -late[:, 1], late[:, 5:]])
    return rest + late[:, 0], sensitivities


def _motion(x: np.ndarray, leg: Leg) -> np.ndarray:
    """J, B and K - k_g of the equation of motion, shape (3,)."""
    return np.array([x[0], x[1], x[2] - leg.mass_kg * leg.com_m * leg.gravity_m_per_s2])


def _rate_hz(time: np.ndarray) -> float:
    return (time.size - 1) / (time[-1] - time[0])


def _delayed(time: np.ndarray, responses: list[np.ndarray], delay: float) -> np.ndarray:
    """Signals of evenly spaced instants a delay (s) later, one per column; ends are held."""
    at = np.clip(time - delay, time[0], time[-1])
    return scipy.interpolate.CubicSpline(time, np.column_stack(responses))(at)


def _softening_forces(phi: np.ndarray, phi_d: np.ndarray, half_rad: float) -> list[np.ndarray]:
    """Terms that C and B_s add to u, per unit: q phi (rad) and -q phi' (rad/s)."""
    share = phi**2 / (phi**2 + half_rad**2)
    return [share * phi, -share * phi_d]


def match_angle(
    motion: SegmentMotion,
    foot_position: np.ndarray,
    belt_velocity: np.ndarray,
    leg: Leg,
    perturbations: list[Perturbation],
    at_rest: np.ndarray,
    source: str = "instruments",
) -> OutputError:
    """Fit I, B, K, theta_0 and delta to the measured angle over the whole trial.

    foot_position: position of the foot along the belt (m), filtered like the leg's motion.
    belt_velocity: logged velocity of the belt (m/s), filtered like the leg's motion.
    leg: its mass, centre of mass and inertia.
    perturbations: windows (samples): their starts delimit the intervals, and the VAF of the torque is
    evaluated in them.
    at_rest: samples at rest.
    source: {"instruments", "markers", "belt"}: Instrumental-variable estimate (motion of the foot, belt
    motion as instrument), or least squares with the motion of the markers or of the belt alone.
    """
    time = motion.time
    belt_position = scipy.interpolate.CubicSpline(time, belt_velocity).antiderivative()(time)
    accelerations = {
        name: scipy.interpolate.CubicSpline(time, position)(time, 2)
        for name, position in (("markers", foot_position), ("belt", belt_position))
    }
    for name, acceleration in accelerations.items():
        if not np.ptp(acceleration) > 0.0:
            raise InputError(
                f"expected {'a foot' if name == 'markers' else 'a belt'} that moves, found one that stands "
                "still: check the belt-fixed markers, and that the belt was perturbed"
            )
    used = accelerations["belt" if source == "belt" else "markers"]
    task = _Task(motion, leg, accelerations["belt"], used, source == "instruments", perturbations)
    x, low, high = _start(motion, leg, at_rest)

    @lru_cache(maxsize=1)  # the search asks for the sensitivities where it has just asked for the angle
    def simulated(*x: float) -> tuple[np.ndarray, np.ndarray]:
        # the belt velocity gives a less noisy acceleration, and so a better starting point
        return simulate_leg(np.array(x), leg, time, motion.theta, accelerations["belt"])

    solution = scipy.optimize.least_squares(
        lambda x: simulated(*x)[0] - motion.theta,
        x,
        jac=lambda x: simulated(*x)[1],
        bounds=(low, high),
        x_scale=[0.1 * x[0], x[1], 0.1 * x[2], 1e-3, 1e-3],
    )
    fit = _solve(task, solution.x, low, high)
    softer = _softening_solution(task, fit.x, low, high)
    if softer is not None:
        fit = softer
    angle = simulate_leg(fit.x, leg, time, motion.theta, used, fit.half_rad)[0]
    each = fit.each[:, :3].copy()
    each[:, 0] -= leg.inertia_kgm2 + leg.mass_kg * leg.com_m**2
    regression = intervals_as_windows(each, fit.conditioning, motion, leg, perturbations, at_rest)
    return OutputError(
        **vars(regression),
        angle=motion.theta,
        simulated=angle,
        theta_0_rad=float(fit.x[3]),
        delay_s=float(fit.x[4]),
        softening=None if fit.half_rad is None else (*map(float, fit.x[5:]), fit.half_rad),
    )


@dataclass(frozen=True)
class _Task:
    """Data of the fit: motion of the leg (rad), acceleration of the belt and of the foot in use (m/s²),
    whether the belt is the instrument, and the perturbations (samples).
    """

    motion: SegmentMotion
    leg: Leg
    belt: np.ndarray
    used: np.ndarray
    instruments: bool
    perturbations: list[Perturbation]

    def simulate(self, x: np.ndarray, y_dd: np.ndarray, half_rad: float | None):
        """Angle (rad) and sensitivities for an acceleration of the foot (m/s²)."""
        return simulate_leg(x, self.leg, self.motion.time, self.motion.theta, y_dd, half_rad)


@dataclass(frozen=True)
class _Solution:
    """Parameters, their contributions by interval, conditioning of the last step, phi_h (rad)."""

    x: np.ndarray
    each: np.ndarray
    conditioning: float
    half_rad: float | None


def _solve(task: _Task, x: np.ndarray, low, high, half_rad: float | None = None) -> _Solution:
    """Make the error orthogonal to the instruments, or to its own sensitivities."""
    perturbations = task.perturbations
    for count in range(30):
        angle, sensitivities = task.simulate(x, task.used, half_rad)
        if not task.instruments:
            instruments = sensitivities
        elif count < _RENEWED:
            instruments = task.simulate(x, task.belt, half_rad)[1]
        scale = np.linalg.norm(instruments, axis=0)
        normal = (instruments / scale).T @ (sensitivities / scale)
        if not np.isfinite(normal).all() or np.linalg.cond(normal) > 1e10:
            raise undetermined("sensitivities that depend on each other")
        error = (instruments / scale) * (task.motion.theta - angle)[:, None]
        steps = np.linalg.solve(normal, sums_by_interval(error, perturbations).T).T / scale
        step = steps.sum(axis=0)
        x = x + step
        if (x[:5] <= low).any() or (x[:5] >= high).any():
            raise undetermined("parameters at the bounds of the search")
        if np.abs(step[:5] / [x[0], x[1], x[2], 1.0, 1e-2]).max() < 1e-8:
            break
    else:
        raise undetermined("no convergence")
    each = x + len(perturbations) * (steps - step / len(perturbations))
    return _Solution(x, each, float(np.linalg.cond(normal)), half_rad)


def _softening_solution(task: _Task, x: np.ndarray, low, high) -> _Solution | None:
    """Solution for a joint that softens; None without significant softening."""
    if len(task.perturbations) < 3:
        return None
    largest = float(np.abs(task.motion.theta - x[3]).max())
    angle, linear = task.simulate(x, task.belt, None)
    error, best = task.motion.theta - angle, None
    time, phi = task.motion.time, task.motion.theta - x[3]
    phi_d, motion, rate = derivative(time, phi), _motion(x, task.leg), _rate_hz(time)
    for half in (share * largest for share in _HALVES):
        # one Gauss-Newton step shows which phi_h leaves the smallest error
        softer = [simulate_angle(motion, force, rate) for force in _softening_forces(phi, phi_d, half)]
        columns = np.column_stack([linear, _delayed(time, softer, x[4])])
        scale = np.linalg.norm(columns, axis=0)
        step, *_ = np.linalg.lstsq(columns / scale, error, rcond=None)
        cost = float(np.sum((error - columns @ (step / scale)) ** 2))
        if best is None or cost < best[0]:
            best = (cost, half, step / scale)
    _, half, step = best
    try:
        solution = _solve(task, np.append(x, [0.0, 0.0]) + step, low, high, half)
    except InputError:
        return None
    softening = solution.each[:, 5]
    error = float(softening.std(ddof=1)) / np.sqrt(softening.size)
    return solution if float(softening.mean()) > SOFTENS * error else None


def _start(motion: SegmentMotion, leg: Leg, at_rest: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Starting values of x, from the strongest frequency of the angle, and bounds."""
    time, rest = motion.time, float(motion.theta[at_rest].mean())
    inertia = leg.inertia_kgm2 + leg.mass_kg * leg.com_m**2
    critical_stiffness = leg.mass_kg * leg.com_m * leg.gravity_m_per_s2
    spectrum = np.abs(np.fft.rfft((motion.theta - rest) * np.hanning(time.size)))
    omega = 2.0 * np.pi * np.fft.rfftfreq(time.size, (time[-1] - time[0]) / (time.size - 1))
    spectrum[omega < _LOWEST_RAD_PER_S] = 0.0
    fastest = omega[-1]
    strongest = min(max(float(omega[int(np.argmax(spectrum))]), 2.0 * _LOWEST_RAD_PER_S), 0.5 * fastest)
    x = [inertia, 0.1 * inertia * strongest, critical_stiffness + inertia * strongest**2, rest, 0.0]
    low = [
        0.1 * inertia,
        0.0,
        critical_stiffness + 0.1 * inertia * _LOWEST_RAD_PER_S**2,
        rest - 1.0,
        -LONGEST_S,
    ]
    largest = [10.0 * inertia, _LARGEST_RATIO * 20.0 * inertia * fastest, 10.0 * inertia * fastest**2]
    return np.array(x), np.array(low), np.array([*largest, rest + 1.0, LONGEST_S])


def sums_by_interval(
    products: Annotated[np.ndarray, "(n, p)"], perturbations: list[Perturbation]
) -> Annotated[np.ndarray, "(intervals, p)"]:
    """Sums over the intervals from onset to onset; first and last reach the ends of the trial.

    products: products to be summed.
    perturbations: their starts delimit the intervals (samples).
    Returns: sums (units of ``products``).
    """
    starts = [0, *(p.start for p in perturbations[1:])]
    return np.add.reduceat(products, starts, axis=0)


def intervals_as_windows(
    each: Annotated[np.ndarray, "(intervals, 3)"],
    conditioning: float,
    motion: SegmentMotion,
    leg: Leg,
    perturbations: list[Perturbation],
    at_rest: np.ndarray,
) -> WindowedFits:
    """Contributions of the intervals in the place of regressions, and the torque that their mean predicts.

    conditioning: conditioning of the fit.
    motion, leg, perturbations, at_rest: as for `match_angle`.
    Returns: torque of pathway ``leg`` and its prediction.
    """
    regression = regress_perturbations(motion, leg, perturbations, at_rest, "leg")
    theta_dd, theta_d, theta = regression.regressors.T
    predicted = impedance_torque(each.mean(axis=0), theta, theta_d, theta_dd)
    residual, unknown = regression.torque - predicted, np.full((3, 3), np.nan)
    fits = [
        LinearFit(values, residual[p.start : p.stop], unknown, conditioning)
        for values, p in zip(each, perturbations, strict=True)
    ]
    return WindowedFits(
        perturbations,
        fits,
        regression.torque,
        predicted,
        regression.regressors,
        regression.theta_rest_rad,
        regression.torque_rest_Nm,
    )
