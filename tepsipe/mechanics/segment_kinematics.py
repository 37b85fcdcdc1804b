"""Motion of a body segment from its markers (thesis section 3-1-2)."""

from dataclasses import dataclass

import numpy as np

from tepsipe.errors import InputError
from tepsipe.mechanics.rigid_body_pose import fit_rigid_segment
from tepsipe.signals.differentiation import derivative
from tepsipe.signals.filters import butterworth_lowpass


@dataclass(frozen=True)
class SegmentMarkers:
    """Markers of a segment and their offsets.

    Attributes
    ----------
    labels : tuple of str
        Markers on the segment.
    layout_m : ndarray, shape (k, 2)
        Anterior offset from the axis of the segment, and longitudinal offset from its origin (the ankle, for
        a leg) (m).
    """

    labels: tuple[str, ...]
    layout_m: np.ndarray


@dataclass(frozen=True)
class SegmentMotion:
    """Motion of the leg during a trial.

    Attributes
    ----------
    time : ndarray, shape (n,)
        Instants (s).
    theta, theta_d, theta_dd : ndarray, shape (n,)
        Leg angle (rad), its rate (rad/s) and acceleration (rad/s²).
    y_dd, z_dd : ndarray, shape (n,)
        Acceleration of the leg's centre of mass (m/s²).
    marker_residual_rms_m : float
        Root mean square distance between markers and the rigid leg (m).
    """

    time: np.ndarray
    theta: np.ndarray
    theta_d: np.ndarray
    theta_dd: np.ndarray
    y_dd: np.ndarray
    z_dd: np.ndarray
    marker_residual_rms_m: float


def segment_motion(
    time: np.ndarray,
    positions: np.ndarray,
    labels: list[str],
    markers: SegmentMarkers,
    com_m: float,
    rate_hz: float,
    cutoff_hz: float,
    order: int,
) -> SegmentMotion:
    """Filter the markers, fit the rigid leg and differentiate.

    Parameters
    ----------
    time : ndarray, shape (n,)
        Instants (s).
    positions : ndarray, shape (n, all markers, 3)
        Marker positions x, y, z (m).
    labels : list of str
        Names of all markers.
    markers : SegmentMarkers
        Which of them are on the leg, and where (m).
    com_m : float
        Distance of the leg's centre of mass from the ankle (m).
    rate_hz, cutoff_hz : float
        Sampling rate and cutoff of the low-pass filter (Hz).
    order : int
        Order of the filter, both passes together (-).

    Returns
    -------
    SegmentMotion
        Angle and accelerations (rad, m, s).

    Raises
    ------
    InputError
        If a marker of the leg is not among ``labels``, or the markers do not move as one body.
    """
    filtered = butterworth_lowpass(marker_positions(positions, labels, markers), rate_hz, cutoff_hz, order)
    return motion_of_markers(time, filtered, markers, com_m)


def marker_positions(positions: np.ndarray, labels: list[str], markers: SegmentMarkers) -> np.ndarray:
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


def motion_of_markers(
    time: np.ndarray, filtered: np.ndarray, markers: SegmentMarkers, com_m: float
) -> SegmentMotion:
    """Fit the rigid leg to markers that are filtered already, and differentiate.

    Parameters
    ----------
    time : ndarray, shape (n,)
        Instants (s).
    filtered : ndarray, shape (n, k, 2)
        y, z of the leg's markers (m).
    markers : SegmentMarkers
        Where they sit (m).
    com_m : float
        Distance of the leg's centre of mass from the ankle (m).

    Returns
    -------
    SegmentMotion
        Angle and accelerations (rad, m, s).

    Raises
    ------
    InputError
        If the markers do not move as one body.
    """
    pose = fit_rigid_segment(filtered, markers.layout_m, np.array([0.0, com_m]))
    if pose.marker_residual_rms_m > 0.01:
        raise InputError(
            f"expected the leg's markers to move as one rigid body, found them "
            f"{1e3 * pose.marker_residual_rms_m:.3g} mm from it on average: check the markers' "
            "layout and order in the configuration"
        )
    theta_d = derivative(time, pose.angle)
    velocity = derivative(time, pose.point)
    acceleration = derivative(time, velocity)
    return SegmentMotion(
        time=time,
        theta=pose.angle,
        theta_d=theta_d,
        theta_dd=derivative(time, theta_d),
        y_dd=acceleration[:, 0],
        z_dd=acceleration[:, 1],
        marker_residual_rms_m=pose.marker_residual_rms_m,
    )
