"""Centre of the ankle joint from the motion of the shank over the foot.

The shank turns about the centre of the joint. A point fixed in it that lies a ahead of the centre and l
above it moves over the foot, as the ankle angle phi changes, at

    dy / dphi = l cos(phi) - a sin(phi),     dz / dphi = -a cos(phi) - l sin(phi)

so the motion of the assumed centre reveals its offset from the true one (Schwartz & Rozumalski 2005:
functional joint centres). In quiet sway soft tissue follows the bone, and the offset is the joint's. After a
perturbation it does not: the two centres differ by the wobble of the skin. A marker on the malleolus slips as
the ankle turns, so the centre is found from the markers that belong to shank or foot alone, where each has
two. The two apparent centres are compared including that marker, whose slip is in both.

The slopes are ratios of products with the angle, whose noise would attenuate them (errors in variables). In
quiet sway the products are therefore those of samples 0.2 s apart: sway hardly changes in that time, and
noise of the cameras is independent.
"""

from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np

from tepsipe.experiments.standing.options import Person
from tepsipe.io.trial import Trial
from tepsipe.mechanics.segment_kinematics import SegmentMarkers, SegmentPose, fit_rigid_segment
from tepsipe.signals.filters import Lowpass
from tepsipe.signals.resampling import runs_of

# cutoff between the sway of quiet standing and the noise of the markers (Hz)
SWAY_HZ = 3.0
# time after which noise of the cameras behind that filter is independent (s)
LAG_S = 0.2
# shortest stretch of quiet standing (s), and fewest stretches
STRETCH_S, FEWEST = 1.0, 3
# rotation of the forefoot over the hindfoot's on a compliant foot: halfway between a forefoot that
# stays flat on the belt and a rigid foot; Kern et al. (2019)
FOREFOOT_SHARE = 0.5


@dataclass(frozen=True)
class JointCentre:
    """Position of the centre of the ankle."""

    offset_m: Annotated[np.ndarray, "(2,)"]
    """Centre relative to the assumed one: anterior, longitudinal, in the shank as all its markers show it."""
    moving_m: Annotated[np.ndarray, "(2,)"]
    """Position by all markers of the shank, including the slip of markers shared with the foot."""
    own_m: Annotated[np.ndarray, "(2,)"]
    """In the shank as its own markers show it."""
    standard_error_m: Annotated[np.ndarray, "(2,)"]
    """From the scatter between stretches."""
    sway_rad: float
    foot_rad: float
    """Standard deviation of the ankle angle and of the foot's in quiet standing."""
    stretches: int
    """Number of stretches of quiet standing, or of perturbations."""


def relative_motion(
    positions: Annotated[np.ndarray, "(n, markers, 2)", "m"],
    labels: list[str],
    person: Person,
    *,
    exclusive: bool = False,
) -> Annotated[np.ndarray, "(n, 4)"]:
    """Ankle angle (rad), and position of the assumed centre, fixed in the shank, in axes of the foot (m).

    person: layout of the markers. The foot is located by its own ones, if it has two.
    exclusive: whether the shank is located by its own markers only, if it has two.
    Returns: phi (rad), y, z (m), angle of the foot (rad).
    """
    foot_angle, carried = hindfoot(positions, labels, person)
    if exclusive:
        shank = _exclusive_pose(positions, labels, person.shank, person.foot, np.zeros(2))
    else:
        columns = [labels.index(label) for label in person.shank.labels]
        shank = fit_rigid_segment(positions[:, columns], person.shank.layout_m, np.zeros(2))
    y, z = (shank.point - carried).T
    cosine, sine = np.cos(foot_angle), np.sin(foot_angle)
    return np.column_stack(
        [shank.angle - foot_angle, cosine * y - sine * z, sine * y + cosine * z, foot_angle]
    )


