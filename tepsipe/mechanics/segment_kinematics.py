"""Pose and motion of a body segment from its markers in the sagittal plane (thesis section 3-1-2).

y points forward along the belt, z up. theta is a segment's angle from the vertical, positive when
the segment tips towards +y. A point with the anterior offset ``across`` from the axis of the segment
and the longitudinal offset ``along`` from its origin is at

    y = y_0 + across cos theta + along sin theta
    z = z_0 - across sin theta + along cos theta
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations
from typing import Annotated, Self

import numpy as np

from tepsipe.arguments import checked, regular_rate, same_length, samples, texts, within
from tepsipe.errors import InputError, listed, refuse_other_kind
from tepsipe.quantities import Offset
from tepsipe.signals.array_types import Samples
from tepsipe.signals.differentiation import derivative
from tepsipe.signals.filters import butterworth_lowpass

# markers further from a rigid segment than this do not belong to it (rms), and another layout explains them
# if this part of the distance remains
LOOSE_M, FITS_BETTER = 0.01, 0.3


@dataclass(frozen=True)
class SegmentMarkers:
    """Placement of the markers on a body segment.

    Attributes
    ----------
    labels : tuple of str
        Names of the markers on the segment.
    layout_m : ndarray, shape (k, 2)
        Anterior offset from the segment's axis, and longitudinal offset along it from the joint (m).

    Examples
    --------
    >>> import numpy as np
    >>> from tepsipe import SegmentMarkers
    >>> markers = SegmentMarkers(("ankle", "knee"), np.array([[0.0, 0.0], [0.01, 0.42]]))
    >>> markers.labels
    ('ankle', 'knee')
    """

    labels: tuple[str, ...]
    layout_m: np.ndarray

    @classmethod
    def from_settings(cls, markers: list[dict]) -> Self:
        """Markers of ``label``, ``anterior_offset_m`` and ``longitudinal_offset_m`` each (m)."""
        layout = [[marker["anterior_offset_m"], marker["longitudinal_offset_m"]] for marker in markers]
        return cls(tuple(marker["label"] for marker in markers), np.array(layout))

    def __post_init__(self):
        """Refuse a layout that does not determine the pose.

        Raises
        ------
        InputError
            If labels repeat, the layout has not one row of two numbers per label, or is not in metres.
        """
        object.__setattr__(self, "labels", tuple(texts(self.labels, "SegmentMarkers: labels")))
        layout = samples(self.layout_m, "m", "SegmentMarkers: layout_m", shape=(None, 2))
        object.__setattr__(self, "layout_m", layout)
        if len(self.labels) != len(layout) or len(set(self.labels)) != len(self.labels) or len(layout) < 2:
            raise InputError(
                f"SegmentMarkers: expected at least two different labels and as many rows of layout_m, found "
                f"{listed(self.labels)} and {len(layout)} rows: place every marker once"
            )
        if np.ptp(layout, axis=0).max() < 1e-3:
            raise InputError(
                f"SegmentMarkers: expected markers apart from each other, found all of them at "
                f"{layout[0].tolist()} m: their distance shows the angle"
            )
        if np.abs(layout).max() > within(Offset).high:
            raise InputError(
                f"SegmentMarkers: expected offsets in m, found {np.abs(layout).max():g}, which looks like "
                f"mm: "
                "divide layout_m by 1000"
            )


@dataclass(frozen=True)
class SegmentPose:
    """Pose of a rigid segment over time."""

    angle: Annotated[np.ndarray, "(n,)", "rad"]
    """theta."""
    point: Annotated[np.ndarray, "(n, 2)", "m"]
    """y, z of the wanted point of the segment."""
    marker_residual_rms_m: float
    """Root mean square distance between markers and the rigid segment."""
    layout_scale: float
    """Mean size of the measured layout over the stated one: the ratio s of the similarity that fits best."""


@dataclass(frozen=True)
class JointMotion:
    """Angle of a joint during a trial."""

    time: Annotated[np.ndarray, "(n,)", "s"]
    theta: np.ndarray
    theta_d: np.ndarray
    theta_dd: np.ndarray
    """Angle (rad), its rate (rad/s) and acceleration (rad/s2)."""


def joint_motion(time: np.ndarray, angle: np.ndarray) -> JointMotion:
    """Motion of a joint from its filtered angle (s, rad), both shape (n,)."""
    rate = derivative(time, angle)
    return JointMotion(time, angle, rate, derivative(time, rate))


@dataclass(frozen=True)
class SegmentMotion(JointMotion):
    """Motion of the leg during a trial: its angle, and the acceleration of its centre of mass.

    Attributes
    ----------
    y_dd, z_dd : ndarray, shape (n,)
        Acceleration of the leg's centre of mass (m/s2).
    marker_residual_rms_m : float
        Root mean square distance between markers and the rigid leg (m).
    layout_scale : float
        Size of the leg's markers as measured, over the size of their stated layout.
    recorded : mapping of str to ndarray, shape (n,)
        Positions of the leg's markers along the belt as recorded (m), by label; empty if unknown.
    """

    y_dd: np.ndarray
    z_dd: np.ndarray
    marker_residual_rms_m: float
    layout_scale: float = 1.0
    recorded: Mapping[str, np.ndarray] = field(default_factory=dict)


def segment_motion(
    time: "Samples",
    positions: "Samples",
    markers: SegmentMarkers,
    com_m: float,
    *,
    labels: Sequence[str] | None = None,
    cutoff_hz: float = 20.0,
    order: int = 4,
) -> SegmentMotion:
    """Filter the markers, fit the rigid segment and differentiate (thesis section 3-1-2).

    Parameters
    ----------
    time : array_like or Signal, shape (n,)
        Instants (s), on a regular clock.
    positions : array_like or Signal, shape (n, all markers, 3) or (n, all markers, 2)
        Marker positions x, y, z or y, z (m): y along the belt, z up.
    markers : SegmentMarkers
        Markers on the segment, and their positions (m).
    com_m : float
        Distance of the segment's centre of mass from the joint (m), for example ``leg.com_m``.
    labels : sequence of str, optional
        Names of all markers, in the order of ``positions``; the names in ``markers`` if left out.
    cutoff_hz : float
        Cutoff of the zero-lag Butterworth low-pass (Hz).
    order : int
        Its order, both passes together.

    Returns
    -------
    SegmentMotion
        Angle and accelerations (rad, m, s).

    Raises
    ------
    InputError
        If the signals cannot be used, a marker of the segment is not among ``labels``, or the markers do not
        move as one body.

    Examples
    --------
    >>> from tepsipe import load_example, segment_motion
    >>> dummy = load_example("dummy")
    >>> motion = segment_motion(
    ...     dummy.time, dummy.positions, dummy.markers, dummy.leg.com_m, labels=dummy.labels
    ... )
    >>> print(f"largest angle {motion.theta.max():.3f} rad")
    largest angle 0.015 rad
    """
    refuse_other_kind(markers, SegmentMarkers, "segment_motion", "SegmentMarkers")
    com_m, cutoff_hz, order = checked(com_m=com_m, cutoff_hz=cutoff_hz, order=order)
    time, rate_hz = regular_rate(time)
    positions = marker_samples(positions)
    same_length(time, positions=positions)
    labels = list(markers.labels) if labels is None else texts(labels, "labels")
    if len(labels) != positions.shape[1]:
        raise InputError(
            f"labels: expected {positions.shape[1]} names, one for each marker of positions, found "
            f"{len(labels)}: name all markers in their order"
        )
    if float(np.ptp(positions)) > 100.0:
        raise InputError(
            f"positions: expected metres, found a range of {np.ptp(positions):.3g}, which looks like mm: "
            f"give "
            'Signal(positions, "mm")'
        )
    on_segment = marker_positions(positions, labels, markers)
    filtered = butterworth_lowpass(on_segment, rate_hz, cutoff_hz, order)
    along_belt = dict(zip(markers.labels, on_segment[:, :, 0].T, strict=True))
    return replace(motion_of_markers(time, filtered, markers, com_m), recorded=along_belt)


def marker_samples(positions: object) -> np.ndarray:
    """Positions of markers (m), shape (n, all markers, 3) or (n, all markers, 2)."""
    found = samples(positions, "m", "positions", shape=None)
    if found.ndim != 3 or found.shape[2] not in (2, 3):
        raise InputError(
            f"positions: expected an array of shape (n, markers, 2) or (n, markers, 3), found {found.shape}: "
            "select or transpose its axes"
        )
    return found


def marker_positions(positions: np.ndarray, labels: list[str], markers: SegmentMarkers) -> np.ndarray:
    """y, z (m) of the segment's markers, shape (n, k, 2), out of all, shape (n, all markers, 2 or 3)."""
    missing = [label for label in markers.labels if label not in labels]
    if missing:
        raise InputError(
            f"expected a marker named {missing[0]!r} on the leg, found {', '.join(labels)}: "
            "correct the labels in dummy.geometry.leg_markers"
        )
    return positions[:, [labels.index(label) for label in markers.labels], -2:]


