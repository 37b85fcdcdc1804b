"""Planned experiment: joint, leg and foot, rig, protocol; and its motion without noise."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Annotated, Literal, Self

import numpy as np
from annotated_types import Ge, Gt, Le

from tepsipe.arguments import check_options, options_of
from tepsipe.errors import InputError
from tepsipe.experiments.planning.pulses import STEP_S, Drive, Pulse, pulse_of
from tepsipe.mechanics.engines.interface import Joint
from tepsipe.mechanics.forward_dynamics import ForwardSimulation, simulate_dummy
from tepsipe.mechanics.inverse_dynamics import Foot, Leg
from tepsipe.mechanics.segment_kinematics import SegmentMarkers
from tepsipe.quantities import Delay, Frequency, NotNegative, Rate, Time, Velocity
from tepsipe.signals.filters import Lowpass
from tepsipe.signals.perturbations import Perturbation, find_perturbations
from tepsipe.statistics.uncertainty import Source, sources_of

JOINT_LIKELIHOOD, JOINT_LIKELIHOOD_LINEAR, LEG, FOOT = (
    "joint-likelihood",
    "joint-likelihood-linear",
    "leg",
    "foot",
)
Rest = Annotated[float, Ge(1), Le(3600)]  # s
# pathways of a plan: two likelihoods, and windowed least squares with the torque from leg or foot
PATHWAYS = (JOINT_LIKELIHOOD, JOINT_LIKELIHOOD_LINEAR, LEG, FOOT)
# the ankle and four markers spread over the rod: anterior and longitudinal offset from the ankle (m)
LEG_MARKERS = SegmentMarkers(
    ("ankle", "leg1", "leg2", "leg3", "leg4"),
    np.array([[0.0, 0.0], [-0.012, 0.87], [0.012, 0.63], [-0.012, 0.39], [0.012, 0.15]]),
)


def _positive(where: str, values: Mapping[str, float | None], least: float = math.ulp(0.0)) -> None:
    for name, value in values.items():
        if value is not None and not (math.isfinite(value) and value >= least):
            what = "a positive number" if least > 0.0 else "a number of at least 0"
            raise InputError(f"{where}: expected {what} for {name}, found {value:g}: correct it")


@dataclass(frozen=True, kw_only=True)
class Rig:
    """Instruments and drive; noise is white, and given as the standard deviation of one sample."""

    leg_markers: SegmentMarkers = LEG_MARKERS
    """Markers on the leg (m); the first is the ankle's."""
    foot_markers: Annotated[int, Ge(1)] = 3
    """Markers on the foot, in addition to that on the ankle."""
    marker_noise_m: Annotated[float, Gt(0), Le(0.1)] = 6.5e-6
    """Noise of a marker in each direction."""
    camera_rate_hz: Annotated[float, Ge(80), Le(100000)] = 250.0
    """Rate of the cameras; signals up to 30 Hz are fitted."""
    log_noise_m_per_s: Velocity = 0.001
    """Noise of the logged belt velocity."""
    log_rate_hz: Rate = 1000.0
    """Rate of the log."""
    force_noise_N: NotNegative = 0.2
    """Noise of the plate's forces."""
    moment_noise_Nm: NotNegative = 0.05
    """Noise of the plate's moments."""
    plate_rate_hz: Rate = 1000.0
    """Rate of the plate."""
    sync_jitter_s: Delay = 0.00015
    """Standard uncertainty of the time between plate and cameras."""
    drive: Drive = field(default_factory=Drive)

    def __post_init__(self):
        """Refuse impossible rigs."""
        check_options(Rig, self, "rig")
        for name in ("log_rate_hz", "plate_rate_hz"):
            if getattr(self, name) < self.camera_rate_hz:
                raise InputError(
                    f"rig: expected a {name} of at least camera_rate_hz ({self.camera_rate_hz:g} Hz), found "
                    f"{getattr(self, name):g} Hz: correct one of the two"
                )

    @property
    def log_noise_of_sample_m_per_s(self) -> float:
        """Noise of the log after low-pass and resampling at the rate of the cameras (m/s)."""
        return self.log_noise_m_per_s * math.sqrt(self.camera_rate_hz / self.log_rate_hz)


