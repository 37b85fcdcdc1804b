"""Expected standard uncertainty of B and K of a standing person's ankles, before anyone stands on the belt.

The belt turns the shank about a point a distance L above the ankle, phi = -y / L, for the first tenth of a
second. Within it, B and K are estimated together with a free reflex torque
(`tepsipe.experiments.standing.free_reflex.fit`). With X the mean responses of rate and angle, and H = C^-1 P
the estimator's own weights, where P projects on the motion of the belt, the covariance after n responses is

    cov = N^-1 [ X' H S H X / n + V / n^2 ] N^-1,     N = X' H X,     C = S / n + C_model + C_reflex

S is the covariance of the residual torque u = tau - B phi' - K phi in the window, relative to the baseline
before the onset: sway, a smooth process (Matern 3/2) of standard deviation s and time T, noise of the plate,
and noise of the angle times B and K, all low-passed as the signals (F),

    cov(s(t), s(t')) = s^2 (1 + |t - t'| / T) exp(-|t - t'| / T)

Noise of the angle is that of a marker times a factor of the layout of the markers. Its moments M in the
regressors are subtracted (errors in variables), but chance remains: with a, b = phi', phi,

    V_ab = tr(H S H M_ab) + tr(H M_ua H M_ub)

Where the model of rig and reflex limits C, C does not fall with n, and u_A does not fall as 1 / sqrt(n).
Type B is a share of B and K due to joint centre, mass of the feet and rig, and what the calibration leaves of
the effect of the treadmill's frame. The person's force passes through the empty frame, which shows

    G tau,     G(s) = (2 z w s + w^2) / (s^2 + 2 z w s + w^2)

of the torque, with w its fore-aft resonance and z its damping ratio. A share e of (G - 1) tau remains after
the treadmill model. As any error of the torque, it changes B and K by N^-1 X' H e (G - 1) tau, in the same
direction in every response. The frame rings, and whether the end of the window meets a crest depends on w to
a few per cent; the root mean square over frequencies around w is taken. I is not estimated, because the
inertia of the feet is known.
"""

from dataclasses import dataclass, field
from functools import cached_property
from typing import Annotated

import numpy as np
import scipy
from annotated_types import Ge, Gt, Lt

from tepsipe.arguments import check_options
from tepsipe.experiments.planning.plan import COVERAGE, quantity_row
from tepsipe.experiments.planning.pulses import STEP_S, Drive, Pulse, pulse_of
from tepsipe.experiments.standing.free_reflex.fit import QUANTITIES, inside_window, reflex_covariance
from tepsipe.experiments.standing.options import FreeReflexOptions
from tepsipe.identification.regression.generalised import Record, squared_exponential
from tepsipe.quantities import Fraction, Frequency, NotNegative, Positive
from tepsipe.signals.differentiation import derivative
from tepsipe.signals.filters import WIDEST, butterworth_lowpass

RATE_HZ = 250.0
# epochs and baseline as in a standing trial (s)
BEFORE_S, AFTER_S, BASELINE_S = 0.12, 0.2, 0.1
# share of the peak velocity at which the onset of a pulse is detected
ONSET_SHARE = 0.1
MOST_RESPONSES = 100_000
ORDER = 4  # of the low-pass
MARGIN = 40  # samples on both sides, beyond which the low-pass has no effect
WINDOW_S = 0.08  # length of the fitted window
NEAR = np.linspace(0.85, 1.15, 7)  # resonances of the frame over which its effect is averaged, over its own
# shipped choices of the estimator; a test compares them with the configuration
OPTIONS = FreeReflexOptions(
    lowpass_cutoff_hz=60.0,
    discrepancy=0.02,
    discrepancy_s=0.008,
    reflex_Nm=1.6,
    reflex_after_s=0.02,
    reflex_speed_m_per_s=0.5,
    reflex_onset_s=0.045,
    electromechanical_delay_s=0.004,
    windows_s=(0.04, 0.08),
)


