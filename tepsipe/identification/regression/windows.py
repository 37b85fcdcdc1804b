"""TEP-SIPE: I, B, K by windowed (per-perturbation) least squares (thesis section 3-1-2, eq 3-9).

    tau(t) = I theta'' + B theta' + K (theta - theta_ref)      over the samples of one perturbation

As printed, theta_ref is the angle at rest. At rest, however, the joint carries the weight of a leg that
is not exactly upright, tau_rest = K (theta_rest - theta_ref), so the printed regression is biased unless
theta_rest is 0. The recommended regression refers angle *and* torque to rest:
tau - tau_rest = I theta'' + B theta' + K (theta - theta_rest).
"""

from dataclasses import dataclass, replace

import numpy as np
import scipy

from tepsipe.errors import InputError
from tepsipe.mechanics.impedance_model import PARAMETERS, impedance_torque
from tepsipe.mechanics.inverse_dynamics import Leg, leg_pathway_torque
from tepsipe.mechanics.segment_kinematics import JointMotion, SegmentMotion
from tepsipe.signals.perturbations import Perturbation
from tepsipe.statistics.goodness_of_fit import vaf
from tepsipe.statistics.least_squares import LinearFit, least_squares_line

# shift of the centre of mass's accelerations, in either direction, for the sensitivity to a delay (s)
SKEW_S = 0.001


@dataclass(frozen=True)
class WindowedFits:
    """I, B, K of one trial.

    Attributes
    ----------
    perturbations : list of Perturbation
        The windows (samples).
    fits : list of LinearFit
        One per perturbation; parameters in the order I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad).
    torque, predicted : ndarray, shape (n,)
        tau and its prediction from the mean parameters over the whole trial (N·m); the recommended
        regression refers both to rest.
    regressors : ndarray, shape (n, 3)
        theta'' (rad/s²), theta' (rad/s), theta - theta_ref (rad).
    theta_rest_rad, torque_rest_Nm : float
        Angle (rad) and torque (N·m) at rest.
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
        """I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad) of every perturbation, shape (perturbations, 3)."""
        return np.array([fit.parameters for fit in self.fits])

    @property
    def mean(self) -> np.ndarray:
        """Mean of I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad) over the perturbations, shape (3,)."""
        return self.parameters.mean(axis=0)

    @property
    def squared_rate(self) -> float:
        """Mean square of theta'' over the mean square of theta' in the windows (1/s²): w^2 of a sinusoid."""
        rows = np.concatenate([self.regressors[w.start : w.stop] for w in self.perturbations])
        return float(np.sum(rows[:, 0] ** 2) / np.sum(rows[:, 1] ** 2))

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


def regress_perturbations(
    motion: SegmentMotion,
    leg: Leg,
    perturbations: list[Perturbation],
    at_rest: np.ndarray,
    torque_pathway: str,
    *,
    thesis: bool = False,
) -> WindowedFits:
    """Estimate I, B, K over every perturbation.

    Parameters
    ----------
    motion : SegmentMotion
        Motion of the leg (s, rad, m).
    leg : Leg
        Its mass (kg), centre of mass (m) and inertia (kg·m²).
    perturbations : list of Perturbation
        Windows (samples).
    at_rest : ndarray of bool, shape (n,)
        Samples at rest.
    torque_pathway : {"leg", "leg-thesis"}
        Equation of the torque.
    thesis : bool
        Whether the torque at rest is kept, as printed, or subtracted.

    Returns
    -------
    WindowedFits
        Parameters, predictions and measures of fit (N·m, rad, s).

    Raises
    ------
    InputError
        If the pathway is unknown or a perturbation does not determine the parameters.
    """
    torque = leg_pathway_torque(torque_pathway, leg, motion)
    return regress_torque(motion, torque, perturbations, at_rest, thesis=thesis)


def regress_torque(
    motion: JointMotion,
    torque: np.ndarray,
    perturbations: list[Perturbation],
    at_rest: np.ndarray,
    *,
    thesis: bool = False,
    own_zero: bool = False,
) -> WindowedFits:
    """Estimate I, B, K over every perturbation from a given torque.

    Parameters
    ----------
    motion : JointMotion
        Angle of the joint with its derivatives (s, rad).
    torque : ndarray, shape (n,)
        Torque of the joint (N·m).
    perturbations : list of Perturbation
        Windows (samples).
    at_rest : ndarray of bool, shape (n,)
        Samples at rest.
    thesis : bool
        Whether the torque at rest is kept, as printed, or subtracted.
    own_zero : bool
        Whether each window has a free constant torque beside I, B, K, because the zero of a force plate
        drifts, and friction of the belt leaves a force behind.

    Returns
    -------
    WindowedFits
        Parameters, predictions and measures of fit (N·m, rad, s).

    Raises
    ------
    InputError
        If a perturbation does not determine the parameters.
    """
    theta_rest = float(motion.theta[at_rest].mean())
    torque_rest = float(torque[at_rest].mean())
    if not thesis:
        torque = torque - torque_rest
    regressors = np.column_stack([motion.theta_dd, motion.theta_d, motion.theta - theta_rest])
    fits = []
    for p in perturbations:
        rows, explained = regressors[p.start : p.stop], torque[p.start : p.stop]
        if own_zero:
            rows, explained = rows - rows.mean(axis=0), explained - explained.mean()
        try:
            fits.append(least_squares_line(rows, explained))
        except np.linalg.LinAlgError as error:
            raise InputError(
                f"expected a perturbation at {motion.time[p.start]:.2f} s that determines "
                f"{', '.join(PARAMETERS)}, found {error}: check that the markers moved"
            ) from error
    mean = np.mean([fit.parameters for fit in fits], axis=0)
    predicted = impedance_torque(mean, regressors[:, 2], regressors[:, 1], regressors[:, 0])
    return WindowedFits(perturbations, fits, torque, predicted, regressors, theta_rest, torque_rest)


def damping_per_skew(
    motion: SegmentMotion,
    leg: Leg,
    perturbations: list[Perturbation],
    at_rest: np.ndarray,
    torque_pathway: str,
    *,
    thesis: bool = False,
) -> float:
    """Sensitivity of B to a delay of the leg's position relative to its angle.

    Parameters
    ----------
    motion, leg, perturbations, at_rest, torque_pathway, thesis
        As for `regress_perturbations`.

    Returns
    -------
    float
        Change of B per delay (N·m·s/rad per s).

    Raises
    ------
    InputError
        As `regress_perturbations`.
    """
    instants = np.clip(motion.time[:, None] + [-SKEW_S, SKEW_S], motion.time[0], motion.time[-1])
    y_dd = scipy.interpolate.CubicSpline(motion.time, motion.y_dd)(instants)
    z_dd = scipy.interpolate.CubicSpline(motion.time, motion.z_dd)(instants)
    damping = [
        regress_perturbations(
            replace(motion, y_dd=y_dd[:, k], z_dd=z_dd[:, k]),
            leg,
            perturbations,
            at_rest,
            torque_pathway,
            thesis=thesis,
        ).mean[1]
        for k in (0, 1)
    ]
    return float((damping[1] - damping[0]) / (2.0 * SKEW_S))


def undetermined(evidence: str) -> InputError:
    """Refusal of an angle that does not determine I, B and K; ``evidence`` completes the message."""
    return InputError(
        f"expected an angle that determines {', '.join(PARAMETERS)} by the foot's motion, found {evidence}: "
        "check that the markers and the belt moved, and the geometry in the configuration"
    )