def hindfoot(
    positions: Annotated[np.ndarray, "(n, markers, 2)", "m"], labels: list[str], person: Person
) -> tuple[np.ndarray, np.ndarray]:
    """Rotation of the hindfoot (rad), shape (n,), and the assumed centre fixed in it (m), shape (n, 2).

    A marker ahead of the ankle rotates with the forefoot, by `FOREFOOT_SHARE` of the hindfoot's angle. The
    angles are small.

    person: layout of the markers. Those that the foot shares with the shank count only if it has less than
    two of its own.
    """
    segment = person.foot
    places = _exclusive_markers(segment, person.shank)
    layout = segment.layout_m[places]
    share = np.where(layout[:, 0] > 0.0, FOREFOOT_SHARE, 1.0)
    columns = np.zeros((len(places), 2, 3))
    columns[:, 0, 0] = columns[:, 1, 1] = 1.0
    columns[:, 0, 2], columns[:, 1, 2] = share * layout[:, 1], -share * layout[:, 0]
    displacement = positions[:, [labels.index(segment.labels[k]) for k in places]] - layout
    pose = displacement.reshape(len(displacement), -1) @ np.linalg.pinv(columns.reshape(-1, 3)).T
    return pose[:, 2], pose[:, :2]


def _exclusive_markers(segment: SegmentMarkers, other: SegmentMarkers) -> list[int]:
    """Markers of a segment that are not on another one; all of them if fewer than two are."""
    places = [k for k, label in enumerate(segment.labels) if label not in other.labels]
    return places if len(places) >= 2 else list(range(len(segment.labels)))


def _exclusive_pose(
    positions: np.ndarray,
    labels: list[str],
    segment: SegmentMarkers,
    other: SegmentMarkers,
    point: np.ndarray,
) -> SegmentPose:
    """Pose of a segment by the markers that belong to it alone; by all if there are fewer than two."""
    places = _exclusive_markers(segment, other)
    columns = [labels.index(segment.labels[k]) for k in places]
    return fit_rigid_segment(positions[:, columns], segment.layout_m[places], point)


def _centre(pieces: list[np.ndarray], mean_angle: float) -> JointCentre:
    """Slopes over all pieces, each about its own mean; standard error by the jackknife over pieces."""
    around = [piece - piece.mean(axis=0) for piece in pieces]
    return _slopes([(piece, piece) for piece in around], mean_angle)


def _centre_of_sway(pieces: list[np.ndarray], mean_angle: float, lag: int) -> JointCentre:
    """Slopes over all pieces, about the mean of all pieces, from products of samples ``lag`` samples apart.

    The mean of all pieces is common because a person drifts further between pieces than within one. The
    standard error is that of the jackknife over pieces.
    """
    middle = np.concatenate(pieces).mean(axis=0)
    return _slopes([(p[: len(p) - lag] - middle, p[lag:] - middle) for p in pieces], mean_angle)


def _slopes(pairs: list[tuple[np.ndarray, np.ndarray]], mean_angle: float) -> JointCentre:
    """Centre from the slopes of y and z over the angle; pairs of earlier and later samples of each piece."""
    # per piece: products of the angle with angle, y and z, square of the foot's angle, sums, samples
    parts = np.array(
        [
            np.r_[
                0.5 * (early[:, 0] @ late[:, :3] + late[:, 0] @ early[:, :3]),
                early[:, 3] @ late[:, 3],
                0.5 * (early + late).sum(axis=0),
                len(early),
            ]
            for early, late in pairs
        ]
    )
    total = parts.sum(axis=0)
    # a and l of the assumed point from its slopes; the centre lies the other way
    turn = _turn(mean_angle)

    def products(s: np.ndarray) -> np.ndarray:
        return s[..., :3] - s[..., 4:5] * s[..., 4:7] / s[..., 8:]

    def offset(s: np.ndarray) -> np.ndarray:
        about = products(s)
        return (about[..., 1:] / about[..., :1]) @ turn.T

    k = len(parts)
    left_out = offset(total - parts) if k > 1 else np.full((1, 2), np.nan)
    error = np.sqrt((k - 1.0) / k * ((left_out - left_out.mean(axis=0)) ** 2).sum(axis=0))
    centre, number = offset(total), total[8]
    sway, foot = products(total)[0] / number, total[3] / number - (total[7] / number) ** 2
    spread = [float(np.sqrt(max(0.0, square))) for square in (sway, foot)]
    return JointCentre(centre, centre, centre, error, *spread, k)


