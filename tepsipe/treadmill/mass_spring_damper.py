"""The simplest models: subtraction of the mean of the empty belt, and mass, damper and spring."""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
import scipy

from tepsipe.errors import InputError, listed
from tepsipe.treadmill.belt_model import BeltModel
from tepsipe.treadmill.recording import BeltRecording


@dataclass(frozen=True)
class MeanSubtraction(BeltModel):
    """Mean load of every perturbation of the empty belt, by condition (thesis section 3-1-2, eq 3-11)."""

    templates: dict[str, np.ndarray]
    """Condition -> mean load from the perturbation's onset on (unit of the load), shape (w,)."""
    rate_hz: float
    """Sampling rate for which it holds."""

    @property
    def order(self) -> int:
        """Number of conditions that can be subtracted."""
        return len(self.templates)

    def predict(self, recording: BeltRecording) -> np.ndarray:
        """L (unit of the load), shape (n,)."""
        if recording.condition not in self.templates:
            raise InputError(
                f"{recording.name}: expected a recording of the empty belt in condition "
                f"{recording.condition!r}, found {listed(self.templates)}: record it, or use another model"
            )
        template = self.templates[recording.condition]
        predicted = np.zeros(recording.load.size)
        for onset in recording.onsets:
            stop = min(onset + template.size, predicted.size)
            predicted[onset:stop] = template[: stop - onset]
        return predicted


def fit_mean_subtraction(recordings: list[BeltRecording]) -> MeanSubtraction:
    """Mean load over the perturbations of every condition (unit of the load)."""
    by_condition: dict[str, list[np.ndarray]] = {}
    for r in recordings:
        if not r.onsets:
            raise InputError(
                f"{r.name}: expected separate perturbations to average, found a continuously perturbed belt: "
                "use another model"
            )
        by_condition.setdefault(r.condition, []).append(r.segments(r.load))
    templates = {condition: np.concatenate(parts).mean(axis=0) for condition, parts in by_condition.items()}
    return MeanSubtraction(templates, recordings[0].rate_hz)


@dataclass(frozen=True)
class MassSpringDamper(BeltModel):
    """L = m a + c (v - mean v) + k (y - trend y) + d: a simple second-order model (thesis chapter 5)."""

    coefficients: Annotated[np.ndarray, "(4,)"]
    """m, c, k, d (unit of the load over m/s², m/s, m, 1)."""
    rate_hz: float
    """Sampling rate of the calibration."""

    @property
    def order(self) -> int:
        """2."""
        return 2

    def predict(self, recording: BeltRecording) -> np.ndarray:
        """L (unit of the load), shape (n,)."""
        return motion_regressors(recording) @ self.coefficients


def fit_mass_spring_damper(recordings: list[BeltRecording]) -> MassSpringDamper:
    """Least squares over all evaluated samples (unit of the load)."""
    rows = np.concatenate([motion_regressors(r)[r.evaluated] for r in recordings])
    load = np.concatenate([r.load[r.evaluated] for r in recordings])
    scale = np.linalg.norm(rows, axis=0)
    solution = np.linalg.lstsq(rows / scale, load, rcond=1e-10)[0] / scale
    return MassSpringDamper(solution, recordings[0].rate_hz)


def motion_regressors(recording: BeltRecording) -> np.ndarray:
    """Regressors of eq L: a (m/s²), v less its mean (m/s), distance less its trend (m), 1; shape (n, 4)."""
    v = recording.velocity - recording.velocity.mean()
    y = recording.through_lowpass(scipy.signal.detrend(recording.position))
    return np.column_stack([recording.acceleration, v, y, np.ones_like(v)])
