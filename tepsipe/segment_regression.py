"""TEP-SIPE: I, B, K by linear regression over every perturbation (thesis section 3-1-2, eq 3-9).

    tau(t) = I theta'' + B theta' + K (theta - theta_ref)      over the samples of one perturbation

As printed, theta_ref is the angle at rest. But at rest the joint already carries the weight of a
leg that does not stand quite upright, tau_rest = K (theta_rest - theta_ref), so the printed
regression is biased as soon as theta_rest is not 0. The recommended regression refers angle *and*
torque to rest: tau - tau_rest = I theta'' + B theta' + K (theta - theta_rest).
"""

from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline

from tepsipe.errors import InputError
from tepsipe.filters import butterworth_lowpass
from tepsipe.inverse_dynamics import TORQUE_PATHWAYS, Leg
from tepsipe.metrics import LinearFit, least_squares_line, vaf
from tepsipe.perturbations import Perturbation, detect_perturbations
from tepsipe.rigid_segments import derivative, fit_rigid_segment
from tepsipe.second_order import PARAMETERS, impedance_torque

ESTIMATORS = ("segment-regression-printed", "segment-regression")


@dataclass(frozen=True)
class LegMarkers:
    """Where the leg's markers sit and what else the kinematics needs.

    Attributes
    ----------
    labels : tuple of str
        Markers on the leg.
    layout_m : ndarray, shape (k, 2)
        In front of the leg's axis, and along it from the ankle (m).
    """

    labels: tuple[str, ...]
    layout_m: np.ndarray


@dataclass(frozen=True)
class LegMotion:
    """Motion of the leg during a trial.

    Attributes
    ----------
    time : ndarray, shape (n,)
        Instants (s).
    theta, theta_d, theta_dd : ndarray, shape (n,)
        Leg angle (rad), its rate (rad/s) and acceleration (rad/s2).
    y_dd, z_dd : ndarray, shape (n,)
        Acceleration of the leg's centre of mass (m/s2).
    misfit_m : float
        Root mean square distance between markers and the rigid leg (m).
    """

    time: np.ndarray
    theta: np.ndarray
    theta_d: np.ndarray
    theta_dd: np.ndarray
    y_dd: np.ndarray
    z_dd: np.ndarray
    misfit_m: float


def leg_motion(
    time: np.ndarray,
    positions: np.ndarray,
    labels: list[str],
    markers: LegMarkers,
    com_m: float,
    rate_hz: float,
    cutoff_hz: float,
    order: int,
) -> LegMotion:
    """Filter the markers, fit the rigid leg and differentiate.

    Parameters
    ----------
    time : ndarray, shape (n,)
        Instants (s).
    positions : ndarray, shape (n, all markers, 3)
        Marker positions x, y, z (m).
    labels : list of str
        Names of all markers.
    markers : LegMarkers
        Which of them are on the leg, and where (m).
    com_m : float
        Distance of the leg's centre of mass from the ankle (m).
    rate_hz, cutoff_hz : float
        Sampling rate and cutoff of the low-pass filter (Hz).
    order : int
        Order of the filter, both passes together (-).

    Returns
    -------
    LegMotion
        Angle and accelerations (rad, m, s).

    Raises
    ------
    InputError
        If a marker of the leg is not among ``labels``, or the markers do not move as one body.
    """
    filtered = butterworth_lowpass(leg_positions(positions, labels, markers), rate_hz, cutoff_hz, order)
    return motion_of_markers(time, filtered, markers, com_m)


def leg_positions(positions: np.ndarray, labels: list[str], markers: LegMarkers) -> np.ndarray:
    """y, z (m) of the leg's markers, shape (n, k, 2), out of all markers, shape (n, all markers, 3).

    Raises
    ------
    InputError
        If a marker of the leg is not among ``labels``.
    """
    missing = [label for label in markers.labels if label not in labels]
    if missing:
        raise InputError(
            f"expected a marker named {missing[0]!r} on the leg, found {', '.join(labels)}: name the "
            "leg's markers in the configuration"
        )
    return positions[:, [labels.index(label) for label in markers.labels], 1:]


