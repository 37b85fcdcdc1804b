"""Number and place of the perturbations that identify stiffness and damping of ankle, knee and hip.

A person is perturbed at belt, shank, thigh or pelvis. For every set of one to three of these, the Fisher
information of the expected person determines the directions of the 3 x 3 matrices that can be identified.
Simulated persons with sway and noise test whether the estimator reaches the predicted precision.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from pathlib import Path
from typing import Annotated, Self

import h5py
import numpy as np

from tepsipe.identification.several_joints.matrices import (
    Determined,
    Entry,
    Limits,
    MatrixFit,
    Perturbation,
    Setting,
    determined,
    entries,
    fit_matrices,
    information,
    unperturbed_covariance,
)
from tepsipe.mechanics.segment_chain import Chain, LinearChain, joint_angles, linearised

JOINTS = ("ankle", "knee", "hip")
SEGMENTS = ("shank", "thigh", "trunk")
Set = tuple[str, ...]
# inertia: exact, within its tolerance, or unknown
EXACT, WITHIN, UNKNOWN = "exact", "within tolerance", "unknown"
# symmetry of the matrices, and knowledge of the inertia; the first is the model of the plan
MODELS = tuple((symmetric, inertia) for symmetric in (False, True) for inertia in (WITHIN, EXACT, UNKNOWN))
MODEL = MODELS[0]


@dataclass(frozen=True)
class Point:
    """Point at which a perturbation acts."""

    segment: int | None
    """Index of the pushed segment; None for the belt."""
    height_m: float = 0.0
    """Height of the force above the segment's lower end."""

    @classmethod
    def from_settings(cls, perturbation: dict) -> Self:
        """Point of a perturbation: the belt that is displaced (m), or a segment at a height (m)."""
        if "displacement_m" in perturbation:
            return cls(None)
        return cls(SEGMENTS.index(perturbation["segment"]), perturbation["height_m"])

    def push(self, body: LinearChain) -> np.ndarray | None:
        """Vector b of the force (m), shape (3,); None for the belt."""
        return None if self.segment is None else body.push(self.segment, self.height_m)


@dataclass(frozen=True)
class Recording:
    """Recorded standing and perturbations."""

    unperturbed: Annotated[np.ndarray, "(n, 3)", "rad"]
    """Absolute angles of shank, thigh and trunk."""
    angle: Mapping[str, np.ndarray]
    """The same around every onset of a perturbation (rad), shape (epochs, samples, 3)."""
    drive: Mapping[str, np.ndarray]
    """Signed force (N) or acceleration of the belt (m/s²) from the onset on, shape (epochs, u)."""
    rate_hz: float
    drive_rate_hz: float
    """Rates of the angles and of the drives."""
    before: int
    """Samples of an epoch before the onset."""


@dataclass(frozen=True)
class Epochs:
    """Epochs of all perturbations relative to unperturbed behaviour."""

    setting: Setting
    """Body, weights and model."""
    perturbations: Mapping[str, Perturbation]
    """By name (rad, N, m/s²)."""