def motion_of_markers(
    time: Annotated[np.ndarray, "(n,)", "s"],
    filtered: Annotated[np.ndarray, "(n, k, 2)", "m"],
    markers: SegmentMarkers,
    com_m: float,
) -> SegmentMotion:
    """Fit the rigid leg to filtered markers, and differentiate.

    com_m: distance of the leg's centre of mass from the ankle.
    """
    pose = fit_rigid_segment(filtered, markers.layout_m, np.array([0.0, com_m]))
    refuse_loose(pose, filtered, markers, "leg")
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
        layout_scale=pose.layout_scale,
    )


def refuse_loose(
    pose: SegmentPose,
    positions: Annotated[np.ndarray, "(n, k, 2)", "m"],
    markers: SegmentMarkers,
    segment: str,
) -> None:
    """Raise InputError if the markers of a segment do not move as one rigid body with their layout.

    pose: of these positions.
    segment: name of the segment.
    """
    if pose.marker_residual_rms_m <= LOOSE_M:
        return
    mirrored = "the segment faces backward: reverse the forward axis, or the signs of the anterior offsets"
    layouts = {f"{mirrored} in the configuration": markers.layout_m * [-1.0, 1.0]}
    for one, other in combinations(range(len(markers.labels)), 2):
        order = np.arange(len(markers.labels))
        order[[one, other]] = other, one
        names = f"{markers.labels[one]!r} and {markers.labels[other]!r}"
        layouts[f"{names} are exchanged: correct their labels or places"] = markers.layout_m[order]
    loose = {
        change: fit_rigid_segment(positions, layout, np.zeros(2)).marker_residual_rms_m
        for change, layout in layouts.items()
    }
    change = min(loose, key=lambda name: loose[name])
    fits = min(LOOSE_M, FITS_BETTER * pose.marker_residual_rms_m)
    advice = f"they would fit if {change}" if loose[change] < fits else "check their layout and order"
    raise InputError(
        f"expected the markers of the {segment} to move as one rigid body, found them "
        f"{1e3 * pose.marker_residual_rms_m:.3g} mm from it on average: {advice}"
    )