def motion_of_markers(time: np.ndarray, filtered: np.ndarray, markers: LegMarkers, com_m: float) -> LegMotion:
    """Fit the rigid leg to markers that are filtered already, and differentiate.

    Parameters
    ----------
    time : ndarray, shape (n,)
        Instants (s).
    filtered : ndarray, shape (n, k, 2)
        y, z of the leg's markers (m).
    markers : LegMarkers
        Where they sit (m).
    com_m : float
        Distance of the leg's centre of mass from the ankle (m).

    Returns
    -------
    LegMotion
        Angle and accelerations (rad, m, s).

    Raises
    ------
    InputError
        If the markers do not move as one body.
    """
    pose = fit_rigid_segment(filtered, markers.layout_m, np.array([0.0, com_m]))
    if pose.misfit_m > 0.01:
        raise InputError(
            f"expected the leg's markers to move as one rigid body, found them {1e3 * pose.misfit_m:.3g} "
            "mm from it on average: check the markers' layout and order in the configuration"
        )
    theta_d = derivative(time, pose.angle)
    velocity = derivative(time, pose.point)
    acceleration = derivative(time, velocity)
    return LegMotion(
        time=time,
        theta=pose.angle,
        theta_d=theta_d,
        theta_dd=derivative(time, theta_d),
        y_dd=acceleration[:, 0],
        z_dd=acceleration[:, 1],
        misfit_m=pose.misfit_m,
    )


@dataclass(frozen=True)
class WindowOptions:
    """Where to look for perturbations and rest.

    Attributes
    ----------
    rest_before_s, rest_after_s : float
        Unperturbed time at the trial's start and end (s).
    rest_margin_s : float
        Part of it that is left out next to perturbations and to the trial's ends (s).
    threshold_fraction : float
        Threshold as a part of the perturbations' peak speed (-).
    signal_to_noise : float
        The threshold must exceed the noise at rest this many times (-).
    merge_s : float
        Runs closer than this belong to one perturbation (s).
    """

    rest_before_s: float
    rest_after_s: float
    rest_margin_s: float
    threshold_fraction: float
    signal_to_noise: float
    merge_s: float


def rest_samples(time: np.ndarray, options: WindowOptions) -> np.ndarray:
    """True for the samples of the first and last rest, shape (n,), from instants in s.

    Raises
    ------
    InputError
        If the trial holds no rest.
    """
    margin = options.rest_margin_s
    first = (time >= time[0] + margin) & (time <= options.rest_before_s - margin)
    last = (time >= time[-1] - options.rest_after_s + margin) & (time <= time[-1] - margin)
    if not first.any() or not last.any():
        raise InputError(
            f"expected {options.rest_before_s:g} s of rest at the trial's start and "
            f"{options.rest_after_s:g} s at its end, found a trial of {time[-1] - time[0]:.3g} s: "
            "correct the times of rest in the configuration"
        )
    return first | last


def find_perturbations(
    belt_velocity: np.ndarray, rate_hz: float, options: WindowOptions, what: str
) -> list[Perturbation]:
    """Perturbations in the filtered belt velocity (m/s); see `detect_perturbations`, which also raises."""
    return detect_perturbations(
        belt_velocity,
        rate_hz,
        options.rest_before_s - options.rest_margin_s,
        options.rest_after_s - options.rest_margin_s,
        options.threshold_fraction,
        options.signal_to_noise,
        options.merge_s,
        what,
    )


