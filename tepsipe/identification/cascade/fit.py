"""Choices and results of a parallel-cascade fit (`tepsipe.identification.cascade.parallel_cascade`)."""

from dataclasses import dataclass

import numpy as np

from tepsipe.identification.cascade.slow_torque import SlowModel
from tepsipe.statistics.goodness_of_fit import HeldOutVaf


@dataclass(frozen=True)
class ParallelCascadeOptions:
    """Options of the fit.

    Attributes
    ----------
    intrinsic_lag_s : float
        Longest lag and lead of the intrinsic response (s).
    stop_radii_rad : tuple of float
        Radii of the elastic-plastic stop elements (rad), of which those within the recorded movement are
        used; empty for no short-range stiffness. Fixed radii make K comparable between recordings.
    relaxation_times_s : tuple of float
        Time constants of the relaxing elements, springs in series with a damper (s); empty for none.
    reflex_length_s, reflex_knot_s : float
        Length of the reflex response, and distance of its knots (s).
    reflex_poles_per_s, reflex_order : tuple of float, int
        Poles of the Laguerre functions that are tried in place of knots (rad/s), and their number.
    reflex_thresholds_rad_per_s : tuple of float
        Velocity thresholds of the reflex that are tried (rad/s).
    reflex_delays_s : (float, float)
        Shortest and longest delay that is tried (s).
    profiled_delays_s : (float, float)
        Shortest and longest delay whose cross-validated error is reported, without any expectation (s).
    expected_delay_s : float
        Preferred delay among those that the record cannot separate (s).
    delay_tolerance : float
        Relative difference of the cross-validated error from which delays are separated.
    penalties : tuple of float
        Values of lambda that are tried.
    term_tolerance : float
        Relative difference of the cross-validated error below which a simpler structure is taken.
    folds : int
        Number of blocks of the cross-validation, reduced where blocks would be shorter than the reflex.
    slow_horizons_s : tuple of float
        Times by which the slow torque is predicted ahead (s); the result uses the first one.
    """

    intrinsic_lag_s: float = 0.04
    stop_radii_rad: tuple[float, ...] = (0.002, 0.004, 0.008, 0.016)
    relaxation_times_s: tuple[float, ...] = (0.05, 0.2)
    reflex_length_s: float = 0.6
    reflex_knot_s: float = 0.025
    reflex_poles_per_s: tuple[float, ...] = (16.0, 25.0, 40.0)
    reflex_order: int = 5
    reflex_thresholds_rad_per_s: tuple[float, ...] = (*(0.0, 0.05, 0.1, 0.15, 0.2, 0.3, 0.4, 0.6, 0.8),)
    reflex_delays_s: tuple[float, float] = (0.03, 0.06)
    profiled_delays_s: tuple[float, float] = (0.0, 0.1)
    expected_delay_s: float = 0.04
    delay_tolerance: float = 0.01
    penalties: tuple[float, ...] = (1e-6, 1e-4, 1e-2, 1.0)
    term_tolerance: float = 0.01
    folds: int = 10
    slow_horizons_s: tuple[float, ...] = (0.25, 0.1, 0.5, 1.0, 2.0)


@dataclass(frozen=True)
class Structure:
    """Structure selected by cross-validation.

    Attributes
    ----------
    direction : {1, -1, 0}
        Sign of the velocity to which the reflex responds, 0 for no reflex.
    stiffening : bool
        Whether the stiffness is angle-dependent, that is c is estimated.
    delay_s : float
        Delay of the reflex (s), 0 without a reflex.
    penalty : float
        lambda.
    stops : bool
        Whether there is a short-range stiffness.
    gain_slope : bool
        Whether the reflex gain depends on the angle.
    unloading : bool
        Whether velocities of the other direction have a delayed response, too.
    threshold_rad_per_s : float
        Velocity below which the reflex does not respond (rad/s).
    pole_per_s : float
        Pole of the Laguerre functions of the reflex response (rad/s); 0 for a response of knots.
    relaxing : bool
        Whether a part of the stiffness relaxes.
    """

    direction: int
    stiffening: bool
    delay_s: float
    penalty: float
    stops: bool = False
    gain_slope: bool = False
    unloading: bool = False
    threshold_rad_per_s: float = 0.0
    pole_per_s: float = 0.0
    relaxing: bool = False

    @property
    def terms(self) -> int:
        """Number of terms beyond the linear intrinsic pathway."""
        of_joint = self.stiffening + self.stops + self.relaxing
        return abs(self.direction) + of_joint + self.gain_slope + self.unloading


