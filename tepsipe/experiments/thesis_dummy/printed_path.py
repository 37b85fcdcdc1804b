"""The thesis's path from a moving dummy to its printed numbers, without a laboratory.

A candidate joint is moved by the belt of a trial, its markers are sampled one after another, and the printed
equations are applied (thesis section 3-1-2, eqs 3-8 and 3-9), to find what the thesis would have printed.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import Annotated

import numpy as np
import scipy

from tepsipe.identification.regression.windows import WindowedFits, regress_torque
from tepsipe.io.trial import Trial
from tepsipe.mechanics.inverse_dynamics import Leg, leg_pathway_torque
from tepsipe.mechanics.rubber_joint import RubberJoint, swing
from tepsipe.mechanics.segment_kinematics import SegmentMarkers, segment_motion
from tepsipe.signals.filters import Lowpass, butterworth_lowpass
from tepsipe.signals.perturbations import Perturbation, WindowOptions, rest_samples
from tepsipe.treadmill.prepared import prepare_trial

BEFORE_S, AFTER_S = 0.1, 0.3  # of the pulse that is averaged, around its onset and after its end


@dataclass(frozen=True)
class PrintedPath:
    """The thesis's processing of the dummy, and its constants of the dummy."""

    leg: Leg
    """Table 2-2 (kg, m, kg·m²)."""
    markers: SegmentMarkers
    """Markers on the leg and their offsets (m)."""
    sampled_after_s: Annotated[np.ndarray, "(markers,)"]
    """Sampling time of each marker within a frame (s); zeros if all are sampled at once."""
    rate_hz: float
    """Frames per second."""
    cutoff_hz: float
    order: int
    """Zero-lag Butterworth filter."""
    window: WindowOptions
    """Search for perturbations and rest (s)."""


@dataclass(frozen=True)
class BeltMotion:
    """Motion of the foot in one condition, with measurement noise reduced by averaging."""

    time: Annotated[np.ndarray, "(n,)", "s"]
    """Frames."""
    velocity: Annotated[np.ndarray, "(n,)", "m/s"]
    position: "scipy.interpolate.PPoly"
    """Motion of the foot (m/s, m)."""
    acceleration: Annotated[np.ndarray, "(2 n - 1,)", "m/s²"]
    """At frames and halfway between them."""
    perturbations: list[Perturbation]
    """Windows (samples)."""

    @cached_property
    def _known(self) -> dict[float, np.ndarray]:
        return {}

    def position_after(self, late_s: float) -> np.ndarray:
        """Position of the foot (m), shape (n - 2,), a time after all frames but the first and the last.

        It is evaluated once and cached, because a search needs it hundreds of times.
        """
        if late_s not in self._known:
            self._known[late_s] = self.position(self.time[1:-1] + late_s)
        return self._known[late_s]


def belt_motion(trial: Trial, path: PrintedPath, longest_s: float = np.inf) -> BeltMotion:
    """The mean pulse of a trial at each of its onsets; the belt rests in between.

    longest_s: pulses that begin later are left out, and the trial ends with their rest (s): mean parameters
    change little, and less is to be simulated.
    Returns: with as many pulses as the trial, or as begin early enough.
    """
    rate, recorded = trial.rate_hz, trial.values("belt_velocity").astype(float)
    lowpass = Lowpass(path.cutoff_hz, path.order, True)
    perturbations = prepare_trial(trial, "belt velocity", lowpass, path.window).perturbations
    before = int(BEFORE_S * rate)
    length = before + max(p.stop - p.start for p in perturbations) + int(AFTER_S * rate)
    pulses = np.array([recorded[p.start - before : p.start - before + length] for p in perturbations])
    pulse = pulses.mean(axis=0)
    pulse -= np.linspace(pulse[:3].mean(), pulse[-3:].mean(), length)
    perturbations = [p for p in perturbations if p.start < longest_s * rate] or perturbations[:1]
    last = perturbations[-1].start - before + length + int(path.window.rest_after_s * rate)
    velocity = np.zeros(min(recorded.size, last))
    for p in perturbations:
        velocity[p.start - before : p.start - before + length] = pulse
    time = np.arange(velocity.size) / rate
    spline = scipy.interpolate.CubicSpline(time, velocity)
    halves = np.arange(2 * velocity.size - 1) / (2.0 * rate)
    return BeltMotion(
        time=time,
        velocity=butterworth_lowpass(velocity, rate, path.cutoff_hz, path.order),
        position=spline.antiderivative(),
        acceleration=spline(halves, 1),
        perturbations=perturbations,
    )


def swings(path: PrintedPath, joints: list[RubberJoint], belts: dict[str, BeltMotion]) -> dict:
    """Angle (rad) of the leg by condition, shape (joints, frames); trials may differ in length."""
    longest = max(belt.acceleration.size for belt in belts.values())
    pushes = np.array(
        [np.pad(belt.acceleration, (0, longest - belt.acceleration.size)) for belt in belts.values()]
    )
    angles = swing(path.leg, joints, pushes, 1.0 / path.rate_hz)
    return {name: angles[:, k, : belt.time.size] for k, (name, belt) in enumerate(belts.items())}


def printed_fits(
    path: PrintedPath,
    belt: BeltMotion,
    theta: Annotated[np.ndarray, "(n,)", "rad"],
    marker_noise_m: float = 0.0,
    rng: np.random.Generator | None = None,
    lag_s: float = 0.0,
) -> WindowedFits:
    """I, B, K and their measures of fit by the thesis's method.

    theta: angle of the leg.
    marker_noise_m: standard deviation of white noise on each coordinate.
    lag_s: time by which the translation of the leg is read after its rotation.
    Returns: as printed: torque with the thesis's signs, not referred to rest.
    """
    angle = scipy.interpolate.CubicSpline(belt.time, theta)
    frames = belt.time[1:-1]  # the last marker is sampled after its frame
    positions = np.empty((frames.size, len(path.markers.labels), 2))
    for k, (after, (anterior, longitudinal)) in enumerate(
        zip(path.sampled_after_s, path.markers.layout_m, strict=True)
    ):
        th = angle(frames + after)
        cosine, sine = np.cos(th), np.sin(th)
        positions[:, k, 0] = (
            belt.position_after(float(after) + lag_s) + anterior * cosine + longitudinal * sine
        )
        positions[:, k, 1] = longitudinal * cosine - anterior * sine
    if marker_noise_m:
        positions += marker_noise_m * rng.standard_normal(positions.shape)
    motion = segment_motion(
        frames, positions, path.markers, path.leg.com_m, cutoff_hz=path.cutoff_hz, order=path.order
    )
    torque = leg_pathway_torque("leg-thesis", path.leg, motion)
    windows = [Perturbation(p.start - 1, p.stop - 1, p.peak_m_per_s) for p in belt.perturbations]
    return regress_torque(motion, torque, windows, rest_samples(frames, path.window), thesis=True)