@dataclass(frozen=True)
class StandingDesign:
    """A planned experiment with a standing person."""

    stiffness_Nm_per_rad: Positive = 400.0
    damping_Nms_per_rad: Positive = 10.0
    """Expected K and B of both ankles together."""
    lever_m: Positive = 0.85
    """Height above the ankle about which a pulse turns the shank."""
    sway_Nm: Positive = 2.0
    sway_s: Positive = 0.18
    """Standard deviation (N·m) and time (s) of the torque of sway beyond B phi' + K phi."""
    noise_Nm: Positive = 0.13
    """Noise of the torque after the low-pass."""
    marker_noise_m: NotNegative = 0.0000065
    camera_rate_hz: Positive = 250.0
    """Standard deviation of a marker's noise in each direction (m), and rate of the cameras (Hz)."""
    angle_per_marker: NotNegative = 12.0
    """Noise of the ankle angle per noise of a marker (rad/m); it follows from the distances of the
    markers."""
    pulse: Pulse = field(default_factory=lambda: pulse_of("sine", 0.4, 0.1))
    """Commanded pulse (m/s)."""
    number: Annotated[int, Ge(1)] = 40
    """Usable responses."""
    drive: Drive = field(default_factory=Drive)
    """The belt's drive (Hz, s, m/s²)."""
    type_b: Annotated[float, Ge(0), Lt(1)] = 0.072
    """Standard uncertainty of B and K from everything but sway and frame, over their values."""
    frame_hz: Frequency = 52.0
    """Fore-aft resonance of the treadmill's frame, empty."""
    frame_damping: Annotated[float, Gt(0), Lt(1)] = 0.04
    """Its damping ratio."""
    frame_left: Fraction = 0.5
    """Share e of the frame's effect that the treadmill model leaves (standard uncertainty); the default gives
    the uncertainty of K by the treadmill model in the shipped study, 1 that of no model."""
    options: FreeReflexOptions = OPTIONS
    """Choices of the estimator."""

    def __post_init__(self):
        """Refuse impossible experiments."""
        check_options(StandingDesign, self, "standing")

    @property
    def cutoff_hz(self) -> float:
        """Cutoff of the low-pass of all signals (Hz), lowered if the cameras are slow."""
        return min(self.options.lowpass_cutoff_hz, WIDEST * self.camera_rate_hz)

    @property
    def parameters(self) -> np.ndarray:
        """I, which is not estimated (NaN), B and K, shape (3,) (N·m·s²/rad, N·m·s/rad, N·m/rad)."""
        return np.array([np.nan, self.damping_Nms_per_rad, self.stiffness_Nm_per_rad])


@dataclass(frozen=True)
class BeltPulse:
    """Motion of the belt for the figure of a plan."""

    pulse_velocity: Annotated[np.ndarray, "m/s"]
    """Velocity every millisecond."""


