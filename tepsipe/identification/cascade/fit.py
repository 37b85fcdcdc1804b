"""Choices and results of a parallel-cascade fit (`tepsipe.identification.cascade.parallel_cascade`).

Slow torque of a person: the part of a joint's torque that does not respond to the imposed movement.

The torque that no model of the joint explains is a slow voluntary torque b and faster remains w:

    e[n] = b[n] + w[n],    b[n + 1] = phi b[n] + v[n],    phi = exp(-2 pi corner / rate)

with white v and w. The one-step error of the steady-state Kalman filter (its innovation) is white,

    (1 - phi z^-1) e / (1 - rho z^-1),    rho = exp(-2 pi sqrt(corner^2 + crossover^2) / rate)

so this filter of torque and regressors turns least squares into generalised least squares; below the
crossover the slow torque exceeds the remains. Corner and crossover maximise Whittle's likelihood of the
residual of a first fit (periodogram up to ``BAND_HZ``). The prediction of b for the time t + horizon from
residuals up to t is phi^horizon times the filter's estimate; it is causal in the torque.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
import scipy

from tepsipe.identification.result import Quantity, symbol_of
from tepsipe.mechanics.impedance_model import PARAMETERS
from tepsipe.statistics.goodness_of_fit import HeldOutVaf

# highest frequency used to estimate the slow torque (Hz); tried values of corner and crossover
BAND_HZ = 5.0
CORNERS_HZ = np.geomspace(0.02, 2.0, 13)
CROSSOVERS_HZ = np.concatenate([[0.0], np.geomspace(0.05, BAND_HZ, 13)])


@dataclass(frozen=True)
class SlowModel:
    """Spectrum of the slow torque relative to the rest of the residual."""

    corner_hz: float
    """Frequency (Hz) below which the spectrum of the slow torque is flat."""
    crossover_hz: float
    """Frequency (Hz) at which the slow torque falls below the remains, were its corner 0; 0 for none."""

    def poles(self, rate_hz: float) -> tuple[float, float]:
        """Constants phi and rho at a sampling rate (Hz)."""
        return tuple(
            float(np.exp(-2.0 * np.pi * f / rate_hz))
            for f in (self.corner_hz, np.hypot(self.corner_hz, self.crossover_hz))
        )

    def whiten(self, x: np.ndarray, rate_hz: float) -> np.ndarray:
        """Innovation of signals (their unit) along axis 0; the first sample is held before the start."""
        return self.whiten_part(x, rate_hz)[0]

    def whiten_part(self, x: np.ndarray, rate_hz: float, state: np.ndarray | None = None) -> tuple:
        """Innovation of a part of signals, and the state after it, with which the next part goes on.

        state: state after the part before; None for the first part.
        """
        if self.crossover_hz == 0.0:
            return x, None
        phi, rho = self.poles(rate_hz)
        if state is None:
            state = (rho - phi) / (1.0 - rho) * x[:1]
        return scipy.signal.lfilter([1.0, -phi], [1.0, -rho], x, axis=0, zi=state)

    def predict(self, residual: np.ndarray, rate_hz: float, horizon: int) -> np.ndarray:
        """Slow torque from the residual (same unit) at least ``horizon`` samples before, 0 at the start."""
        phi, rho = self.poles(rate_hz)
        filtered = scipy.signal.lfilter([1.0 - rho / phi], [1.0, -rho], residual)
        held = np.concatenate([np.zeros(horizon), filtered[: residual.size - horizon]])
        return phi**horizon * held


def estimate_slow_model(residual: Annotated[np.ndarray, "(n,)", "N·m"], rate_hz: float) -> SlowModel:
    """Corner and crossover of the slow torque by Whittle's likelihood.

    residual: torque that a first model does not explain.
    Returns: its frequencies, from a fixed grid.
    """
    window = np.hanning(residual.size)
    power = np.abs(np.fft.rfft(window * (residual - residual.mean()))) ** 2
    frequency = np.fft.rfftfreq(residual.size, 1.0 / rate_hz)
    used = (frequency >= 1.5 * rate_hz / residual.size) & (frequency <= BAND_HZ)
    power, frequency = power[used], frequency[used]
    if not power.size or not power.all():
        return SlowModel(float(CORNERS_HZ[0]), 0.0)
    corner, crossover = (x.ravel() for x in np.meshgrid(CORNERS_HZ, CROSSOVERS_HZ, indexing="ij"))
    below = frequency**2 + corner[:, None] ** 2
    shape = (below + crossover[:, None] ** 2) / below
    # the level with the largest likelihood for the shape
    cost = np.log(shape).mean(axis=1) + np.log((power / shape).mean(axis=1))
    best = int(np.argmin(cost))
    return SlowModel(float(corner[best]), float(crossover[best]))


@dataclass(frozen=True)
class Structure:
    """Structure selected by cross-validation."""

    direction: int
    """{1, -1, 0}: Sign of the velocity to which the reflex responds, 0 for no reflex."""
    stiffening: bool
    """Whether the stiffness is angle-dependent, that is c is estimated."""
    delay_s: float
    """Delay of the reflex (s), 0 without a reflex."""
    penalty: float
    """lambda."""
    stops: bool = False
    """Whether there is a short-range stiffness."""
    gain_slope: bool = False
    """Whether the reflex gain depends on the angle."""
    unloading: bool = False
    """Whether velocities of the other direction have a delayed response, too."""
    threshold_rad_per_s: float = 0.0
    """Velocity below which the reflex does not respond."""
    unfiltered: bool = False
    """Whether the velocity is rectified before the low-pass, not after it."""
    pole_per_s: float = 0.0
    """Pole of the Laguerre functions of the reflex response (rad/s); 0 for a response of knots."""
    relaxing: bool = False
    """Whether a part of the stiffness relaxes."""

    @property
    def terms(self) -> int:
        """Number of terms beyond the linear intrinsic pathway."""
        of_joint = self.stiffening + self.stops + self.relaxing
        return abs(self.direction) + of_joint + self.gain_slope + self.unloading


@dataclass(frozen=True)
class MuscleFit:
    """The muscle model: a reflex with three parameters."""

    constants: Annotated[np.ndarray, "(3,)"]
    """G (N·m·s/rad), natural frequency (Hz), zeta."""
    bootstrap: Annotated[np.ndarray, "(draws, 3)"]
    """The same for bootstrapped blocks."""
    response: Annotated[np.ndarray, "(k,)", "N·m/rad"]
    """Impulse response in place of g."""
    predicted: Annotated[np.ndarray, "(n,)", "N·m"]
    """Predicted torque."""
    vaf: HeldOutVaf
    """VAF of the prediction (%)."""


@dataclass(frozen=True)
class Relaxing:
    """Part of the stiffness that relaxes: springs in series with dampers (Maxwell elements)."""

    times_s: Annotated[np.ndarray, "(r,)"]
    """Time constants of the elements (s); empty without relaxation."""
    weights: Annotated[np.ndarray, "(r,)"]
    """Their stiffnesses (N·m/rad), not negative."""
    stiffness: float
    """Sum of the stiffnesses (N·m/rad), 0 without relaxation: K of quick movements exceeds K of slow ones
    by it."""
    stiffness_bootstrap: Annotated[np.ndarray, "(draws,)", "N·m/rad"]
    """The same for bootstrapped blocks."""
    time_s: float
    """Mean of the time constants, weighted with the stiffnesses (s); NaN if all weights are 0."""
    time_bootstrap: Annotated[np.ndarray, "(draws,)", "s"]
    """The same for bootstrapped blocks."""


@dataclass(frozen=True)
class ShortRange:
    """Short-range stiffness: elastic-plastic stop elements beside the linear intrinsic pathway."""

    radii_rad: Annotated[np.ndarray, "(s,)"]
    """Radii of the elements (rad); empty without a short-range stiffness."""
    weights: Annotated[np.ndarray, "(s,)"]
    """Their stiffnesses (N·m/rad), not negative."""
    weights_bootstrap: Annotated[np.ndarray, "(draws, s)", "N·m/rad"]
    """The same for bootstrapped blocks."""
    stiffness: Annotated[float, "N·m/rad"]
    """K for quick movements within the smallest radius: K plus all weights, including relaxing elements."""
    stiffness_bootstrap: Annotated[np.ndarray, "(draws,)", "N·m/rad"]
    """The same for bootstrapped blocks."""
    yield_angle_rad: float
    """Radius of one element of the same stiffness and the same largest torque, mean of the radii weighted
    with the stiffnesses (rad); NaN if all weights are 0."""
    yield_angle_bootstrap: Annotated[np.ndarray, "(draws,)", "rad"]
    """The same for bootstrapped blocks."""


@dataclass(frozen=True)
class SlowTorque:
    """Slow torque, predicted from past residuals (`tepsipe.identification.cascade.fit`)."""

    model: SlowModel
    """Its spectrum (Hz)."""
    sd_Nm: float
    """Standard deviation of the residual below the crossover, in the fitted part."""
    horizon_s: float
    """Time by which it is predicted ahead."""
    predicted: np.ndarray
    """Predicted slow torque (N·m), to be added to the model's prediction."""
    vaf: HeldOutVaf
    """VAF of both together (%)."""
    horizons_s: Annotated[np.ndarray, "(k,)"]
    held_out_vaf: Annotated[np.ndarray, "(k,)"]
    """Horizons (s), in increasing order, and held-out VAF with each (%)."""


