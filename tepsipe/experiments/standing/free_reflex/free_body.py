"""The feet as a free body at a high cutoff, and the change of its torque with each source of uncertainty.

The estimator with a free reflex torque uses the first milliseconds of a response, where inertia and
friction of the belt dominate. All signals are low-pass filtered alike at a higher cutoff, and two terms of
the torque are computed in another way than at 20 Hz. The acceleration of the feet is that of the belt by its
encoder and of the frame below it by the force that moves it, because noise grows with frequency. The friction
of the belt follows the vertical force at each instant instead of the weight.

Centre of the ankle joint from the motion of the shank over the foot.

The shank turns about the centre of the joint. A point fixed in it that lies a ahead of the centre and l
above it moves over the foot, as the ankle angle phi changes, at

    dy / dphi = l cos(phi) - a sin(phi),     dz / dphi = -a cos(phi) - l sin(phi)

so the motion of the assumed centre reveals its offset from the true one (Schwartz & Rozumalski 2005:
functional joint centres). In quiet sway soft tissue follows the bone, and the offset is the joint's. After a
perturbation it does not: the two centres differ by the wobble of the skin. A marker on the malleolus slips as
the ankle turns, so the centre is found from the markers that belong to shank or foot alone, where each has
two. The two apparent centres are compared including that marker, whose slip is in both.

Rotation of the hindfoot, if the forefoot follows it by a share s. As the foot tilts by theta, a point that
lies (x, z) from the ankle moves

    by theta (z, -x) at the heel,     by s theta (z, -x) at the toes

Theta follows from all markers of the foot for a given s. If heel and toes are not in line with the ankle, it
also follows from them for any s, which is less precise, but free of the assumption. Their ratio is a constant
of a person (`tepsipe.experiments.standing.free_reflex.results`). Angles here are those for s =
`FOREFOOT_SHARE`, times a given ratio.

The slopes are ratios of products with the angle, whose noise would attenuate them (errors in variables). In
quiet sway the products are therefore those of samples 0.2 s apart: sway hardly changes in that time, and
noise of the cameras is independent.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Annotated, Self

import numpy as np
import scipy

from tepsipe.experiments.standing.joint_torque import (
    StandingTrial,
    by_belt,
    recordings_above_rest,
    segment_poses,
)
from tepsipe.experiments.standing.options import Person, StandingOptions
from tepsipe.io.trial import Trial
from tepsipe.mechanics.anthropometry import Feet
from tepsipe.mechanics.inverse_dynamics import PlateLoad, standing_torque
from tepsipe.mechanics.segment_kinematics import SegmentMarkers, SegmentPose, fit_rigid_segment
from tepsipe.signals.differentiation import degree_at, derivative
from tepsipe.signals.filters import Lowpass
from tepsipe.signals.resampling import runs_of
from tepsipe.signals.time_alignment import advanced
from tepsipe.treadmill.compensation import added_per_kg, compensated_draws, compensated_loads
from tepsipe.treadmill.prepared import PreparedTrial
from tepsipe.treadmill.registry import FittedModel
from tepsipe.treadmill.trial_recordings import COMPONENTS

# cutoff between the sway of quiet standing and the noise of the markers (Hz)
SWAY_HZ = 3.0
# time after which noise of the cameras behind that filter is independent (s)
LAG_S = 0.2
# shortest stretch of quiet standing (s), and fewest stretches
STRETCH_S, FEWEST = 1.0, 3
# rotation of the forefoot over the hindfoot's on a compliant foot: halfway between a forefoot that
# stays flat on the belt and a rigid foot; Kern et al. (2019)
FOREFOOT_SHARE = 0.5
# least distance of heel and toes from a line through the ankle that shows them apart (m)
LEAST_LEVER_M = 1e-3


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
    rotation: float = 1.0,
) -> Annotated[np.ndarray, "(n, 4)"]:
    """Ankle angle (rad), and position of the assumed centre, fixed in the shank, in axes of the foot (m).

    person: layout of the markers. The foot is located by its own ones, if it has two.
    exclusive: whether the shank is located by its own markers only, if it has two.
    rotation: as for `hindfoot`.
    Returns: phi (rad), y, z (m), angle of the foot (rad).
    """
    foot_angle, carried = hindfoot(positions, labels, person, rotation)
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
    positions: Annotated[np.ndarray, "(n, markers, 2)", "m"],
    labels: list[str],
    person: Person,
    rotation: float = 1.0,
) -> tuple[np.ndarray, np.ndarray]:
    """Rotation of the hindfoot (rad), shape (n,), and the assumed centre fixed in it (m), shape (n, 2).

    A marker ahead of the ankle rotates with the forefoot, by `FOREFOOT_SHARE` of the hindfoot's angle. The
    angles are small.

    person: layout of the markers. Those that the foot shares with the shank count only if it has less than
    two of its own.
    rotation: factor of the angle; the markers behind the ankle, if there are any, carry the centre.
    """
    displacement, layout = _foot_displacement(positions, labels, person)
    ahead = layout[:, 0] > 0.0
    angle = (
        rotation * _solved(displacement, _foot_columns(layout, np.where(ahead, FOREFOOT_SHARE, 1.0)))[:, 2]
    )
    carrying = slice(None) if ahead.all() else ~ahead
    lever = np.where(ahead, FOREFOOT_SHARE, 1.0)[:, None] * layout @ [[0.0, -1.0], [1.0, 0.0]]
    return angle, (displacement - angle[:, None, None] * lever)[:, carrying].mean(axis=1)


def parts_of_foot(
    positions: Annotated[np.ndarray, "(n, markers, 2)", "m"], labels: list[str], person: Person
) -> Annotated[np.ndarray, "(n, 2)", "rad"]:
    """Rotation of hindfoot and forefoot, each for itself; 0 where the markers do not determine both."""
    displacement, layout = _foot_displacement(positions, labels, person)
    columns = _columns_of_parts(layout)
    return np.zeros((len(displacement), 2)) if columns is None else _solved(displacement, columns)[:, 2:]


def rotation_per_place(person: Person) -> float | None:
    """Relative error of the rotation of `parts_of_foot` by errors of its markers' coordinates (1/m).

    Root of the sum of squares over all coordinates, for a rigid foot, where it is largest; None if the
    markers do not determine that rotation.
    """
    layout = person.foot.layout_m[_exclusive_markers(person.foot, person.shank)]
    if _columns_of_parts(layout) is None:
        return None
    tilted, changes = _foot_columns(layout, np.ones(len(layout)))[..., 2], []
    for k in range(layout.size):
        moved = layout.copy()
        moved.flat[k] += STEP_M
        columns = _columns_of_parts(moved)
        changes.append(np.inf if columns is None else (_solved(tilted[None], columns)[0, 2] - 1.0) / STEP_M)
    return float(np.linalg.norm(changes))


def _foot_displacement(
    positions: np.ndarray, labels: list[str], person: Person
) -> tuple[Annotated[np.ndarray, "(n, markers, 2)", "m"], Annotated[np.ndarray, "(markers, 2)", "m"]]:
    """Displacement of the foot's markers from their layout, and the layout."""
    places = _exclusive_markers(person.foot, person.shank)
    layout = person.foot.layout_m[places]
    return positions[:, [labels.index(person.foot.labels[k]) for k in places]] - layout, layout