def fit_rigid_segment(
    markers: Annotated[np.ndarray, "(n, k, 2)", "m"],
    layout: Annotated[np.ndarray, "(k, 2)", "m"],
    point: Annotated[np.ndarray, "(2,)", "m"],
) -> SegmentPose:
    """Least-squares pose of a rigid segment from its markers (Söderkvist & Wedin 1993, in the plane).

    markers: y, z of the segment's k >= 2 markers.
    layout: anterior and longitudinal offset of each marker in the segment.
    point: anterior and longitudinal offset of the wanted point, for example the centre of mass.
    Returns: angle, position of the point, marker residual RMS and scale of the layout.
    """
    centre = layout.mean(axis=0)
    across, along = (layout - centre).T
    middle = markers.mean(axis=1)
    y, z = np.moveaxis(markers - middle[:, None], 2, 0)
    turned, kept = y @ along - z @ across, y @ across + z @ along
    angle = np.arctan2(turned, kept)
    cosine, sine = np.cos(angle), np.sin(angle)
    offset = point - centre
    position = middle + np.column_stack(
        [offset[0] * cosine + offset[1] * sine, -offset[0] * sine + offset[1] * cosine]
    )
    error_y = y - np.outer(cosine, across) - np.outer(sine, along)
    error_z = z + np.outer(sine, across) - np.outer(cosine, along)
    residual_rms = float(np.sqrt(np.mean(error_y**2 + error_z**2)))
    scale = float(np.mean(np.hypot(turned, kept)) / np.sum((layout - centre) ** 2))
    return SegmentPose(angle, position, residual_rms, scale)
