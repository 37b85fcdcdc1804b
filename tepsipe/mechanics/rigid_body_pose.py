"""Rigid-body pose of a segment from its markers in the sagittal plane (thesis section 3-1-2).

y points forward along the belt, z up. theta is a segment's angle from the vertical, positive when
the segment tips towards +y. A point with the anterior offset ``across`` from the axis of the segment
and the longitudinal offset ``along`` from its origin is at

    y = y_0 + across cos theta + along sin theta
    z = z_0 - across sin theta + along cos theta
"""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class SegmentPose:
    """Pose of a rigid segment over time.

    Attributes
    ----------
    angle : ndarray, shape (n,)
        theta (rad).
    point : ndarray, shape (n, 2)
        y, z of the wanted point of the segment (m).
    marker_residual_rms_m : float
        Root mean square distance between markers and the rigid segment (m).
    """

    angle: np.ndarray
    point: np.ndarray
    marker_residual_rms_m: float


def fit_rigid_segment(markers: np.ndarray, layout: np.ndarray, point: np.ndarray) -> SegmentPose:
    """Least-squares pose of a rigid segment from its markers (Söderkvist & Wedin 1993, in the plane).

    Parameters
    ----------
    markers : ndarray, shape (n, k, 2)
        y, z of the segment's k >= 2 markers (m).
    layout : ndarray, shape (k, 2)
        Anterior and longitudinal offset of each marker in the segment (m).
    point : ndarray, shape (2,)
        Anterior and longitudinal offset of the wanted point, for example the centre of mass (m).

    Returns
    -------
    SegmentPose
        Angle (rad), position of the point (m) and marker residual RMS (m).
    """
    centre = layout.mean(axis=0)
    across, along = (layout - centre).T
    middle = markers.mean(axis=1)
    y, z = np.moveaxis(markers - middle[:, None], 2, 0)
    angle = np.arctan2(y @ along - z @ across, y @ across + z @ along)
    cosine, sine = np.cos(angle), np.sin(angle)
    offset = point - centre
    position = middle + np.column_stack(
        [offset[0] * cosine + offset[1] * sine, -offset[0] * sine + offset[1] * cosine]
    )
    error_y = y - np.outer(cosine, across) - np.outer(sine, along)
    error_z = z + np.outer(sine, across) - np.outer(cosine, along)
    residual_rms = float(np.sqrt(np.mean(error_y**2 + error_z**2)))
    return SegmentPose(angle, position, residual_rms)
