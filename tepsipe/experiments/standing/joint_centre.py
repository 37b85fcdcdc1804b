"""Centre of the ankle joint from the motion of the shank over the foot.

The shank turns about the centre of the joint. A point fixed in it that lies a ahead of the centre and l
above it moves over the foot, as the ankle angle phi changes, at

    dy / dphi = l cos(phi) - a sin(phi),     dz / dphi = -a cos(phi) - l sin(phi)

so a point that was assumed to be the centre shows by its motion how far from it it is (Schwartz & Rozumalski
2005: functional joint centres). In quiet sway soft tissue follows the bone and the displacement is that of
the joint. After a perturbation it does not: the difference of the two centres shows skin that wobbles.
"""

from dataclasses import dataclass

import numpy as np

from tepsipe.experiments.standing.options import Person
from tepsipe.io.trial import Trial
from tepsipe.mechanics.rigid_body_pose import fit_rigid_segment
from tepsipe.signals.filters import Lowpass
from tepsipe.signals.resampling import runs_of

# below it lies the sway of quiet standing, above it the noise of the markers (Hz)
SWAY_HZ = 3.0
# shortest stretch of quiet standing (s), and fewest stretches
STRETCH_S, FEWEST = 1.0, 3


@dataclass(frozen=True)
class JointCentre:
    """Where the centre of the ankle lies.

    Attributes
    ----------
    offset_m : ndarray, shape (2,)
        Of the centre from the assumed one: anterior, longitudinal, in the shank (m).
    standard_error_m : ndarray, shape (2,)
        From the scatter between stretches (m).
    sway_rad, foot_rad : float
        Standard deviation of the ankle angle and of the foot's in quiet standing (rad).
    stretches : int
        Number of stretches of quiet standing, or of perturbations (-).
    """

    offset_m: np.ndarray
    standard_error_m: np.ndarray
    sway_rad: float
    foot_rad: float
    stretches: int


def relative_motion(positions: np.ndarray, labels: list[str], person: Person) -> np.ndarray:
    """Ankle angle (rad), and place of the assumed centre, fixed in the shank, in axes of the foot (m).

    Parameters
    ----------
    positions : ndarray, shape (n, markers, 2)
        y, z (m).
    labels : list of str
        Names of the markers.
    person : Person
        Layout of the markers (m). Those that foot and shank share belong to the shank.

    Returns
    -------
    ndarray, shape (n, 4)
        phi (rad), y, z (m), angle of the foot (rad).
    """
    own = [k for k, label in enumerate(person.foot.labels) if label not in person.shank.labels]
    if len(own) < 2:
        own = list(range(len(person.foot.labels)))
    columns = [labels.index(person.foot.labels[k]) for k in own]
    foot = fit_rigid_segment(positions[:, columns], person.foot.layout_m[own], np.zeros(2))
    columns = [labels.index(label) for label in person.shank.labels]
    shank = fit_rigid_segment(positions[:, columns], person.shank.layout_m, np.zeros(2))
    y, z = (shank.point - foot.point).T
    cosine, sine = np.cos(foot.angle), np.sin(foot.angle)
    return np.column_stack(
        [shank.angle - foot.angle, cosine * y - sine * z, sine * y + cosine * z, foot.angle]
    )


def _centre(pieces: list[np.ndarray], mean_angle: float) -> JointCentre:
    """Slopes over all pieces, each about its own mean; standard error by the jackknife over pieces."""
    around = [piece - piece.mean(axis=0) for piece in pieces]
    sums = np.array([[p[:, 0] @ p[:, 0], p[:, 0] @ p[:, 1], p[:, 0] @ p[:, 2], len(p)] for p in around])
    total = sums.sum(axis=0)
    cosine, sine = np.cos(mean_angle), np.sin(mean_angle)
    # a and l of the assumed point from its slopes; the centre lies the other way
    turn = -np.array([[-sine, -cosine], [cosine, -sine]])

    def offset(s: np.ndarray) -> np.ndarray:
        return (s[..., 1:3] / s[..., :1]) @ turn.T

    k = len(sums)
    left_out = offset(total - sums) if k > 1 else np.full((1, 2), np.nan)
    error = np.sqrt((k - 1.0) / k * ((left_out - left_out.mean(axis=0)) ** 2).sum(axis=0))
    foot = np.concatenate([p[:, 3] for p in around])
    return JointCentre(offset(total), error, float(np.sqrt(total[0] / total[3])), float(foot.std()), k)


def centre_from_sway(
    trial: Trial, person: Person, unperturbed: np.ndarray, hidden: np.ndarray
) -> JointCentre | None:
    """Centre of the ankle from the quiet standing of a trial.

    Parameters
    ----------
    trial : Trial
        Markers (m).
    person : Person
        Layout of the markers, which defines the assumed centre (m).
    unperturbed : ndarray of bool, shape (n,)
        Samples of quiet standing (-).
    hidden : ndarray of bool, shape (n, markers)
        True where a marker was hidden (-).

    Returns
    -------
    JointCentre or None
        None if there are too few stretches of quiet standing.
    """
    labels = trial.axes["marker"].tolist()
    positions = trial.values("marker_position")[:, :, 1:].astype(float)
    motion = relative_motion(Lowpass(SWAY_HZ, 4, True)(positions, trial.rate_hz), labels, person)
    quiet = runs_of(unperturbed & ~hidden.any(axis=1))
    pieces = [motion[a:b] for a, b in quiet if b - a >= STRETCH_S * trial.rate_hz]
    if len(pieces) < FEWEST:
        return None
    return _centre(pieces, float(np.mean([piece[:, 0].mean() for piece in pieces])))


def centre_from_pulses(motion: np.ndarray, mean_angle: float) -> JointCentre:
    """Apparent centre from the responses to perturbations.

    Parameters
    ----------
    motion : ndarray, shape (responses, n, 4)
        From `relative_motion`, in the epochs of the responses (rad, m).
    mean_angle : float
        Ankle angle in quiet standing (rad).

    Returns
    -------
    JointCentre
        Offset from the assumed centre (m), with the wobble of the skin in it.
    """
    return _centre(list(motion), mean_angle)