@dataclass(frozen=True)
class StandingPlan:
    """Predicted precision of B and K for a design."""

    design: StandingDesign
    """The experiment."""
    motion: BeltPulse
    """Response of the drive to its pulse (m/s)."""

    @property
    def response(self) -> np.ndarray:
        """Torque (N·m), angle (rad) and rate (rad/s) of the epoch, baseline-corrected, shape (n, 3)."""
        return self._epoch[:, :3]

    @property
    def of_frame(self) -> np.ndarray:
        """(G - 1) tau (N·m) of the epoch for resonances around the frame's, as `response`, shape (n, k)."""
        return self._epoch[:, 3:]

    @cached_property
    def _epoch(self) -> np.ndarray:
        design, time = self.design, epoch_time()
        pulse = self.motion.pulse_velocity
        onset = int(np.argmax(np.abs(pulse) > ONSET_SHARE * self.peak_m_per_s))
        velocity = np.concatenate([np.zeros(400), pulse, np.zeros(600)])
        fine = STEP_S * (np.arange(velocity.size) - 400 - onset)
        rate = -velocity / design.lever_m
        angle = np.cumsum(rate) * STEP_S
        torque = design.damping_Nms_per_rad * rate + design.stiffness_Nm_per_rad * angle
        of_frame = [frame_effect(torque, hz, design.frame_damping) for hz in NEAR * design.frame_hz]
        signals = np.column_stack([torque, angle, rate, *of_frame])
        filtered = butterworth_lowpass(signals, 1.0 / STEP_S, design.cutoff_hz, ORDER)
        epoch = np.column_stack([np.interp(time, fine, column) for column in filtered.T])
        return epoch - epoch[baseline_samples(time)].mean(axis=0)

    @property
    def peak_m_per_s(self) -> float:
        """Largest speed of the belt (m/s)."""
        return float(np.abs(self.motion.pulse_velocity).max())

    @cached_property
    def _noise(self) -> tuple[np.ndarray, ...]:
        """What is the same for any number of responses, in the window.

        Moments of sway and noise, those of u with torque, angle and rate, and covariances of u, misfit and
        reflex.
        """
        time, design, options = epoch_time(), self.design, self.design.options
        inside = inside_window(time, WINDOW_S)
        moments = noise_moments(design)[:, :, inside][..., inside]
        combination = np.array([1.0, -design.stiffness_Nm_per_rad, -design.damping_Nms_per_rad])
        with_residual = np.tensordot(combination, moments, 1)
        of_residual = np.tensordot(combination, with_residual, 1)
        size = options.discrepancy * np.abs(self.response[inside, 0]).max()
        smooth = squared_exponential(time[inside], options.discrepancy_s) + 1e-6 * np.eye(inside.sum())
        free = reflex_covariance(time, options.reflex_onset_s, design.cutoff_hz, ORDER)
        free = free[np.ix_(inside, inside)]
        free *= options.reflex_Nm**2 / (options.reflex_after_s**3 / 3.0)
        speed = self.peak_m_per_s / options.reflex_speed_m_per_s
        return moments, with_residual, of_residual, size**2 * smooth, speed**2 * free

    def type_a_with(self, number: int) -> np.ndarray:
        """Type A of I (NaN), B, K, shape (3,), after a number of responses."""
        return self._with(number)[0]

    def _with(self, number: int) -> tuple[np.ndarray, np.ndarray]:
        """Type A, and the error if no model corrects the frame, of I (NaN), B, K after so many responses."""
        inside = inside_window(epoch_time(), WINDOW_S)
        response, of_frame = self.response[inside], self.of_frame[inside]
        moments, with_residual, of_residual, misfit, reflex = self._noise
        covariance = of_residual / number + misfit + reflex
        regressors = [2, 1]  # rate and angle
        x = response[:, regressors]
        # the shank turns about a point, so belt and angle have the same motion up to a factor
        weight = Record(response[:, 0], x, covariance, x).weight
        weighted = weight @ of_residual @ weight
        crossed = weight @ with_residual[regressors]
        of_noise = moments[np.ix_(regressors, regressors)]
        chance = np.einsum("st,abts->ab", weighted, of_noise) + np.einsum("ast,bts->ab", crossed, crossed)
        spread = x.T @ weighted @ x / number + chance / number**2
        inverse = np.linalg.inv(x.T @ weight @ x)
        wrong = np.sqrt(np.mean((inverse @ x.T @ weight @ of_frame) ** 2, axis=1))
        return tuple(
            np.concatenate([[np.nan], found])
            for found in (np.sqrt(np.diag(inverse @ spread @ inverse)), wrong)
        )

    @property
    def type_a(self) -> np.ndarray:
        """Type A of I (NaN), B, K, shape (3,)."""
        return self.type_a_with(self.design.number)

    @property
    def type_b(self) -> np.ndarray:
        """Type B of I (NaN), B, K, shape (3,), with the planned number of responses."""
        return self._type_b(self._with(self.design.number)[1])

    def _type_b(self, of_frame: np.ndarray) -> np.ndarray:
        design = self.design
        return np.hypot(design.type_b * design.parameters, design.frame_left * of_frame)

    def with_number(self, number: int) -> np.ndarray:
        """Combined standard uncertainty of I (NaN), B, K, shape (3,), after a number of responses."""
        type_a, of_frame = self._with(number)
        return np.hypot(type_a, self._type_b(of_frame))

    def number_for(self, relative: float, quantity: str) -> int | None:
        """Number of responses for a 95 % interval of B or K within +- ``relative`` of it, or None."""
        k = ("I", "B", "K").index(quantity)
        wanted = relative * self.design.parameters[k] / COVERAGE

        def enough(n: int) -> bool:
            return bool(self.with_number(n)[k] <= wanted)

        if not enough(MOST_RESPONSES):
            return None
        low, high = 0, 1
        while not enough(high):
            low, high = high, 2 * high
        while high - low > 1:
            middle = (low + high) // 2
            low, high = (low, middle) if enough(middle) else (middle, high)
        return high

    @property
    def combined(self) -> np.ndarray:
        """Combined standard uncertainty of I (NaN), B, K, shape (3,)."""
        return self.with_number(self.design.number)

    def rows(self) -> list[dict]:
        """One row for B and for K, with the columns of the plan of a dummy."""
        return [quantity_row(self, name, self.design.number) for name in QUANTITIES]