@dataclass(frozen=True)
class MuscleFit:
    """The muscle model: a reflex with three parameters.

    Attributes
    ----------
    constants : ndarray, shape (3,)
        G (N·m·s/rad), natural frequency (Hz), zeta.
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
class Relaxing:
    """Part of the stiffness that relaxes: springs in series with dampers (Maxwell elements).

    Attributes
    ----------
    times_s : ndarray, shape (r,)
        Time constants of the elements (s); empty without relaxation.
    weights : ndarray, shape (r,)
        Their stiffnesses (N·m/rad), not negative.
    stiffness : float
        Sum of the stiffnesses (N·m/rad), 0 without relaxation: K of quick movements exceeds K of slow ones
        by it.
    stiffness_bootstrap : ndarray, shape (draws,)
        The same for bootstrapped blocks (N·m/rad).
    time_s : float
        Mean of the time constants, weighted with the stiffnesses (s); NaN if all weights are 0.
    time_bootstrap : ndarray, shape (draws,)
        The same for bootstrapped blocks (s).
    """

    times_s: np.ndarray
    weights: np.ndarray
    stiffness: float
    stiffness_bootstrap: np.ndarray
    time_s: float
    time_bootstrap: np.ndarray


@dataclass(frozen=True)
class ShortRange:
    """Short-range stiffness: elastic-plastic stop elements beside the linear intrinsic pathway.

    Attributes
    ----------
    radii_rad : ndarray, shape (s,)
        Radii of the elements (rad); empty without a short-range stiffness.
    weights : ndarray, shape (s,)
        Their stiffnesses (N·m/rad), not negative.
    weights_bootstrap : ndarray, shape (draws, s)
        The same for bootstrapped blocks (N·m/rad).
    stiffness : float
        K for quick movements within the smallest radius: K plus all weights, including relaxing elements
        (N·m/rad).
    stiffness_bootstrap : ndarray, shape (draws,)
        The same for bootstrapped blocks (N·m/rad).
    yield_angle_rad : float
        Radius of one element of the same stiffness and the same largest torque, mean of the radii weighted
        with the stiffnesses (rad); NaN if all weights are 0.
    yield_angle_bootstrap : ndarray, shape (draws,)
        The same for bootstrapped blocks (rad).
    """

    radii_rad: np.ndarray
    weights: np.ndarray
    weights_bootstrap: np.ndarray
    stiffness: float
    stiffness_bootstrap: np.ndarray
    yield_angle_rad: float
    yield_angle_bootstrap: np.ndarray


@dataclass(frozen=True)
class SlowTorque:
    """Slow torque, predicted from past residuals (`tepsipe.identification.cascade.slow_torque`).

    Attributes
    ----------
    model : SlowModel
        Its spectrum (Hz).
    sd_Nm : float
        Standard deviation of the residual below the crossover, in the fitted part (N·m).
    horizon_s : float
        Time by which it is predicted ahead (s).
    predicted : ndarray, shape (n,)
        Predicted slow torque (N·m), to be added to the model's prediction.
    vaf : HeldOutVaf
        VAF of both together (%).
    horizons_s, held_out_vaf : ndarray, shape (k,)
        Horizons (s), in increasing order, and held-out VAF with each (%).
    """

    model: SlowModel
    sd_Nm: float
    horizon_s: float
    predicted: np.ndarray
    vaf: HeldOutVaf
    horizons_s: np.ndarray
    held_out_vaf: np.ndarray


@dataclass(frozen=True)
class Assumption:
    """A choice and the range within which the record does not determine it.

    Attributes
    ----------
    quantity, unit : str
        Name and unit of what is chosen.
    value, low, high : float
        Value that is used, and ends of the range whose cross-validated error is alike (unit of the quantity).
    vaf_low, vaf_high : float
        Smallest and largest cross-validated VAF within the range (%).
    determined : bool
        Whether the record determines the quantity: the range is one value or its neighbours.
    """

    quantity: str
    unit: str
    value: float
    low: float
    high: float
    vaf_low: float
    vaf_high: float
    determined: bool


@dataclass(frozen=True)
class ModelScore:
    """Score of one of the compared models.

    Attributes
    ----------
    structure : Structure
        Its terms.
    error, error_se : float
        Cross-validated error relative to the smallest, and standard error of the difference (%).
    vaf_cross_validated, vaf_held_out : float
        VAF (%) of the blocks of the fitted part, each predicted from the others, and of the held-out part.
    coefficients : int
        Number of coefficients, offset included, before they are shrunk by the penalty.
    """

    structure: Structure
    error: float
    error_se: float
    vaf_cross_validated: float
    vaf_held_out: float
    coefficients: int


@dataclass(frozen=True)
class ParallelCascadeFit:
    """Intrinsic and reflex pathway of one record.

    Attributes
    ----------
    structure : Structure
        Structure selected by cross-validation.
    blocks : int
        Number of blocks from which the bootstrap draws.
    predicted, reflex_torque, stop_torque : ndarray, shape (n,)
        Predicted tau, tau_R, and torque of the stop and relaxing elements (N·m) over the evaluated part of
        the record.
    vaf : HeldOutVaf
        VAF of the prediction (%).
    vaf_cross_validated : float
        VAF (%) of the blocks of the fitted part, each predicted from the others.
    impedance : ndarray, shape (3,)
        I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad) of the intrinsic pathway without the stop and relaxing
        elements, by regression of its torque on acceleration, velocity and angle: K is the stiffness beyond
        yield and after relaxation.
    impedance_bootstrap : ndarray, shape (draws, 3)
        The same for bootstrapped blocks.
    working_stiffness : float
        Stiffness at the recorded amplitude (N·m/rad): slope of the whole intrinsic torque, stop and relaxing
        elements included, by the same regression.
    working_stiffness_bootstrap : ndarray, shape (draws,)
        The same for bootstrapped blocks (N·m/rad).
    short_range : ShortRange
        Short-range stiffness and stop elements (N·m/rad, rad).
    relaxing : Relaxing
        Part of the stiffness that relaxes (N·m/rad, s).
    stiffening : float
        Angle-dependent stiffness, change of K per angle, 2 c (N·m/rad²); 0 if there is none.
    stiffening_bootstrap : ndarray, shape (draws,)
        The same for bootstrapped blocks (N·m/rad²).
    gain : float
        G (N·m·s/rad), steady-state reflex torque per stretch velocity; 0 without a reflex.
    gain_bootstrap : ndarray, shape (draws,)
        The same for bootstrapped blocks (N·m·s/rad).
    gain_slope, unloading_gain : float
        Change of G per angle (N·m·s/rad²), and steady-state torque per velocity of the other direction
        (N·m·s/rad); 0 where the structure has no such term.
    gain_slope_bootstrap, unloading_gain_bootstrap : ndarray, shape (draws,)
        The same for bootstrapped blocks.
    reflex_share : float
        Variance of tau_R relative to the variance of tau, in the fitted part (%).
    intrinsic_time, intrinsic_response : ndarray, shape (m,)
        Lag (s), and low-pass filtered h / T (N·m/rad per s).
    reflex_time : ndarray, shape (k,)
        Time from the stretch (s), including the delay; empty without a reflex.
    reflex_response : ndarray, shape (k,)
        g (N·m/rad).
    reflex_low, reflex_high : ndarray, shape (k,)
        Ends of its pointwise 95 % interval (N·m/rad).
    reflex_peak_s, reflex_duration_s : float
        Time from the stretch to the largest reflex response, delay included, and time after the delay within
        which 95 % of the area of its magnitude lie (s); NaN without a reflex.
    delays : ndarray, shape (d,)
        Delays whose error is profiled (s); empty without a reflex.
    delay_vaf : ndarray, shape (d,)
        Cross-validated VAF (%) of the weighted torque with each delay.
    delay_range_s : (float, float)
        Shortest and longest profiled delay that the record does not separate from the best one (s).
    muscle : MuscleFit or None
        The muscle model; None without a reflex.
    slow : SlowTorque
        Prediction of the slow torque, scored apart (N·m).
    assumptions : tuple of Assumption
        Choices of the reflex that the record determines weakly or not at all; empty without a reflex.
    models : tuple of ModelScore
        Models that were compared, the simplest first.
    """

    structure: Structure
    blocks: int
    predicted: np.ndarray
    reflex_torque: np.ndarray
    stop_torque: np.ndarray
    vaf: HeldOutVaf
    vaf_cross_validated: float
    impedance: np.ndarray
    impedance_bootstrap: np.ndarray
    working_stiffness: float
    working_stiffness_bootstrap: np.ndarray
    short_range: ShortRange
    relaxing: Relaxing
    stiffening: float
    stiffening_bootstrap: np.ndarray
    gain: float
    gain_bootstrap: np.ndarray
    gain_slope: float
    gain_slope_bootstrap: np.ndarray
    unloading_gain: float
    unloading_gain_bootstrap: np.ndarray
    reflex_share: float
    intrinsic_time: np.ndarray
    intrinsic_response: np.ndarray
    reflex_time: np.ndarray
    reflex_response: np.ndarray
    reflex_low: np.ndarray
    reflex_high: np.ndarray
    reflex_peak_s: float
    reflex_duration_s: float
    delays: np.ndarray
    delay_vaf: np.ndarray
    delay_range_s: tuple[float, float]
    muscle: MuscleFit | None
    slow: SlowTorque
    assumptions: tuple[Assumption, ...]
    models: tuple[ModelScore, ...]
