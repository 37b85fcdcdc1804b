"""The truth of a joint that is not linear: the linear joint nearest to it in the motion that it made.

A rubber that softens has no one stiffness. What an estimator of I, B, K should find is the least-squares fit
of the true torque by the true motion, over the same windows:

    tau - tau_rest = I theta'' + B theta' + K (theta - theta_rest)

A standing person sways: there every perturbation has its own rest, the time just before its onset, and the
fit is to the mean responses of each trial, as that of the estimators. The torque is the intrinsic one of both
ankles, the angle the mean of both.

A joint in the manipulator is never at rest, because its drive ripples: angle and torque then count from their
means, as in a spectral fit.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import h5py
import numpy as np

from tepsipe.errors import InputError
from tepsipe.io.result import read_hdf5

SIGNALS = ("time", "angle", "rate", "acceleration", "torque")


@dataclass(frozen=True)
class TrueMotion:
    """Hidden motion of a joint, as the laboratory wrote it."""

    time: Annotated[np.ndarray, "(n,)", "s"]
    angle: Annotated[np.ndarray, "(n,)", "rad"]
    rate: Annotated[np.ndarray, "(n,)", "rad/s"]
    acceleration: Annotated[np.ndarray, "(n,)", "rad/s²"]
    torque: Annotated[np.ndarray, "(n,)", "N·m"]
    """From the trigger on."""


def read_true_motion(path: str | Path) -> TrueMotion:
    """Read the hidden motion of a trial (s, rad, N·m)."""
    return TrueMotion(**read_hdf5(_read, path, "the laboratory's motion", advice="make the trial again"))


def _read(path: str | Path) -> dict[str, np.ndarray]:
    with h5py.File(path, "r") as file:
        return {name: file[name][...] for name in SIGNALS}


def linear_truth(
    motion: TrueMotion,
    windows_s: list[tuple[float, float]],
    *,
    about_mean: bool = False,
    inertia_beyond: float = 0.0,
) -> dict[str, float]:
    """I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad) of the nearest linear joint, mean over windows.

    windows_s: start and end of each window.
    about_mean: count angle and torque from their means in the window, not from the first sample of the
    trial.
    inertia_beyond: inertia beyond the place where the torque is measured (N·m·s²/rad): the foot feels the
    moment of the rubber, but not the inertia that turns with the leg.
    """
    found = []
    at_rest, torque_at_rest = motion.angle[0], motion.torque[0]
    for start, end in windows_s:
        own = slice(*np.searchsorted(motion.time, (start, end)))
        columns = np.column_stack([motion.acceleration[own], motion.rate[own], motion.angle[own] - at_rest])
        torque = motion.torque[own] - torque_at_rest - inertia_beyond * columns[:, 0]
        if columns.shape[0] < 5 or not np.ptp(columns[:, 2]):
            raise InputError(
                f"expected motion from {start:.2f} to {end:.2f} s, found none: make the trial again"
            )
        if about_mean:
            columns, torque = columns - columns.mean(axis=0), torque - torque.mean()
        found.append(np.linalg.lstsq(columns, torque, rcond=None)[0])
    return dict(zip("IBK", np.mean(found, axis=0).tolist(), strict=True))


def linear_truth_standing(
    motions: list[TrueMotion],
    onsets_s: list[np.ndarray],
    window_s: float,
    inertia: bool,
    baseline_s: tuple[float, float],
) -> dict[str, float]:
    """B (N·m·s/rad), K (N·m/rad) of the linear ankles nearest to the true ones in the mean responses.

    motions: of the trials that were fitted together: mean angle and intrinsic torque of both ankles.
    onsets_s: onsets of the fitted perturbations of each trial.
    window_s: length of the fitted window from the onset.
    inertia: whether I (N·m·s²/rad) is fitted too.
    baseline_s: from where to where a response counts as rest, from the onset.
    Returns: B and K, and I if it is fitted.
    """
    names = ("acceleration", "rate", "angle") if inertia else ("rate", "angle")
    columns, torques = [], []
    for motion, onsets in zip(motions, onsets_s, strict=True):
        means = {name: _mean_response(motion, name, onsets, window_s, baseline_s) for name in SIGNALS[1:]}
        if not onsets.size or not np.ptp(means["angle"]):
            raise InputError(
                f"expected motion within {window_s:g} s after every onset, found none: make the trial again"
            )
        columns.append(np.column_stack([means[name] for name in names]))
        torques.append(means["torque"])
    found = np.linalg.lstsq(np.concatenate(columns), np.concatenate(torques), rcond=None)[0]
    return dict(zip("IBK" if inertia else "BK", found.tolist(), strict=True))


def _mean_response(
    motion: TrueMotion, name: str, onsets_s: np.ndarray, window_s: float, baseline_s: tuple[float, float]
) -> np.ndarray:
    """Mean over the perturbations of a signal in the window, less its mean before the onset (its unit)."""
    step_s = float(motion.time[1] - motion.time[0])
    signal = getattr(motion, name)
    window, before = (
        start + np.arange(0.0, stop - start + 0.5 * step_s, step_s)
        for start, stop in ((0.0, window_s), baseline_s)
    )

    def at(instants: np.ndarray) -> np.ndarray:
        return np.interp(onsets_s[:, None] + instants, motion.time, signal)

    return (at(window) - at(before).mean(axis=1, keepdims=True)).mean(axis=0)
