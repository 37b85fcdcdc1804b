"""Choices and results of a parallel-cascade fit (`tepsipe.identification.parallel_cascade`)."""

from dataclasses import dataclass

import numpy as np

from tepsipe.statistics.goodness_of_fit import HeldOutVaf


@dataclass(frozen=True)
class ParallelCascadeOptions:
    """Options of the fit.

    Attributes
    ----------
    intrinsic_lag_s : float
        Longest lag and lead of the intrinsic response (s).
    reflex_length_s, reflex_knot_s : float
        Length of the reflex response, and distance of its knots (s).
    reflex_delays_s : (float, float)
        Shortest and longest delay that is tried (s).
    expected_delay_s : float
        Preferred delay among those that the record cannot separate (s).
    delay_tolerance : float
        Relative difference of the cross-validated error from which delays are separated (-).
    penalties : tuple of float
        Values of lambda that are tried (-).
    folds : int
        Number of blocks of the cross-validation (-), reduced where blocks would be shorter than the reflex.
    """

    intrinsic_lag_s: float = 0.04
    reflex_length_s: float = 0.6
    reflex_knot_s: float = 0.025
    reflex_delays_s: tuple[float, float] = (0.03, 0.06)
    expected_delay_s: float = 0.04
    delay_tolerance: float = 0.01
    penalties: tuple[float, ...] = (1e-6, 1e-4, 1e-2, 1.0)
    folds: int = 10


@dataclass(frozen=True)
class Structure:
    """Structure that is selected by cross-validation.

    Attributes
    ----------
    direction : {1, -1, 0}
        Sign of the velocity to which the reflex responds (-), 0 for no reflex.
    stiffening : bool
        Whether the stiffness is angle-dependent, that is c is estimated (-).
    delay_s : float
        Delay of the reflex (s), 0 without a reflex.
    penalty : float
        lambda (-).
    """

    direction: int
    stiffening: bool
    delay_s: float
    penalty: float


@dataclass(frozen=True)
class MuscleFit:
    """The muscle model: a reflex with three parameters.

    Attributes
    ----------
    constants : ndarray, shape (3,)
        G (N·m·s/rad), natural frequency (Hz), zeta (-).
    bootstrap : ndarray, shape (draws, 3)
        The same for bootstrapped blocks.
    response : ndarray, shape (k,)
        Impulse response in place of g (N·m/rad).
    predicted : ndarray, shape (n,)
        Predicted torque (N·m).
    vaf : HeldOutVaf
        VAF of the prediction (%).
    """

    constants: np.ndarray
    bootstrap: np.ndarray
    response: np.ndarray
    predicted: np.ndarray
    vaf: HeldOutVaf


@dataclass(frozen=True)
class ParallelCascadeFit:
    """Intrinsic and reflex pathway of one record.

    Attributes
    ----------
    structure : Structure
        Structure selected by cross-validation.
    predicted, reflex_torque : ndarray, shape (n,)
        Predicted tau and tau_R (N·m) over the evaluated part of the record.
    vaf : HeldOutVaf
        VAF of the prediction (%).
    vaf_cross_validated : float
        VAF (%) of the blocks of the fitted part, each predicted from the others.
    impedance : ndarray, shape (3,)
        I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad) of the intrinsic pathway, by regression of its torque on
        acceleration, velocity and angle.
    impedance_bootstrap : ndarray, shape (draws, 3)
        The same for bootstrapped blocks.
    stiffening : float
        Angle-dependent stiffness, change of K per angle, 2 c (N·m/rad²); 0 if there is none.
    stiffening_bootstrap : ndarray, shape (draws,)
        The same for bootstrapped blocks (N·m/rad²).
    gain : float
        G (N·m·s/rad), steady-state reflex torque per stretch velocity; 0 without a reflex.
    gain_bootstrap : ndarray, shape (draws,)
        The same for bootstrapped blocks (N·m·s/rad).
    reflex_share : float
        Variance of tau_R relative to that of tau, in the fitted part (%).
    intrinsic_time, intrinsic_response : ndarray, shape (m,)
        Lag (s), and low-pass filtered h / T (N·m/rad per s).
    reflex_time : ndarray, shape (k,)
        Time from the stretch (s), including the delay; empty without a reflex.
    reflex_response : ndarray, shape (k,)
        g (N·m/rad).
    reflex_low, reflex_high : ndarray, shape (k,)
        Ends of its pointwise 95 % interval (N·m/rad).
    delays : ndarray, shape (d,)
        Delays that were tried (s); empty without a reflex.
    delay_vaf : ndarray, shape (d,)
        Cross-validated VAF (%) with each delay.
    delay_range_s : (float, float)
        Shortest and longest delay that the record does not separate from the best one (s).
    muscle : MuscleFit or None
        The muscle model; None without a reflex.
    """

    structure: Structure
    predicted: np.ndarray
    reflex_torque: np.ndarray
    vaf: HeldOutVaf
    vaf_cross_validated: float
    impedance: np.ndarray
    impedance_bootstrap: np.ndarray
    stiffening: float
    stiffening_bootstrap: np.ndarray
    gain: float
    gain_bootstrap: np.ndarray
    reflex_share: float
    intrinsic_time: np.ndarray
    intrinsic_response: np.ndarray
    reflex_time: np.ndarray
    reflex_response: np.ndarray
    reflex_low: np.ndarray
    reflex_high: np.ndarray
    delays: np.ndarray
    delay_vaf: np.ndarray
    delay_range_s: tuple[float, float]
    muscle: MuscleFit | None