def _foot_columns(layout: np.ndarray, *shares: np.ndarray) -> Annotated[np.ndarray, "(markers, 2, k)"]:
    """Displacement per displacement of the ankle, along the belt and up, and per angle of each part."""
    columns = np.zeros((len(layout), 2, 2 + len(shares)))
    columns[:, 0, 0] = columns[:, 1, 1] = 1.0
    for k, share in enumerate(shares, start=2):
        columns[:, 0, k], columns[:, 1, k] = share * layout[:, 1], -share * layout[:, 0]
    return columns


def _columns_of_parts(layout: np.ndarray) -> np.ndarray | None:
    """The same with an angle of the hindfoot and one of the forefoot; None if they are not independent."""
    ahead = (layout[:, 0] > 0.0).astype(float)
    columns = _foot_columns(layout, 1.0 - ahead, ahead)
    return columns if np.linalg.matrix_rank(columns.reshape(-1, 4), tol=LEAST_LEVER_M) == 4 else None


def _solved(displacement: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """Least-squares solution for every sample, shape (n, k)."""
    flat = columns.reshape(-1, columns.shape[-1])
    return displacement.reshape(len(displacement), -1) @ np.linalg.pinv(flat).T


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
    trial: Trial,
    person: Person,
    unperturbed: np.ndarray,
    hidden: Annotated[np.ndarray, "(n, markers)"],
    rotation: float = 1.0,
) -> JointCentre | None:
    """Centre of the ankle from the quiet standing of a trial.

    person: layout of the markers, which defines the assumed centre.
    unperturbed: samples of quiet standing.
    hidden: true where a marker was hidden.
    rotation: as for `hindfoot`.
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
        motion = relative_motion(slow, labels, person, exclusive=alone, rotation=rotation)
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


SIGNALS = ("torque", "ankle", "ankle_d")
# soft tissue on the shank: natural frequency (Hz) and damping ratio, as propagated
# (Wakeling & Nigg 2001: 10 to 20 Hz while the muscles are relaxed)
TISSUE_HZ, TISSUE_DAMPING = 12.0, 0.3
# belt speed at which the size of the tissue's motion is stated (m/s)
TISSUE_SPEED = 0.5
STEP_M = 1e-4
# offset to lower and higher frequencies, for the sensitivity to the frequency (Hz)
TISSUE_STEP_HZ = 1.0
# sources of Type B that move the signals, with the unit in which they deviate
SOURCES = (
    "joint_centre_anterior_m",
    "joint_centre_height_m",
    "foot_mass",
    "force_marker_delay_s",
    "skin_m",
    "tissue_hz",
    "marked_rotation",
    "foot_rotation",
    "force_scale",
    "moment_scale",
    "origin_height_m",
    "origin_anterior_m",
    "vertical_leak",
)


@dataclass(frozen=True)
class FreeBody:
    """Feet, plate and joint of one trial, low-pass filtered alike."""

    person: Person
    """Masses and lengths (kg, m)."""
    time: Annotated[np.ndarray, "(n,)", "s"]
    load: PlateLoad
    """Compensated load of the plate (N, N·m)."""
    load_d: PlateLoad
    """Its rate (N/s, N·m/s)."""
    shank: np.ndarray
    foot: np.ndarray
    parts: np.ndarray
    centre: np.ndarray
    foot_com: np.ndarray
    """Angles, shape (n,) and of hindfoot and forefoot (n, 2) (rad), and positions, shape (n, 2) (m)."""
    surface_dd: Annotated[np.ndarray, "(n,)", "m/s²"]
    """Acceleration of the belt's surface: of the belt by its log, and of the frame below it."""
    tissue: Annotated[np.ndarray, "(n, 3)"]
    """Change of the shank's angle (rad/m) and of the centre per metre of motion of the soft tissue."""
    near: tuple[np.ndarray, np.ndarray]
    """The same of soft tissue with a lower and a higher frequency, see `TISSUE_STEP_HZ`, shape (n, 3)."""
    draws: Annotated[np.ndarray, "(draws, n)", "N·m"]
    """Torque for every draw of the treadmill model's constants, relative to the best one."""
    skins_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Motion of the soft tissue that is subtracted if it has the assumed, lower or higher frequency."""

    def tilt(self) -> Annotated[np.ndarray, "(n, 4)"]:
        """Angle of the foot (rad) and its rate (rad/s), as in `signals`; angles of `parts_of_foot` (rad)."""
        degree = degree_at(1.0 / float(self.time[1] - self.time[0]))
        return np.column_stack([self.foot, derivative(self.time, self.foot, degree), self.parts])

    def signals(self, deviations: Mapping[str, float] | None = None) -> np.ndarray:
        """Torque of both ankles (N·m), ankle angle (rad) and its rate (rad/s), shape (n, 3).

        The motion of the soft tissue is subtracted.

        deviations: source, one of `SOURCES`, -> deviation from what is assumed: of the centre of the joint
        in the shank (m), of the forces' clock (s), of the soft tissue at a pulse of 0.5 m/s (m) and of its
        frequency (Hz), of the place of the plate's axes (m); relative for mass, scales and rotations; part
        of the vertical force in the fore-aft one.
        """
        off = dict.fromkeys(SOURCES, 0.0) | dict(deviations or {})
        skin_m, lower_m, higher_m = self.skins_m
        lower, higher = self.near
        per_hz = (lower_m * lower - higher_m * higher) / (2.0 * TISSUE_STEP_HZ)
        wobble = (off["skin_m"] - skin_m) * self.tissue + off["tissue_hz"] * per_hz
        late = off["force_marker_delay_s"]
        f_y, f_z, m_x = (
            getattr(self.load, key) + late * getattr(self.load_d, key) for key in ("f_y", "f_z", "m_x")
        )
        m_x = (
            (1.0 + off["moment_scale"]) * m_x + off["origin_height_m"] * f_y + off["origin_anterior_m"] * f_z
        )
        f_y = (1.0 + off["force_scale"]) * f_y + off["vertical_leak"] * f_z
        plate = PlateLoad(f_y, (1.0 + off["force_scale"]) * f_z, m_x)
        shank = self.shank + wobble[:, 0]
        sine, cosine = np.sin(self.shank), np.cos(self.shank)
        across, along = off["joint_centre_anterior_m"], off["joint_centre_height_m"]
        shift = np.column_stack([across * cosine + along * sine, along * cosine - across * sine])
        feet = self.person.feet
        scale = 1.0 + off["foot_mass"]
        # the feet move with belt and frame: their other accelerations are noise at this cutoff
        acceleration = np.column_stack([self.surface_dd, np.zeros_like(self.surface_dd)])
        torque = standing_torque(
            Feet(scale * feet.mass_kg, scale * feet.inertia_kgm2),
            self.person.body.gravity_m_per_s2,
            plate,
            self.centre + shift + wobble[:, 1:],
            self.foot_com,
            acceleration,
            np.zeros_like(self.surface_dd),
        )
        # a foot is not rigid: its markers follow part of the rotation below the ankle
        foot = (1.0 + off["foot_rotation"]) * self.foot
        ankle = (1.0 + off["marked_rotation"]) * (shank - foot)
        degree = degree_at(1.0 / float(self.time[1] - self.time[0]))
        return np.column_stack([torque, ankle, derivative(self.time, ankle, degree)])


def free_body(
    standing: StandingTrial,
    options: StandingOptions,
    lowpass: Lowpass,
    models: dict[str, FittedModel],
    offset_m: Annotated[np.ndarray, "(2,)"],
) -> FreeBody:
    """The feet of a standing person as a free body.

    standing: the trial with the filter of all signals.
    lowpass: filter of all signals here.
    models: component, Fy or Mx -> treadmill model; empty for the loads as measured. For a person with a
    foot on each belt: belt -> the same.
    offset_m: offset of the joint's centre from the assumed one, anterior and longitudinal in the shank.
    """
    prepared = standing.prepared.behind(lowpass)
    time, rate, person, labels = prepared.time, prepared.rate_hz, options.person, prepared.markers
    positions = prepared.filtered(prepared.trial.values("marker_position")[:, :, 1:].astype(float))
    origin = np.asarray(offset_m, dtype=float)
    poses = segment_poses(positions, labels, person, origin) | {
        "foot": hindfoot(positions, labels, person)[0],
        "parts": parts_of_foot(positions, labels, person),
    }
    # from where the belt starts: a detected start precedes it by the width of the filter
    onsets = tuple(np.searchsorted(time, standing.onsets_s).tolist())
    degree, gravity = degree_at(rate), person.body.gravity_m_per_s2
    of_plates = by_belt(models, options)
    plates = {
        belt: _Plate.of(prepared, belt, onsets, gravity, of_plates.get(belt, {})) for belt in options.belts
    }
    belt_dd = derivative(time, prepared.from_rest(prepared.belt_velocity), degree)
    # each foot on the frame below it
    surface_dd = belt_dd + np.mean([plate.frame_dd for plate in plates.values()], axis=0)
    peak = float(np.abs(standing.belt_velocity).max())
    tissues = []
    for hz in tissue_frequencies():
        shifted = positions.copy()
        shifted[..., 0] += STEP_M * tissue_motion(positions, labels, person, surface_dd, peak, rate, hz)
        shifted_poses = segment_poses(shifted, labels, person, origin)
        changed = [shifted_poses[key] - poses[key] for key in ("shank", "ankle_point")]
        tissues.append(advanced(time, np.column_stack(changed) / STEP_M, standing.delay_s))
    poses = {key: advanced(time, x, standing.delay_s) for key, x in poses.items()}
    table = sum(plate.loads for plate in plates.values())
    draws = sum(plate.torque_draws(poses["ankle_point"][:, 1]) for plate in plates.values())
    return FreeBody(
        person=person,
        time=time,
        load=PlateLoad(*table.T),
        load_d=PlateLoad(*derivative(time, table, degree).T),
        shank=poses["shank"],
        foot=poses["foot"],
        parts=poses["parts"],
        centre=poses["ankle_point"],
        foot_com=poses["foot_com"],
        surface_dd=surface_dd,
        tissue=tissues[0],
        near=(tissues[1], tissues[2]),
        draws=draws,
    )


@dataclass(frozen=True)
class _Plate:
    """Load of the plate of one belt."""

    loads: Annotated[np.ndarray, "(n, 3)"]
    """Compensated F_y, F_z (N) and M_x (N·m)."""
    draws: dict[str, np.ndarray]
    """F_y (N) and M_x (N·m) by every draw of the treadmill model, relative to the best one, (draws, n)."""
    frame_dd: Annotated[np.ndarray, "(n,)", "m/s²"]
    """Acceleration of the frame."""

    @classmethod
    def of(
        cls,
        prepared: PreparedTrial,
        belt: str,
        onsets: tuple[int, ...],
        gravity_m_per_s2: float,
        models: dict[str, FittedModel],
    ) -> Self:
        """Loads of a trial, less the belt-induced ones by its models; ``onsets`` are samples."""
        loads, still, n = prepared.load(belt), prepared.at_rest, prepared.time.size
        used = {c: loads[c] for c in COMPONENTS}
        if not models:
            table = np.column_stack([used["Fy"], loads["Fz"], used["Mx"]])
            return cls(table, dict.fromkeys(COMPONENTS, np.empty((0, n))), np.zeros(n))
        recordings = {
            component: replace(recording, onsets=onsets)
            for component, recording in recordings_above_rest(prepared, loads, gravity_m_per_s2).items()
        }
        # the constants belong to a frame and to friction, not to a filter
        models = {c: replace(m, lowpass=prepared.lowpass) for c, m in models.items()}
        compensated = compensated_loads(models, recordings)
        by_draw = compensated_draws(models, recordings)
        pressed = loads["Fz"] / gravity_m_per_s2 - recordings["Fy"].carried_kg
        per_kg = added_per_kg(models, recordings)
        used = {c: compensated[c] - pressed * per_kg[c] + loads[c][still].mean() for c in COMPONENTS}
        return cls(
            np.column_stack([used["Fy"], loads["Fz"], used["Mx"]]),
            {c: by_draw[c] - compensated[c] for c in COMPONENTS},
            models["Fy"].model.frame_acceleration(recordings["Fy"]),
        )

    def torque_draws(self, height: Annotated[np.ndarray, "(n,)", "m"]) -> np.ndarray:
        """Torque at a height by every draw, relative to the best one (N·m), shape (draws, n)."""
        return self.draws["Mx"] + height * self.draws["Fy"]


def tissue_frequencies() -> tuple[float, float, float]:
    """Assumed frequency of the soft tissue, and a lower and a higher one (Hz)."""
    return TISSUE_HZ, TISSUE_HZ - TISSUE_STEP_HZ, TISSUE_HZ + TISSUE_STEP_HZ


def tissue_motion(
    positions: Annotated[np.ndarray, "(n, markers, 2)", "m"],
    labels: list[str],
    person: Person,
    surface_dd: Annotated[np.ndarray, "(n,)", "m/s²"],
    peak_m_per_s: float,
    rate_hz: float,
    tissue_hz: float = TISSUE_HZ,
) -> np.ndarray:
    """Motion of the soft tissue along the belt below the shank's own markers, shape (n, markers).

    The tissue is a mass on a spring over the bone, which accelerates like the marker: less near the knee than
    near the ankle. Tissue that accelerates like the belt's surface moves by 1 at `TISSUE_SPEED`. Other
    markers do not move.

    positions: y, z, low-pass filtered.
    surface_dd: acceleration of the belt's surface.
    peak_m_per_s, rate_hz, tissue_hz: largest speed of the belt (m/s), sampling rate, and frequency of the
    soft tissue (Hz).
    """
    width = 2.0 * np.pi * tissue_hz
    numerator, denominator, _ = scipy.signal.cont2discrete(
        ([-1.0], [1.0, 2.0 * TISSUE_DAMPING * width, width**2]), 1.0 / rate_hz, method="bilinear"
    )
    columns = [labels.index(x) for x in person.shank.labels if x not in person.foot.labels]
    time = np.arange(len(surface_dd)) / rate_hz
    driven = np.column_stack([surface_dd, derivative(time, derivative(time, positions[:, columns, 0]))])
    motion = scipy.signal.lfilter(np.ravel(numerator), denominator, driven, axis=0)
    motion *= peak_m_per_s / TISSUE_SPEED / max(float(np.abs(motion[:, 0]).max()), 1e-300)
    by_marker = np.zeros(positions.shape[:2])
    by_marker[:, columns] = motion[:, 1:]
    return by_marker