@dataclass(frozen=True, kw_only=True)
class Protocol:
    """Perturbations of a trial and their analysis."""

    pulse: Pulse
    """The belt's command (m/s)."""
    number: Annotated[int, Ge(1)] = 14
    """Number of perturbations."""
    interval_s: Time = 4.0
    """Time from onset to onset."""
    rest_before_s: Rest = 3.0
    """Unperturbed time before them."""
    rest_after_s: Rest = 3.0
    """Unperturbed time after them."""
    pathway: Literal[PATHWAYS] = JOINT_LIKELIHOOD
    """Estimator."""
    cutoff_hz: Frequency = 20.0
    """Low-pass of `leg` and `foot`."""
    order: Annotated[int, Ge(1)] = 4
    """Its order."""
    zero_lag: bool = True
    """True for a zero-lag filter."""

    def __post_init__(self):
        """Refuse impossible protocols."""
        check_options(Protocol, self, "protocol")
        if self.interval_s < self.pulse.duration_s + 0.1:
            raise InputError(
                "protocol: expected an interval_s that leaves 0.1 s of rest after a pulse of "
                f"{self.pulse.duration_s:g} s, found {self.interval_s:g} s: lengthen the interval"
            )
        if self.zero_lag and self.order % 2:
            raise InputError(
                f"protocol: expected an even order, both passes together, found {self.order}: change it"
            )

    @property
    def lowpass(self) -> Lowpass:
        """Filter of windowed least squares (Hz)."""
        return Lowpass(self.cutoff_hz, self.order, self.zero_lag)

    @property
    def onsets_s(self) -> np.ndarray:
        """Commanded onsets of the pulses (s), shape (number,)."""
        return self.rest_before_s + self.interval_s * np.arange(self.number)

    @property
    def signs(self) -> np.ndarray:
        """Direction of every pulse, shape (number,): one-way pulses alternate."""
        return np.where(np.arange(self.number) % 2, -1.0, 1.0) if self.pulse.one_way else np.ones(self.number)

    @property
    def lasts_s(self) -> float:
        """Length of the trial (s)."""
        return self.rest_before_s + self.interval_s * self.number + self.rest_after_s


@dataclass(frozen=True, kw_only=True)
class Design:
    """A planned experiment."""

    joint: Joint
    """Expected I, B, K (N·m·s²/rad, N·m·s/rad, N·m/rad)."""
    leg: Leg
    """Mechanical parameters (kg, m, kg·m²)."""
    rig: Rig
    """Instruments and drive."""
    protocol: Protocol
    """Perturbations and their analysis."""
    foot: Foot = field(default_factory=lambda: Foot(mass_kg=2.1, height_m=0.055))
    sources: Mapping[str, Source] = field(default_factory=dict)
    """Tolerances of the calibration, as of the uncertainty budgets; none: no Type B."""

    @classmethod
    def from_settings(cls, plan: dict, name: str, geometry: dict, uncertainty: dict) -> Self:
        """Design of a name in a plan, with its changes of joint, rig and protocol.

        ``geometry`` has the constants of leg and foot (kg, m, kg·m²), ``uncertainty`` the tolerances.
        """
        joint, rig, protocol = (
            plan[part] | plan["designs"][name].get(part, {}) for part in ("joint", "rig", "protocol")
        )
        pulse = pulse_of(*(protocol.pop(key) for key in ("profile", "amplitude_m_per_s", "duration_s")))
        return cls(
            joint=Joint(**joint),
            leg=Leg.from_settings(geometry),
            foot=Foot.from_settings(geometry),
            rig=options_of(Rig, rig),
            protocol=Protocol(pulse=pulse, **protocol),
            sources=sources_of(uncertainty),
        )

    def __post_init__(self):
        """Refuse a joint on which the leg does not stand, and an impossible foot."""
        joint, critical = self.joint, self.leg.mass_kg * self.leg.gravity_m_per_s2 * self.leg.com_m
        for name in ("inertia_Nms2_per_rad", "damping_Nms_per_rad"):
            _positive("joint", {name: getattr(joint, name)}, 0.0)
        _positive("foot", vars(self.foot))
        if not (math.isfinite(joint.stiffness_Nm_per_rad) and joint.stiffness_Nm_per_rad > critical):
            raise InputError(
                f"joint: expected a stiffness above the critical one, m g r = {critical:.3g} Nm/rad, found "
                f"{joint.stiffness_Nm_per_rad:g} Nm/rad, with which the leg falls: correct one of them"
            )
        if not self.protocol.cutoff_hz < 0.5 * self.rig.camera_rate_hz:
            raise InputError(
                "protocol: expected a cutoff_hz below half the camera_rate_hz "
                f"({0.5 * self.rig.camera_rate_hz:g} Hz), found {self.protocol.cutoff_hz:g} Hz: lower it"
            )

    @property
    def parameters(self) -> np.ndarray:
        """I, B, K, shape (3,) (N·m·s²/rad, N·m·s/rad, N·m/rad)."""
        joint = self.joint
        return np.array([joint.inertia_Nms2_per_rad, joint.damping_Nms_per_rad, joint.stiffness_Nm_per_rad])


