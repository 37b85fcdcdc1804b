"""C3D files that hold whole trials: markers, force plates and analog channels, written without the readers.

`write_c3d` writes what it is given. `single_c3d` turns the files of a trial of the virtual laboratory (MATLAB
log, calibration matrix, C3D of the markers, EDF) into one C3D as a motion capture system with force plates
would have written it: same frames, plates of type 2, electromyograms and belt velocity as analog channels, no
trigger. A study of it needs `single_c3d_settings`.
"""

from dataclasses import dataclass, field
from pathlib import Path

import ezc3d
import numpy as np
from scipy.interpolate import CubicSpline
from scipy.io import loadmat

from tepsipe.io.readers.edf import open_edf
from tepsipe.io.readers.treadmill_log import read_calibration_matrix

ANALOG_RATE_HZ = 1000.0
PLATE_CHANNELS = ("Fx", "Fy", "Fz", "Mx", "My", "Mz")
# both belts of the virtual treadmill: x to the right, y forward, surface at z = 0 (m)
BELTS_M = {"left": (-0.55, -0.02), "right": (0.02, 0.55)}
LENGTH_M = 1.8


@dataclass(frozen=True)
class Plate:
    """A force plate: its parameters (m), and the labels of its channels."""

    corners_m: np.ndarray
    channels: tuple[str, ...]
    kind: int = 2
    origin_m: tuple[float, float, float] = (0.0, 0.0, -0.04)
    matrix: np.ndarray = field(default_factory=lambda: np.eye(6))


def write_c3d(path, frame_rate_hz, markers, channels, plates=(), analog_rate_hz=ANALOG_RATE_HZ, zero=(0, 0)):
    """Write a C3D file with lengths in mm.

    markers: label -> positions (m), shape (frames, 3), NaN while hidden; may be empty. channels: label ->
    (samples, unit), each of frames * analog_rate_hz / frame_rate_hz samples. plates: list of `Plate`.
    """
    per_frame = round(analog_rate_hz / frame_rate_hz)
    frames = (
        next(iter(markers.values())).shape[0]
        if markers
        else next(iter(channels.values()))[0].size // per_frame
    )
    file = ezc3d.c3d()
    point, analog = file["parameters"]["POINT"], file["parameters"]["ANALOG"]
    point["RATE"]["value"], point["UNITS"]["value"] = [float(frame_rate_hz)], ["mm"]
    point["LABELS"]["value"] = list(markers)
    points = np.ones((4, len(markers), frames))
    for k, positions in enumerate(markers.values()):
        points[:3, k] = 1000.0 * positions.T
    hidden = np.isnan(points[:3]).any(axis=0)
    file["data"]["points"] = points
    file["data"]["meta_points"]["residuals"] = np.where(hidden, -1.0, 0.0)[None]
    file["data"]["meta_points"]["camera_masks"] = np.zeros((7, *hidden.shape), dtype=bool)
    if channels:
        analog["RATE"]["value"] = [float(analog_rate_hz)]
        analog["LABELS"]["value"] = list(channels)
        analog["UNITS"]["value"] = [unit for _, unit in channels.values()]
        file["data"]["analogs"] = np.stack([x[: frames * per_frame] for x, _ in channels.values()])[None]
    if plates:
        _add_plates(file, list(channels), plates, zero)
    file.write(str(path))
    return Path(path)


def _add_plates(file, labels, plates, zero):
    most = max(len(plate.channels) for plate in plates)
    numbers = np.zeros((most, len(plates)))
    for k, plate in enumerate(plates):
        numbers[: len(plate.channels), k] = [labels.index(label) + 1 for label in plate.channels]
    for name, value in (
        ("USED", [len(plates)]),
        ("TYPE", [plate.kind for plate in plates]),
        ("ZERO", list(zero)),
        ("CORNERS", np.stack([1000.0 * plate.corners_m.T for plate in plates], axis=2)),
        ("ORIGIN", np.stack([1000.0 * np.array(plate.origin_m) for plate in plates], axis=1)),
        ("CHANNEL", numbers),
        ("CAL_MATRIX", np.stack([plate.matrix for plate in plates], axis=2)),
    ):
        file.add_parameter("FORCE_PLATFORM", name, np.asarray(value, dtype=float))
        if name in ("USED", "TYPE", "ZERO", "CHANNEL"):  # ezc3d adds numbers as floating point only
            file["parameters"]["FORCE_PLATFORM"][name]["type"] = ezc3d.ezc3d.INT


# ---- a trial of the virtual laboratory ---------------------------------------------------------