def _turn(angle: float) -> np.ndarray:
    """Matrix from the slopes of the assumed centre to the position of the centre, shape (2, 2)."""
    cosine, sine = np.cos(angle), np.sin(angle)
    return np.array([[sine, cosine], [-cosine, sine]])


def centre_from_sway(
    trial: Trial, person: Person, unperturbed: np.ndarray, hidden: Annotated[np.ndarray, "(n, markers)"]
) -> JointCentre | None:
    """Centre of the ankle from the quiet standing of a trial.

    person: layout of the markers, which defines the assumed centre.
    unperturbed: samples of quiet standing.
    hidden: true where a marker was hidden.
    Returns: none if there are too few stretches of quiet standing.
    """
    labels = trial.axes["marker"].tolist()
    positions = trial.values("marker_position")[:, :, 1:].astype(float)
    slow = Lowpass(SWAY_HZ, 4, True)(positions, trial.rate_hz)
    quiet = runs_of(unperturbed & ~hidden.any(axis=1))
    long = [(a, b) for a, b in quiet if b - a >= STRETCH_S * trial.rate_hz]
    if len(long) < FEWEST:
        return None
    seen = []
    for alone in (True, False):
        motion = relative_motion(slow, labels, person, exclusive=alone)
        pieces = [motion[a:b] for a, b in long]
        at_rest = float(np.mean([piece[:, 0].mean() for piece in pieces]))
        seen.append(_centre_of_sway(pieces, at_rest, round(LAG_S * trial.rate_hz)))
    by_shank, whole_shank = seen
    # the same point in the shank as all markers show it: on average over quiet standing
    columns = [labels.index(label) for label in person.shank.labels]
    whole = fit_rigid_segment(slow[unperturbed][:, columns], person.shank.layout_m, np.zeros(2))
    pose = _exclusive_pose(slow[unperturbed], labels, person.shank, person.foot, by_shank.offset_m)
    y, z = (pose.point - whole.point).T
    cosine, sine = np.cos(whole.angle), np.sin(whole.angle)
    offset = np.array([np.mean(y * cosine - z * sine), np.mean(y * sine + z * cosine)])
    return replace(by_shank, offset_m=offset, moving_m=whole_shank.offset_m)


def centre_from_pulses(
    motion: Annotated[np.ndarray, "(responses, n, 4)"], mean_angle: Annotated[float, "rad"]
) -> JointCentre:
    """Apparent centre from the responses to perturbations.

    motion: from `relative_motion`, in the epochs of the responses (rad, m).
    mean_angle: ankle angle in quiet standing.
    Returns: offset from the assumed centre, with the wobble of the skin in it.
    """
    return _centre(list(motion), mean_angle)


def tissue_from_pulses(
    motion: Annotated[np.ndarray, "(responses, n, 4)"],
    pattern: Annotated[np.ndarray, "(responses, n, 4)"],
    own_m: Annotated[np.ndarray, "(2,)"],
    mean_angle: Annotated[float, "rad"],
) -> float:
    """Motion of the soft tissue in the responses to perturbations, in units of a pattern.

    The pattern is fitted to the part of the shank's motion over the foot that a joint about the centre of
    quiet sway does not explain.

    motion: from `relative_motion` with the shank's own markers, less their baselines (rad, m).
    pattern: its change by the tissue (rad, m per unit).
    own_m: centre of quiet sway as these markers show it.
    mean_angle: ankle angle in quiet standing.
    """
    slopes = _turn(mean_angle).T @ own_m
    residual, shape = (x[..., 1:3] - x[..., :1] * slopes for x in (motion.mean(axis=0), pattern.mean(axis=0)))
    size = float((shape**2).sum())
    return float((residual * shape).sum()) / size if size > 0.0 else 0.0