def belt_velocity(
    protocol: Protocol,
    pulse_velocity: Annotated[np.ndarray, "(k,)", "m/s"],
    time: Annotated[np.ndarray, "(n,)", "s"],
) -> Annotated[np.ndarray, "(n,)", "m/s"]:
    """Velocity of the belt over a trial (m/s), shape (n,).

    protocol: onsets and directions of the pulses.
    pulse_velocity: velocity of the belt after one of them, every `STEP_S`.
    Returns: sum over the pulses.
    """
    elapsed = STEP_S * np.arange(pulse_velocity.size)
    velocity = np.zeros(time.size)
    for onset, sign in zip(protocol.onsets_s, protocol.signs, strict=True):
        first, last = np.searchsorted(time, [onset, onset + elapsed[-1]])
        pulse_samples = slice(first, last + 1)
        velocity[pulse_samples] += sign * np.interp(
            time[pulse_samples] - onset, elapsed, pulse_velocity, right=0.0
        )
    return velocity


@dataclass(frozen=True)
class ExpectedMotion:
    """Expected motion of a trial, without noise."""

    simulated: ForwardSimulation
    """Motion and forces at the instants of the cameras (s, rad, m, N, N·m)."""
    perturbations: list[Perturbation]
    """Windows as the analysis finds them (samples)."""
    at_rest: np.ndarray
    """Samples before the first pulse."""
    pulse_velocity: Annotated[np.ndarray, "(k,)", "m/s"]
    """Velocity of the belt after one pulse, every `STEP_S`."""

    @property
    def time(self) -> np.ndarray:
        """Instants (s), shape (n,)."""
        return self.simulated.time


def expected_motion(design: Design) -> ExpectedMotion:
    """Simulate the planned trial.

    Returns: at the instants of the cameras.
    """
    rig, protocol = design.rig, design.protocol
    time = np.arange(round(protocol.lasts_s * rig.camera_rate_hz)) / rig.camera_rate_hz
    pulse_velocity = rig.drive.follow(protocol.pulse.velocity_m_per_s)
    velocity = belt_velocity(protocol, pulse_velocity, time)
    stride = math.ceil(1.0 / (rig.camera_rate_hz * STEP_S) - 1e-9)
    step = 1.0 / (rig.camera_rate_hz * stride)
    simulated = simulate_dummy(time, velocity, design.leg, design.foot, design.joint, step, "equations")
    if simulated.fell_at_s is not None:
        raise InputError(
            "protocol: expected a leg that stays upright, found that it falls "
            f"{simulated.fell_at_s:.3g} s after the start: plan smaller pulses"
        )
    before, after = protocol.rest_before_s - 0.5, protocol.rest_after_s - 0.5
    windows = find_perturbations(
        time, velocity, rest_before_s=before, rest_after_s=after, cutoff_hz=protocol.cutoff_hz
    )
    return ExpectedMotion(simulated, windows, time < before, pulse_velocity)


def exact_markers(design: Design, motion: ExpectedMotion) -> tuple[np.ndarray, list[str], tuple[str, ...]]:
    """Markers of a trial without noise.

    Returns:
        positions: y along the belt, z up (m), from the ankle at rest. Shape (n, k, 2).
        labels: names of the markers.
        belt_fixed: those that move with the foot.
    """
    markers, rig = design.rig.leg_markers, design.rig
    theta, foot = motion.simulated.theta, motion.simulated.foot_y
    fixed = tuple(f"foot{k + 1}" for k in range(rig.foot_markers))
    offsets = np.zeros((rig.foot_markers, 2))
    across, along = np.vstack([offsets, markers.layout_m]).T
    y = foot[:, None] + np.outer(np.cos(theta), across) + np.outer(np.sin(theta), along)
    z = np.outer(np.cos(theta), along) - np.outer(np.sin(theta), across)
    return np.stack([y, z], axis=2), [*fixed, *markers.labels], (*fixed, markers.labels[0])
