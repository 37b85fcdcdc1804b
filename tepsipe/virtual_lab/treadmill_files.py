"""Write the files that the treadmill and the motion capture system would have written."""

import errno
import os
from pathlib import Path
from typing import Annotated

import ezc3d
import numpy as np
import scipy

from tepsipe.virtual_lab.force_plate import BELTS, COMPONENTS, TRANSDUCERS

CHANNELS = tuple(f"{belt}_{name}" for belt in BELTS for name in TRANSDUCERS)


def write_treadmill_log(
    path: Path,
    rate_hz: float,
    voltages: Annotated[np.ndarray, "(n, 14)", "V"],
    belt_velocity: Annotated[np.ndarray, "(n,)", "m/s"],
    command: Annotated[np.ndarray, "(n,)", "m/s"],
    trigger: Annotated[np.ndarray, "(n,)", "V"],
) -> None:
    """Write the treadmill's log as a MATLAB file.

    voltages: transducer channels.
    belt_velocity, command: measured and commanded velocity of the right belt.
    trigger: trigger line.
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


def write_markers(
    path: Path,
    labels: tuple[str, ...],
    positions: Annotated[np.ndarray, "(frames, markers, 3)"],
    rate_hz: float,
) -> None:
    """Write markers as C3D.

    positions: x, y, z (m), NaN while hidden; the file holds mm.
    rate_hz: frame rate.
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