def epochs_of(
    recording: Recording,
    chain: Chain,
    points: Mapping[str, Point],
    model: tuple[bool, str] = MODEL,
    tolerance: float = 0.02,
    window_s: float | None = None,
) -> Epochs:
    """Deviations from unperturbed behaviour, in the direction of each pulse.

    points: point at which each perturbation acts.
    model: whether the matrices are symmetric, and what is known of the inertia.
    tolerance: relative standard uncertainty of every mass, centre of mass and moment of inertia.
    window_s: other length after the onset (s) for a prediction; drives are 0 after their end, and responses
    are left out. The recorded length by default.
    """
    body = linearised(chain, recording.unperturbed.mean(axis=0))
    rest = joint_angles(recording.unperturbed)
    substeps = round(recording.drive_rate_hz / recording.rate_hz)
    perturbations: dict[str, Perturbation] = {}
    for name, point in points.items():
        drive, angle = recording.drive[name], joint_angles(recording.angle[name]) - rest.mean(axis=0)
        sign = np.sign(drive @ drive[0])
        mean = (sign[:, None] * drive).mean(axis=0)
        if window_s is not None:
            length = round(window_s * recording.rate_hz) * substeps + 1
            mean = np.pad(mean, (0, max(0, length - mean.size)))[:length]
            angle = np.zeros((len(drive), recording.before + (length - 1) // substeps + 1, angle.shape[2]))
        perturbations[name] = Perturbation(mean, sign[:, None, None] * angle, point.push(body))
    samples = next(iter(perturbations.values())).response.shape[1]
    weight = np.linalg.inv(unperturbed_covariance(rest, samples))
    symmetric, inertia = model
    setting = Setting(
        body,
        weight,
        recording.before,
        1.0 / recording.rate_hz,
        substeps,
        symmetric,
        inertia == EXACT,
        chain.relative_covariance(tolerance) if inertia == WITHIN else None,
    )
    return Epochs(setting, perturbations)


def sets_of(names: Sequence[str], largest: int = 3) -> list[Set]:
    """All sets of one to ``largest`` perturbations, in the order of their names."""
    return [chosen for size in range(1, largest + 1) for chosen in combinations(names, size)]


def expected_parameters(setting: Setting, stiffness: np.ndarray, damping: np.ndarray) -> np.ndarray:
    """Parameters of a model, of K (N·m/rad) and B (N·m·s/rad), each of shape (3, 3)."""
    k, b = (
        [float(matrix[i, j]) for i, j in setting.pairs] for matrix in map(np.asarray, (stiffness, damping))
    )
    inertia = [] if setting.inertia_known else [1.0] * len(setting.body.inertia_parts)
    return np.array([*k, *b, *inertia])


@dataclass(frozen=True)
class SetPrediction:
    """Predicted outcome of a set of perturbations."""

    perturbations: Set
    """Names."""
    setting: Setting
    """Model."""
    known: Determined
    """Rank, condition, errors, movements."""
    by_inertia: Annotated[np.ndarray, "(q,)"]
    """Part of the standard errors that the tolerance of the inertia makes, in parts of the scale."""
    scale_open: bool
    """Whether a common factor of all parameters is open whatever the number of epochs."""


def predict(
    epochs: Epochs, sets: Sequence[Set], matrices: tuple[np.ndarray, np.ndarray], limits: Limits
) -> list[SetPrediction]:
    """Predict the outcome of sets of perturbations for an expected person.

    epochs: drives, numbers of epochs and weights; responses are not used.
    limits: limits within which a parameter counts as determined.
    """
    setting = epochs.setting
    p = expected_parameters(setting, *matrices)
    scale, prior = setting.scale(p), setting.prior()
    gained = {name: information(setting, p, [one]) for name, one in epochs.perturbations.items()}
    predictions = []
    for chosen in sets:
        total = prior + sum(gained[name] for name in chosen)
        known = determined(setting, total, scale, limits)
        inverse = np.linalg.pinv(total * np.outer(scale, scale), rcond=1e-15, hermitian=True)
        by_inertia = np.sqrt(np.diag(inverse @ (prior * np.outer(scale, scale)) @ inverse))
        open_ = not (setting.inertia_known or prior.any()) and all(
            epochs.perturbations[name].push is None for name in chosen
        )
        predictions.append(SetPrediction(chosen, setting, known, by_inertia, open_))
    return predictions


def neglected_inertia(
    epochs: Epochs, chosen: Set, matrices: tuple[np.ndarray, np.ndarray]
) -> Annotated[np.ndarray, "(18,)"]:
    """Standard uncertainty of K and B due to an inertia that is taken as exact.

    epochs: epochs of a model with an inertia within its tolerance.
    matrices: expected K (N·m/rad) and B (N·m·s/rad).
    Returns: standard uncertainty of K, then of B, over their natural size; not part of any interval of such
    a fit.
    """
    setting = epochs.setting
    p, q = expected_parameters(setting, *matrices), 2 * len(setting.pairs)
    f = information(setting, p, [epochs.perturbations[name] for name in chosen])
    # with the inertia held at 1, the other parameters absorb its error
    shift = np.linalg.solve(f[:q, :q], f[:q, q:])
    covariance = shift @ setting.inertia_covariance @ shift.T
    return np.sqrt(np.diag(covariance)) / setting.scale(p)[:q]


@dataclass(frozen=True)
class Drawn:
    """Estimate for one simulated person by one set of perturbations."""

    fit: MatrixFit
    """With what is known of the parameters."""
    known: Determined
    """By the information at the estimate."""
    entries: list[Entry]
    """Elements of K, then of B, by rows: quoted or refused (N·m/rad, N·m·s/rad)."""


def estimate(epochs: Epochs, chosen: Set, limits: Limits) -> Drawn:
    """Estimate K and B with a set of perturbations (N·m/rad, N·m·s/rad), or refuse them.

    ``limits`` define what counts as determined.
    """
    fit = fit_matrices(epochs.setting, [epochs.perturbations[name] for name in chosen])
    known = determined(fit.setting, fit.information, fit.scale, limits)
    return Drawn(fit, known, entries(fit, JOINTS, limits, known))


def read_draws(path: str | Path) -> list[Recording]:
    """Recordings of all simulated persons of a file (rad, N, m/s²).

    path: HDF5 file: one group per person with the data set ``unperturbed`` and the groups ``angle`` and
    ``drive`` with a data set per perturbation.
    Returns: in the order of their numbers.
    """
    with h5py.File(path) as file:
        return [_recording(file[name]) for name in sorted(file, key=int)]


def _recording(group) -> Recording:
    def arrays(name: str) -> dict[str, np.ndarray]:
        return {key: group[name][key][()] for key in group[name].attrs["names"]}

    return Recording(
        group["unperturbed"][()],
        arrays("angle"),
        arrays("drive"),
        float(group.attrs["rate_hz"]),
        float(group.attrs["drive_rate_hz"]),
        int(group.attrs["before"]),
    )
