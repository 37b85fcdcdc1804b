"""Effect of the treadmill model on the estimates from the foot: its calibration, its gate, and its limits."""

from dataclasses import dataclass, field
from typing import Annotated

import numpy as np

from tepsipe.identification.regression.windows import WindowedFits
from tepsipe.statistics.uncertainty import root_of_draws
from tepsipe.treadmill.compensation import compensated_draws
from tepsipe.treadmill.held_out import HeldOut, PredictedError, Subject, model_flags, predicted_error
from tepsipe.treadmill.recording import BeltRecording
from tepsipe.treadmill.registry import FittedModel

# sources of uncertainty: draws of the constants, and residuals of held-out trials
CALIBRATION, RESIDUAL = "treadmill_calibration", "treadmill_residual"


@dataclass(frozen=True)
class TreadmillCheck:
    """Uncertainty of I, B, K due to the treadmill model, and the verdict of its gate."""

    error: PredictedError | None = None
    """Error of I, B, K that the model's held-out residual predicts (N·m·s²/rad, N·m·s/rad, N·m/rad)."""
    contributions: dict[str, np.ndarray] = field(default_factory=dict)
    """Source -> root of its covariance, for a `Budget` (N·m·s²/rad, N·m·s/rad, N·m/rad), shape (k, 3)."""
    flags: tuple[str, ...] = ()
    """Failed checks, names in `tepsipe.flags.FLAGS`."""


def check_treadmill(
    models: dict[str, FittedModel],
    recordings: dict[str, BeltRecording],
    fit: WindowedFits,
    lever_m: float,
    held_out: HeldOut | None,
    own_zero: bool,
) -> TreadmillCheck:
    """Examine a treadmill model for one trial of the dummy.

    models: component of the load, Fy or Mx -> model.
    recordings: component -> recording of the trial.
    fit: estimates from the compensated torque.
    lever_m: height of the joint over the belt.
    held_out: residuals of trials that the model has not seen.
    own_zero: whether each window has a free constant torque.
    Returns: without any part that the model cannot give: see `BeltModel.holds_errors`.
    """
    model = models["Fy"].model
    if not model.holds_errors:
        return TreadmillCheck()
    recording = recordings["Fy"]
    flags, contributions = model_flags(model, recording.carried_kg), {}
    draws = compensated_draws(models, recordings)
    if len(draws["Fy"]):
        torque = draws["Mx"] + lever_m * draws["Fy"]
        estimates = fits_of_torques(fit, torque - torque.mean(axis=0), own_zero)
        contributions[CALIBRATION] = root_of_draws(estimates)
    error = None
    if held_out is not None and held_out.of(models):
        error = predicted_error(held_out, _subject(recording, fit, lever_m, own_zero))
        beyond_noise = np.maximum(error.parameters**2 - error.standard_error**2, 0.0)
        contributions[RESIDUAL] = (np.sign(error.parameters) * np.sqrt(beyond_noise))[None]
        flags += held_out.plate_flags
        if not error.trusted(float(fit.mean[2])):
            flags.append(held_out.failed)
    return TreadmillCheck(error, contributions, tuple(dict.fromkeys(flags)))


def fits_of_torques(
    fit: WindowedFits, torques: Annotated[np.ndarray, "(draws, n)", "N·m"], own_zero: bool
) -> Annotated[np.ndarray, "(draws, 3)"]:
    """Mean I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad) of many torques in the windows of a fit.

    own_zero: whether each window has a free constant torque.
    Returns: as `regress_torque` would estimate them from every row.
    """
    total = np.zeros((len(torques), 3))
    for p in fit.perturbations:
        rows = fit.regressors[p.start : p.stop]
        part = torques[:, p.start : p.stop]
        if own_zero:
            rows, part = rows - rows.mean(axis=0), part - part.mean(axis=1, keepdims=True)
        size = np.linalg.norm(rows, axis=0)
        total += part @ (np.linalg.pinv(rows / size) / size[:, None]).T
    return total / len(fit.perturbations)


def _subject(recording: BeltRecording, fit: WindowedFits, lever_m: float, own_zero: bool) -> Subject:
    """Mean pulse of the belt and mean motion of the joint over the shortest of the fitted windows."""
    length = min(p.stop - p.start for p in fit.perturbations)
    velocity, regressors = (
        np.mean([x[p.start : p.start + length] for p in fit.perturbations], axis=0)
        for x in (recording.velocity, fit.regressors)
    )
    return Subject(recording.carried_kg, lever_m, velocity, regressors, recording.rate_hz, own_zero)
