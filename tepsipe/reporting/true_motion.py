"""The truth of a joint that is not linear: the linear joint nearest to it in the motion that it made.

A rubber that softens has no one stiffness. What an estimator of I, B, K should find is the least-squares fit
of the true torque by the true motion, over the same windows:

    tau - tau_rest = I theta'' + B theta' + K (theta - theta_rest)

A joint in the manipulator is never at rest, because its drive ripples: angle and torque then count from their
means, as in a spectral fit.
"""

from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

from tepsipe.errors import InputError
from tepsipe.io.hdf5_file import read_hdf5

SIGNALS = ("time", "angle", "rate", "acceleration", "torque")


@dataclass(frozen=True)
class TrueMotion:
    """Hidden motion of a joint, as the laboratory wrote it.

    Attributes
    ----------
    time, angle, rate, acceleration, torque : ndarray, shape (n,)
        From the trigger on (s, rad, rad/s, rad/s², N·m).
    """

    time: np.ndarray
    angle: np.ndarray
    rate: np.ndarray
    acceleration: np.ndarray
    torque: np.ndarray


def read_true_motion(path: str | Path) -> TrueMotion:
    """Read the hidden motion of a trial (s, rad, N·m).

    Raises
    ------
    InputError
        If the file cannot be read.
    """
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

    Parameters
    ----------
    motion : TrueMotion
        Of the trial (s, rad, N·m).
    windows_s : list of (float, float)
        Start and end of each window (s).
    about_mean : bool, default False
        Count angle and torque from their means in the window, not from the first sample of the trial.
    inertia_beyond : float, default 0
        Inertia beyond the place where the torque is measured (N·m·s²/rad): the foot feels the moment of the
        rubber, but not the inertia that turns with the leg.

    Returns
    -------
    dict of str to float
        I, B and K.

    Raises
    ------
    InputError
        If a window holds no motion.
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