def plate_of(belt, origin_m=(0.0, 0.0, -0.04)):
    """Plate of a belt of the virtual treadmill, its labels as cameras' software writes them.

    x of the plate is to the right, y backward and z down; its origin lies 4 cm below the surface, or
    `origin_m` away from its centre, in these axes.
    """
    left, right = BELTS_M[belt]
    back, front = -0.5 * LENGTH_M, 0.5 * LENGTH_M
    corners = [[right, back, 0.0], [left, back, 0.0], [left, front, 0.0], [right, front, 0.0]]
    number = 1 + list(BELTS_M).index(belt)
    labels = tuple(f"{channel}{number}" for channel in PLATE_CHANNELS)
    return Plate(np.array(corners), labels, origin_m=origin_m)


def plate_channels(plate, force, moment):
    """Channels of a plate of `plate_of` from force (N) and moment about the laboratory's origin (N·m)."""
    turned = np.array([1.0, -1.0, -1.0])  # right, backward, down
    own = plate.corners_m.mean(axis=0) - turned * plate.origin_m
    about_own = moment - np.cross(own, force)
    samples = np.hstack([turned * force, 1000.0 * turned * about_own])
    units = ("N", "N", "N", "Nmm", "Nmm", "Nmm")
    return {label: (x, unit) for label, x, unit in zip(plate.channels, samples.T, units, strict=True)}


def single_c3d(
    files,
    path,
    emg_labels=(),
    duration_s=None,
    latency_s=0.0,
    analog_rate_hz=ANALOG_RATE_HZ,
    belt_velocity=True,
    origin_m=(0.0, 0.0, -0.04),
):
    """Write the files of a virtual trial (log, calibration, and where there are: markers, emg) as one C3D.

    The first frame is `latency_s` after the trigger, as the laboratory's cameras are. Without markers the
    file has frames at 250 Hz for `duration_s`. The log's samples are interpolated, not filtered.
    """
    log, matrix = loadmat(files["log"]), read_calibration_matrix(files["calibration"])
    markers, rate, frames = {}, 250.0, None if duration_s is None else round(250.0 * duration_s)
    if "markers" in files:
        old = ezc3d.c3d(str(files["markers"]))
        rate = float(old["parameters"]["POINT"]["RATE"]["value"][0])
        points = old["data"]["points"][:3]
        points[:, old["data"]["meta_points"]["residuals"][0] < 0.0] = np.nan
        labels = old["parameters"]["POINT"]["LABELS"]["value"]
        markers = {label: 1e-3 * points[:, k].T for k, label in enumerate(labels)}
        frames = points.shape[2]
    clock = latency_s + np.arange(round(frames * analog_rate_hz / rate)) / analog_rate_hz
    trigger, log_rate = log["trigger_V"].ravel(), float(log["sample_rate_hz"].item())
    log_time = (np.arange(trigger.size) - np.argmax(trigger >= 2.5) + 0.5) / log_rate
    channels, plates = {}, []
    for belt in BELTS_M:
        rows = [matrix.row(f"{name}_{belt}") for name in PLATE_CHANNELS]
        wrench = CubicSpline(log_time, log["transducers_V"].astype(float) @ np.array(rows).T)(clock)
        plate = plate_of(belt, origin_m)
        plates.append(plate)
        channels |= plate_channels(plate, wrench[:, :3], wrench[:, 3:])
    if belt_velocity:
        measured = CubicSpline(log_time, log["belt_velocity_m_per_s"].ravel().astype(float))(clock)
        channels["Belt speed"] = (measured / 0.5 + 2.5, "V")  # 0.5 m/s per V, 2.5 V at rest
    if "emg" in files:
        channels |= _emg_channels(files["emg"], emg_labels, clock)
    return write_c3d(path, rate, markers, channels, plates, analog_rate_hz)


def _emg_channels(path, labels, clock):
    """Electromyograms of an EDF at other instants (s from the trigger), in mV."""
    found = open_edf(Path(path))
    trigger = np.asarray(found["Trigger"][0].data)
    rate = found["Trigger"][0].sampling_frequency
    time = (np.arange(trigger.size) - np.argmax(trigger >= 2.5) + 0.5) / rate
    return {
        label: (1e-3 * CubicSpline(time, np.asarray(found[label][0].data))(clock), "mV") for label in labels
    }


def single_c3d_settings(belt_velocity=True, markers=()):
    """`plate_treadmill.recording` of the configuration for a file of `single_c3d`."""
    return {
        "axes": {"forward": "+y", "up": "+z"},
        "plates": {"left": [1], "right": [2]},
        "belt_velocity": {
            "channel": "Belt speed" if belt_velocity else None,
            "m_per_s_per_unit": 0.5,
            "offset": 2.5,
            "markers": list(markers),
        },
    }
