"""Write the files that the treadmill and the motion capture system would have written."""

import errno
import os
from pathlib import Path

import ezc3d
import numpy as np
import scipy

from tepsipe.virtual_lab.force_plate import BELTS, COMPONENTS, TRANSDUCERS

CHANNELS = tuple(f"{belt}_{name}" for belt in BELTS for name in TRANSDUCERS)


def write_treadmill_log(
    path: Path,
    rate_hz: float,
    voltages: np.ndarray,
    belt_velocity: np.ndarray,
    command: np.ndarray,
    trigger: np.ndarray,
) -> None:
    """Write the treadmill's log as a MATLAB file.

    Parameters
    ----------
    path : Path
        File to write.
    rate_hz : float
        Sampling rate (Hz).
    voltages : ndarray, shape (n, 14)
        Transducer channels (V).
    belt_velocity, command : ndarray, shape (n,)
        Measured and commanded velocity of the right belt (m/s).
    trigger : ndarray, shape (n,)
        Trigger line (V).
    """
    content = {
        "sample_rate_hz": float(rate_hz),
        "channel_names": np.array(CHANNELS, dtype=object),
        "transducers_V": voltages.astype(np.float32),
        "belt_velocity_m_per_s": belt_velocity.astype(np.float32)[:, None],
        "command_m_per_s": command.astype(np.float32)[:, None],
        "trigger_V": trigger.astype(np.float32)[:, None],
    }
    scipy.io.savemat(path, content, do_compression=True)
    # the header holds the date of writing: the same study must give the same bytes
    with open(path, "r+b") as file:
        file.write(b"MATLAB 5.0 MAT-file, instrumented treadmill log".ljust(116))


def write_calibration(path: Path, calibration: np.ndarray) -> None:
    """Write the 12 x 14 calibration matrix as CSV: a row per component and belt (N/V, N·m/V)."""
    lines = [",".join(["component", "unit", *CHANNELS]) + "\n"]
    names = [(belt, component) for belt in BELTS for component in COMPONENTS]
    for (belt, component), row in zip(names, calibration, strict=True):
        unit = "N/V" if component.startswith("F") else "Nm/V"
        lines.append(",".join([f"{component}_{belt}", unit, *[f"{c:.9g}" for c in row]]) + "\n")
    path.write_text("".join(lines))


def write_markers(path: Path, labels: tuple[str, ...], positions: np.ndarray, rate_hz: float) -> None:
    """Write markers as C3D.

    Parameters
    ----------
    path : Path
        File to write.
    labels : tuple of str
        Names of the markers.
    positions : ndarray, shape (frames, markers, 3)
        x, y, z (m), NaN while hidden; the file holds mm.
    rate_hz : float
        Frame rate (Hz).

    Raises
    ------
    OSError
        If the file is shorter than its data, as on a full disk; ezc3d writes on without a word.
    """
    file = ezc3d.c3d()
    file["parameters"]["POINT"]["RATE"]["value"] = [float(rate_hz)]
    file["parameters"]["POINT"]["LABELS"]["value"] = list(labels)
    file["parameters"]["POINT"]["UNITS"]["value"] = ["mm"]
    points = np.ones((4, positions.shape[1], positions.shape[0]))
    points[:3] = 1000.0 * positions.transpose(2, 1, 0)
    file["data"]["points"] = points
    hidden = np.isnan(points[:3]).any(axis=0)
    file["data"]["meta_points"]["residuals"] = np.where(hidden, -1.0, 0.0)[None]
    file["data"]["meta_points"]["camera_masks"] = np.zeros((7, *hidden.shape), dtype=bool)
    file.write(str(path))
    if path.stat().st_size < 4 * points.size:  # four numbers of four bytes per marker and frame
        raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(path))