def plan_standing(design: StandingDesign) -> StandingPlan:
    """Plan an experiment with a standing person (units in `StandingPlan`)."""
    return StandingPlan(design, BeltPulse(design.drive.follow(design.pulse.velocity_m_per_s)))


def frame_effect(torque: np.ndarray, hz: float, damping: float) -> np.ndarray:
    """(G - 1) tau of a torque every millisecond (N·m) that begins at rest, shape (n,)."""
    w = 2.0 * np.pi * hz
    frame = ([2.0 * damping * w, w**2], [1.0, 2.0 * damping * w, w**2])
    numerator, denominator, _ = scipy.signal.cont2discrete(frame, STEP_S, method="foh")
    return scipy.signal.lfilter(np.ravel(numerator), denominator, torque) - torque


def epoch_time() -> np.ndarray:
    """Time of an epoch from the onset, shape (n,) (s)."""
    return np.arange(-round(BEFORE_S * RATE_HZ), round(AFTER_S * RATE_HZ) + 1) / RATE_HZ


def baseline_samples(time: np.ndarray) -> np.ndarray:
    """Samples of the baseline, shape (n,): the first tenth of a second of the epoch (s)."""
    return time <= time[0] + BASELINE_S


def noise_moments(design: StandingDesign) -> np.ndarray:
    """Moments of sway and noise in torque, angle and rate of an epoch, relative to its baseline.

    Shape (3, 3, n, n), in products of the units (N·m, rad, rad/s). Sway is in the torque alone.
    """
    time = epoch_time()
    moments = np.zeros((3, 3, time.size, time.size))
    moments[0, 0] = stationary_covariance(design, time.size)
    moments[1:, 1:] = angle_covariance(design, time.size)
    mean = np.where(baseline_samples(time), 1.0 / baseline_samples(time).sum(), 0.0)
    relative = np.eye(time.size) - mean
    return relative @ moments @ relative.T


def angle_covariance(design: StandingDesign, samples: int) -> np.ndarray:
    """Covariance of the cameras' noise in angle (rad) and rate (rad/s), shape (2, 2, samples, samples)."""
    passed = _passed(design, samples)
    time = np.arange(samples + 2 * MARGIN) / RATE_HZ
    both = np.stack([passed, derivative(time, passed)])[:, MARGIN:-MARGIN]
    # the faster the cameras, the wider the band over which the noise is spread
    size = design.angle_per_marker * design.marker_noise_m * np.sqrt(RATE_HZ / design.camera_rate_hz)
    return size**2 * np.einsum("ant,bmt->abnm", both, both)


def _passed(design: StandingDesign, samples: int) -> np.ndarray:
    """Low-pass of so many samples and a margin on both sides as a matrix, (samples + 2 margins,) twice."""
    return butterworth_lowpass(np.eye(samples + 2 * MARGIN), RATE_HZ, design.cutoff_hz, ORDER)


def stationary_covariance(design: StandingDesign, samples: int) -> np.ndarray:
    """Covariance of sway and noise at regular samples, shape (samples, samples), in squared units (N·m)."""
    lag = np.abs(np.subtract.outer(np.arange(samples), np.arange(samples))) / RATE_HZ / design.sway_s
    smooth = design.sway_Nm**2 * (1.0 + lag) * np.exp(-lag)
    passed = _passed(design, samples)[MARGIN:-MARGIN]
    noise = passed @ passed.T
    return smooth + design.noise_Nm**2 * noise / noise.diagonal().mean()
