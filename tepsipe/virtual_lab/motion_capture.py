"""Active markers, strobed one after another, as the motion capture system records them."""

from dataclasses import dataclass

import numpy as np
from scipy.interpolate import CubicSpline

from tepsipe.virtual_lab.dummy import DummyMotion, DummyTruth


@dataclass(frozen=True)
class CaptureTruth:
    """Hidden constants of the motion capture system and of the markers' placement.

    Attributes
    ----------
    rate_hz, strober_hz : float
        Frames per second, and markers per second within a frame (Hz).
    latency_s : float
        From the trigger's edge to the first marker of the first frame (s).
    noise_m : float
        Standard deviation of each coordinate (m).
    occlusions_per_minute, occlusion_frames : float
        Mean number of occlusions of a marker per minute (1/min), mean length (frames).
    foot_markers_m : list of [along, up]
        Marker positions on the foot: forward of the ankle and above the belt (m).
    leg_markers_m : list of [across, along]
        Marker positions on the leg: in front of the rod's axis, and along it from the ankle (m).
    lateral_m : float
        Position of all markers across the belt, from the foot's middle (m).
    """

    rate_hz: float
    strober_hz: float
    latency_s: float
    noise_m: float
    occlusions_per_minute: float
    occlusion_frames: float
    foot_markers_m: list
    leg_markers_m: list
    lateral_m: float


def record_markers(
    capture: CaptureTruth,
    dummy: DummyTruth,
    motion: DummyMotion,
    trigger_s: float,
    frames: int,
    rng: np.random.Generator,
) -> np.ndarray:
    """Marker positions frame by frame: foot, ankle, leg.

    Parameters
    ----------
    capture, dummy : CaptureTruth, DummyTruth
        Constants (units in their names).
    motion : DummyMotion
        Exact motion of the rig (s, m, rad).
    trigger_s : float
        Time of the trigger's edge on the motion's clock (s).
    frames : int
        Number of frames (-).
    rng : numpy.random.Generator
        Draws noise and occlusions.

    Returns
    -------
    ndarray, shape (frames, 8, 3)
        x, y, z (m); NaN while a marker is hidden.
    """
    foot = [("foot", a, b) for a, b in capture.foot_markers_m]
    leg = [("leg", a, b) for a, b in capture.leg_markers_m]
    markers = [*foot, ("leg", 0.0, 0.0), *leg]
    belt = CubicSpline(motion.time, motion.belt_position)
    angle = CubicSpline(motion.time, motion.angle)
    first = trigger_s + capture.latency_s + np.arange(frames) / capture.rate_hz
    positions = np.empty((frames, len(markers), 3))
    for k, (segment, a, b) in enumerate(markers):
        instant = first + k / capture.strober_hz
        y = dummy.position_y_m + belt(instant)
        if segment == "foot":
            forward, up = a, b
        else:
            th = angle(instant)
            forward = a * np.cos(th) + b * np.sin(th)
            up = dummy.foot_height_m - a * np.sin(th) + b * np.cos(th)
        positions[:, k, 0] = dummy.position_x_m + capture.lateral_m
        positions[:, k, 1] = y + forward
        positions[:, k, 2] = up
    positions += capture.noise_m * rng.standard_normal(positions.shape)
    expected = capture.occlusions_per_minute * frames / capture.rate_hz / 60.0
    for k in range(len(markers)):
        for start in rng.integers(0, frames, rng.poisson(expected)):
            length = 1 + rng.poisson(capture.occlusion_frames - 1.0)
            positions[start : start + length, k] = np.nan
    return positions
