"""The hidden motion of a joint, which only the comparison of estimates with the truth may read."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np

RATE_HZ = 500.0


@dataclass(frozen=True)
class TrueMotion:
    """Exact motion of a joint and the torque with which it resists."""

    time: Annotated[np.ndarray, "(n,)", "s"]
    """Instants from the trigger on."""
    angle: np.ndarray
    rate: np.ndarray
    acceleration: np.ndarray
    """Motion of the joint (rad, rad/s), and of the segment whose inertia counts as the joint's (rad/s²)."""
    torque: Annotated[np.ndarray, "(n,)", "N·m"]
    """Torque that resists the motion, including the joint's inertia."""


@dataclass(frozen=True)
class StandingMotion(TrueMotion):
    """Exact motion of a standing person's ankles: mean angle and intrinsic torque of both."""

    active: Annotated[np.ndarray, "(n,)", "N·m"]
    """Delayed torque of the muscles of both ankles."""
    marked_angle: Annotated[np.ndarray, "(n,)", "rad"]
    """Angle of the ankle that has the markers, from quiet standing."""
    marked_torque: Annotated[np.ndarray, "(n,)", "N·m"]
    """Its part of the intrinsic torque."""


def write_true_motion(path: str | Path, motion: TrueMotion) -> None:
    """Write the motion as HDF5 at `RATE_HZ` (s, rad, N·m), from the trigger on."""
    import h5py  # here, because the settings read the options of this package

    every = max(1, round((1.0 / RATE_HZ) / (motion.time[1] - motion.time[0])))
    kept = np.flatnonzero(motion.time >= 0.0)[::every]
    with h5py.File(path, "w") as file:
        for name, values in vars(motion).items():
            file.create_dataset(name, data=values[kept], compression="gzip", compression_opts=1, shuffle=True)
