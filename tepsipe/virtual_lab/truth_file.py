"""The hidden motion of a joint, which only the comparison of estimates with the truth may read."""

from dataclasses import dataclass
from pathlib import Path

import h5py
import numpy as np

RATE_HZ = 500.0


@dataclass(frozen=True)
class TrueMotion:
    """Exact motion of a joint and the torque with which it resists.

    Attributes
    ----------
    time : ndarray, shape (n,)
        Instants from the trigger on (s).
    angle, rate, acceleration : ndarray, shape (n,)
        Motion of the joint (rad, rad/s), and of the segment whose inertia counts as the joint's (rad/s²).
    torque : ndarray, shape (n,)
        Torque that resists the motion, including the joint's inertia (N·m).
    """

    time: np.ndarray
    angle: np.ndarray
    rate: np.ndarray
    acceleration: np.ndarray
    torque: np.ndarray


@dataclass(frozen=True)
class StandingMotion(TrueMotion):
    """Exact motion of a standing person's ankles: mean angle and intrinsic torque of both.

    Attributes
    ----------
    active : ndarray, shape (n,)
        Delayed torque of the muscles of both ankles (N·m).
    marked_angle : ndarray, shape (n,)
        Angle of the ankle that has the markers, from quiet standing (rad).
    marked_torque : ndarray, shape (n,)
        Its part of the intrinsic torque (N·m).
    """

    active: np.ndarray
    marked_angle: np.ndarray
    marked_torque: np.ndarray


def write_true_motion(path: str | Path, motion: TrueMotion) -> None:
    """Write the motion as HDF5 at `RATE_HZ` (s, rad, N·m), from the trigger on."""
    every = max(1, round((1.0 / RATE_HZ) / (motion.time[1] - motion.time[0])))
    kept = np.flatnonzero(motion.time >= 0.0)[::every]
    with h5py.File(path, "w") as file:
        for name, values in vars(motion).items():
            file.create_dataset(name, data=values[kept], compression="gzip", compression_opts=1, shuffle=True)