@dataclass(frozen=True)
class SegmentRegression:
    """I, B, K of one trial.

    Attributes
    ----------
    perturbations : list of Perturbation
        The windows (samples).
    fits : list of LinearFit
        One per perturbation; parameters in the order I (Nms2/rad), B (Nms/rad), K (Nm/rad).
    torque, predicted : ndarray, shape (n,)
        tau and its prediction from the mean parameters over the whole trial (Nm); the recommended
        regression refers both to rest.
    regressors : ndarray, shape (n, 3)
        theta'' (rad/s2), theta' (rad/s), theta - theta_ref (rad).
    theta_rest_rad, torque_rest_Nm : float
        Angle (rad) and torque (Nm) at rest.
    """

    perturbations: list[Perturbation]
    fits: list[LinearFit]
    torque: np.ndarray
    predicted: np.ndarray
    regressors: np.ndarray
    theta_rest_rad: float
    torque_rest_Nm: float

    @property
    def parameters(self) -> np.ndarray:
        """I (Nms2/rad), B (Nms/rad), K (Nm/rad) of every perturbation, shape (perturbations, 3)."""
        return np.array([fit.parameters for fit in self.fits])

    @property
    def mean(self) -> np.ndarray:
        """Mean of I (Nms2/rad), B (Nms/rad), K (Nm/rad) over the perturbations, shape (3,)."""
        return self.parameters.mean(axis=0)

    @property
    def vaf_per_perturbation(self) -> np.ndarray:
        """VAF (%) of every perturbation with its own parameters, shape (perturbations,)."""
        return np.array(
            [
                vaf(self.torque[p.start : p.stop], self.torque[p.start : p.stop] - fit.residuals)
                for p, fit in zip(self.perturbations, self.fits, strict=True)
            ]
        )

    @property
    def vaf_trial(self) -> float:
        """VAF (%) of the whole trial with the mean parameters."""
        return vaf(self.torque, self.predicted)


def regress_segments(
    motion: LegMotion,
    leg: Leg,
    perturbations: list[Perturbation],
    at_rest: np.ndarray,
    torque_pathway: str,
    estimator: str,
) -> SegmentRegression:
    """Estimate I, B, K over every perturbation.

    Parameters
    ----------
    motion : LegMotion
        Motion of the leg (s, rad, m).
    leg : Leg
        Its mass (kg), centre of mass (m) and inertia (kg m2).
    perturbations : list of Perturbation
        Windows (samples).
    at_rest : ndarray of bool, shape (n,)
        Samples at rest (-).
    torque_pathway : {"leg", "leg-printed"}
        How the torque is derived.
    estimator : {"segment-regression-printed", "segment-regression"}
        Whether the torque at rest is left in (as printed) or subtracted.

    Returns
    -------
    SegmentRegression
        Parameters, predictions and measures of fit (Nm, rad, s).

    Raises
    ------
    KeyError
        If the pathway is unknown.
    InputError
        If the estimator is unknown or a perturbation does not determine the parameters.
    """
    torque = TORQUE_PATHWAYS[torque_pathway](leg, motion.theta, motion.theta_dd, motion.y_dd, motion.z_dd)
    return regress_torque(motion, torque, perturbations, at_rest, estimator)