@dataclass(frozen=True)
class Assumption:
    """A choice and the range within which the record does not determine it."""

    quantity: str
    unit: str
    """Name and unit of what is chosen."""
    value: float
    low: float
    high: float
    """Value that is used, and ends of the range whose cross-validated error is alike (unit of the
    quantity)."""
    vaf_low: Annotated[float, "%"]
    vaf_high: Annotated[float, "%"]
    """Smallest and largest cross-validated VAF within the range."""
    determined: bool
    """Whether the record determines the quantity: the range is one value or its neighbours."""


@dataclass(frozen=True)
class ModelScore:
    """Score of one of the compared models."""

    structure: Structure
    """Its terms."""
    error: Annotated[float, "%"]
    error_se: Annotated[float, "%"]
    """Cross-validated error relative to the smallest, and standard error of the difference."""
    vaf_cross_validated: float
    vaf_held_out: float
    """VAF (%) of the blocks of the fitted part, each predicted from the others, and of the held-out part."""
    coefficients: int
    """Number of coefficients, offset included, before they are shrunk by the penalty."""


@dataclass(frozen=True)
class ParallelCascadeFit:
    """Intrinsic and reflex pathway of one record."""

    structure: Structure
    """Structure selected by cross-validation."""
    blocks: int
    """Number of blocks from which the bootstrap draws."""
    predicted: np.ndarray
    reflex_torque: np.ndarray
    stop_torque: np.ndarray
    """Predicted tau, tau_R, and torque of the stop and relaxing elements (N·m) over the evaluated part of
    the record."""
    vaf: HeldOutVaf
    """VAF of the prediction (%)."""
    vaf_cross_validated: float
    """VAF (%) of the blocks of the fitted part, each predicted from the others."""
    impedance: Annotated[np.ndarray, "(3,)"]
    """I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad) of the intrinsic pathway without the stop and relaxing
    elements, by regression of its torque on acceleration, velocity and angle: K is the stiffness beyond
    yield and after relaxation."""
    impedance_bootstrap: Annotated[np.ndarray, "(draws, 3)"]
    """The same for bootstrapped blocks."""
    working_stiffness: float
    """Stiffness at the recorded amplitude (N·m/rad): slope of the whole intrinsic torque, stop and relaxing
    elements included, by the same regression."""
    working_stiffness_bootstrap: Annotated[np.ndarray, "(draws,)", "N·m/rad"]
    """The same for bootstrapped blocks."""
    short_range: ShortRange
    """Short-range stiffness and stop elements (N·m/rad, rad)."""
    relaxing: Relaxing
    """Part of the stiffness that relaxes (N·m/rad, s)."""
    stiffening: float
    """Angle-dependent stiffness, change of K per angle, 2 c (N·m/rad²); 0 if there is none."""
    stiffening_bootstrap: Annotated[np.ndarray, "(draws,)"]
    """The same for bootstrapped blocks (N·m/rad²)."""
    gain: float
    """G (N·m·s/rad), steady-state reflex torque per stretch velocity; 0 without a reflex."""
    gain_bootstrap: Annotated[np.ndarray, "(draws,)", "N·m·s/rad"]
    """The same for bootstrapped blocks."""
    gain_slope: float
    """Change of G per angle (N·m·s/rad²), and steady-state torque per velocity of the other direction
    (N·m·s/rad); 0 where the structure has no such term."""
    gain_slope_bootstrap: Annotated[np.ndarray, "(draws,)"]
    """The same for bootstrapped blocks."""
    unloading_gain: float
    unloading_gain_bootstrap: Annotated[np.ndarray, "(draws,)"]
    reflex_share: Annotated[float, "%"]
    """Variance of tau_R relative to the variance of tau, in the fitted part."""
    intrinsic_time: Annotated[np.ndarray, "(m,)"]
    intrinsic_response: Annotated[np.ndarray, "(m,)"]
    """Lag (s), and low-pass filtered h / T (N·m/rad per s)."""
    reflex_time: Annotated[np.ndarray, "(k,)"]
    """Time from the stretch (s), including the delay; empty without a reflex."""
    reflex_response: Annotated[np.ndarray, "(k,)", "N·m/rad"]
    reflex_low: Annotated[np.ndarray, "(k,)", "N·m/rad"]
    reflex_high: Annotated[np.ndarray, "(k,)", "N·m/rad"]
    """Ends of its pointwise 95 % interval."""
    reflex_peak_s: float
    reflex_duration_s: float
    """Time from the stretch to the largest reflex response, delay included, and time after the delay within
    which 95 % of the area of its magnitude lie (s); NaN without a reflex."""
    delays: Annotated[np.ndarray, "(d,)"]
    """Delays whose error is profiled (s); empty without a reflex."""
    delay_vaf: Annotated[np.ndarray, "(d,)"]
    """Cross-validated VAF (%) of the weighted torque with each delay."""
    delay_range_s: tuple[float, float]
    """Shortest and longest profiled delay that the record does not separate from the best one."""
    muscle: MuscleFit | None
    """The muscle model; None without a reflex."""
    slow: SlowTorque
    """Prediction of the slow torque, scored apart (N·m)."""
    assumptions: tuple[Assumption, ...]
    """Choices of the reflex that the record determines weakly or not at all; empty without a reflex."""
    models: tuple[ModelScore, ...]
    """Models that were compared, the simplest first."""

    def quantities(self, confidence: float = 0.95) -> dict[str, Quantity]:
        """Constants of the terms that were selected, by their names in `UNITS`; a reflex gain of 0 without
        a reflex.
        """
        short, relaxing, chosen = self.short_range, self.relaxing, self.structure
        of_joint = zip(PARAMETERS, self.impedance, self.impedance_bootstrap.T, strict=True)
        found = {name: (value, draws) for name, value, draws in of_joint}
        found["K_working"] = self.working_stiffness, self.working_stiffness_bootstrap
        found["K_short_range"] = short.stiffness, short.stiffness_bootstrap
        if np.isfinite(short.yield_angle_rad):
            found["yield_angle"] = short.yield_angle_rad, short.yield_angle_bootstrap
        if np.isfinite(relaxing.time_s):
            found["K_relaxing"] = relaxing.stiffness, relaxing.stiffness_bootstrap
            found["relaxation_time"] = relaxing.time_s, relaxing.time_bootstrap
        if chosen.stiffening:
            found["K_growth"] = self.stiffening, self.stiffening_bootstrap
        found["reflex_gain"] = self.gain, self.gain_bootstrap
        if chosen.direction and chosen.gain_slope:
            found["reflex_gain_slope"] = self.gain_slope, self.gain_slope_bootstrap
        if chosen.direction and chosen.unloading:
            found["unloading_gain"] = self.unloading_gain, self.unloading_gain_bootstrap
        return {
            name: Quantity.drawn(value, symbol_of(name), draws, confidence, self.blocks)
            for name, (value, draws) in found.items()
        }