def regress_torque(
    motion: LegMotion,
    torque: np.ndarray,
    perturbations: list[Perturbation],
    at_rest: np.ndarray,
    estimator: str,
) -> SegmentRegression:
    """Estimate I, B, K over every perturbation from a torque of any origin.

    Parameters
    ----------
    motion : LegMotion
        Motion of the leg (s, rad, m).
    torque : ndarray, shape (n,)
        Torque of the joint (Nm).
    perturbations : list of Perturbation
        Windows (samples).
    at_rest : ndarray of bool, shape (n,)
        Samples at rest (-).
    estimator : {"segment-regression-printed", "segment-regression"}
        Whether the torque at rest is left in (as printed) or subtracted.

    Returns
    -------
    SegmentRegression
        Parameters, predictions and measures of fit (Nm, rad, s).

    Raises
    ------
    InputError
        If the estimator is unknown or a perturbation does not determine the parameters.
    """
    if estimator not in ESTIMATORS:
        raise InputError(f"expected an estimator of {', '.join(ESTIMATORS)}, found {estimator!r}")
    theta_rest = float(motion.theta[at_rest].mean())
    torque_rest = float(torque[at_rest].mean())
    if estimator == "segment-regression":
        torque = torque - torque_rest
    regressors = np.column_stack([motion.theta_dd, motion.theta_d, motion.theta - theta_rest])
    fits = []
    for p in perturbations:
        try:
            fits.append(least_squares_line(regressors[p.start : p.stop], torque[p.start : p.stop]))
        except np.linalg.LinAlgError as error:
            raise InputError(
                f"expected a perturbation at {motion.time[p.start]:.2f} s that determines "
                f"{', '.join(PARAMETERS)}, found {error}: check that the markers moved"
            ) from error
    mean = np.mean([fit.parameters for fit in fits], axis=0)
    predicted = impedance_torque(mean, regressors[:, 2], regressors[:, 1], regressors[:, 0])
    return SegmentRegression(perturbations, fits, torque, predicted, regressors, theta_rest, torque_rest)


def damping_per_skew(
    motion: LegMotion,
    leg: Leg,
    perturbations: list[Perturbation],
    at_rest: np.ndarray,
    torque_pathway: str,
    estimator: str,
    skew_s: float = 0.001,
) -> float:
    """How B moves when the leg's position is taken later than its angle.

    Parameters
    ----------
    motion, leg, perturbations, at_rest, torque_pathway, estimator
        As for `regress_segments`.
    skew_s : float
        Time by which the accelerations of the centre of mass are shifted either way (s).

    Returns
    -------
    float
        Change of B per time of skew (Nms/rad per s).

    Raises
    ------
    InputError
        As `regress_segments`.
    """
    instants = np.clip(motion.time[:, None] + [-skew_s, skew_s], motion.time[0], motion.time[-1])
    y_dd = CubicSpline(motion.time, motion.y_dd)(instants)
    z_dd = CubicSpline(motion.time, motion.z_dd)(instants)
    damping = [
        regress_segments(
            replace(motion, y_dd=y_dd[:, k], z_dd=z_dd[:, k]),
            leg,
            perturbations,
            at_rest,
            torque_pathway,
            estimator,
        ).mean[1]
        for k in (0, 1)
    ]
    return float((damping[1] - damping[0]) / (2.0 * skew_s))


@dataclass(frozen=True)
class Interval:
    """Uncertainty of a mean over perturbations.

    Attributes
    ----------
    standard_error : ndarray, shape (p,)
        Of each parameter's mean (unit of the parameter).
    low, high : ndarray, shape (p,)
        Ends of the 95 % interval (unit of the parameter).
    """

    standard_error: np.ndarray
    low: np.ndarray
    high: np.ndarray


def bootstrap_mean(values: np.ndarray, draws: int, rng: np.random.Generator) -> Interval:
    """Bootstrap over perturbations: honest where residuals within one are correlated.

    Whole perturbations are drawn with replacement; deviations of the drawn means are widened by
    sqrt(n / (n - 1)), because n perturbations underestimate their own spread by that.

    Parameters
    ----------
    values : ndarray, shape (n, p)
        Estimates of n perturbations (any units).
    draws : int
        Number of bootstrap samples (-).
    rng : numpy.random.Generator
        Draws the perturbations.

    Returns
    -------
    Interval
        Standard errors and 95 % interval (units of ``values``); infinite for a single perturbation.
    """
    n = values.shape[0]
    if n < 2:
        unknown = np.full(values.shape[1], np.inf)
        return Interval(unknown, -unknown, unknown)
    drawn = values[rng.integers(0, n, (draws, n))].mean(axis=1)
    mean = values.mean(axis=0)
    deviations = np.sqrt(n / (n - 1.0)) * (drawn - mean)
    low, high = np.percentile(deviations, [2.5, 97.5], axis=0)
    return Interval(deviations.std(axis=0), mean + low, mean + high)
