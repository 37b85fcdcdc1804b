"""A whole trial in one C3D file: markers, force plates and analog channels."""

from pathlib import Path

import numpy as np

from tepsipe.errors import InputError
from tepsipe.io.readers.c3d import c3d_markers, frame_rate, group_labels, metres_per_unit, open_c3d
from tepsipe.io.readers.force_plates import force_plates
from tepsipe.io.readers.recording import DIRECTIONS, Channel, ForcePlate, Recording

LEVEL = 0.9  # least vertical component of the normal of a level plate


def read_c3d_recording(path: str | Path) -> Recording:
    """Read all signals of a trial from a C3D file.

    The first sample of every channel is taken at the instant of the first frame.

    path: C3D file.
    Returns: markers, force plates and analog channels in their units.
    """
    path = Path(path)
    file = open_c3d(path)
    markers = c3d_markers(file, path)
    channels = _channels(file, path)
    labels = [label for label, _ in channels]
    plates = force_plates(file, [c for _, c in channels], labels, path, metres_per_unit(file, path))
    return Recording(
        name=str(path),
        markers=markers if markers.labels else None,
        plates=plates,
        channels=dict(channels),
        up=_up(file, markers.positions, plates),
    )


def _up(file, positions: np.ndarray, plates: tuple[ForcePlate, ...]) -> str:
    """Upward direction: normal of level plates, else the vertical of the screen (POINT:Y_SCREEN), else z.

    Markers are above the plates, or above the floor of the laboratory. Without them the order of the plates'
    corners decides which side is up.
    """
    level = [plate for plate in plates if plate.normal is not None and np.abs(plate.normal).max() > LEVEL]
    axes = {int(np.argmax(np.abs(plate.normal))) for plate in level}
    screen = file["parameters"]["POINT"].get("Y_SCREEN", {}).get("value", [])
    named = "".join(map(str, screen[:1])).strip().lower()
    named = named if named in DIRECTIONS else "+z"
    axis = axes.pop() if len(axes) == 1 else "xyz".index(named[1])
    heights = positions[..., axis][np.isfinite(positions[..., axis])]
    if heights.size:
        surface = np.mean([plate.corners[:, axis] for plate in level]) if level else 0.0
        downward = np.median(heights) < surface
    else:
        downward = sum(plate.normal[axis] for plate in level) < 0.0
    return f"{'-' if downward else '+'}{'xyz'[axis]}"


def _channels(file, path: Path) -> list[tuple[str, Channel]]:
    """Label and channel in the order of the file; the number is added where a label is empty or repeated."""
    analog, samples = file["parameters"].get("ANALOG", {}), file["data"]["analogs"][0]
    if not samples.size:
        return []
    frames_hz = frame_rate(file, path)
    per_frame = samples.shape[1] // file["data"]["points"].shape[2]
    rate, named = per_frame * frames_hz, [float(r) for r in analog["RATE"]["value"][:1]]
    if not rate > 0.0 or (named and abs(named[0] - rate) > 1e-3 * rate):
        raise InputError(
            f"{path}: expected analog channels at {per_frame} times the {frames_hz:g} Hz of the frames, "
            f"found {named[0] if named else rate:g} Hz in ANALOG:RATE: export the file again"
        )
    labels, units = group_labels(file, "ANALOG"), _units(analog)
    limits = _limits(analog, file, samples.shape[0])
    channels: list[tuple[str, Channel]] = []
    for k, values in enumerate(np.where(np.isfinite(samples), samples, np.nan)):
        label = labels[k] if k < len(labels) and labels[k] else f"channel {k + 1}"
        if label in labels[:k]:
            label = f"{label} (channel {k + 1})"
        channels.append((label, Channel(values, units[k] if k < len(units) else "", rate, limits[k])))
    return channels


def _units(analog: dict) -> list[str]:
    names = ["UNITS", *(f"UNITS{k}" for k in range(2, 100))]
    return [str(u).strip() for name in names if name in analog for u in analog[name]["value"]]


def _limits(analog: dict, file, count: int) -> list[tuple[float, float] | None]:
    """Lowest and highest value of each channel's converter (unit of the channel); None for floating point."""
    scales = np.asarray(analog["SCALE"]["value"], dtype=float).ravel() if "SCALE" in analog else np.empty(0)
    if float(file["parameters"]["POINT"]["SCALE"]["value"][0]) < 0.0 or scales.size < count:
        return [None] * count
    bits = int(analog["BITS"]["value"][0]) if "BITS" in analog and len(analog["BITS"]["value"]) else 16
    unsigned = [str(f).strip().upper() for f in analog.get("FORMAT", {}).get("value", [])] == ["UNSIGNED"]
    low, high = (0, 2**bits - 1) if unsigned else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
    offsets = np.zeros(count)
    if "OFFSET" in analog and len(analog["OFFSET"]["value"]) >= count:
        offsets = np.asarray(analog["OFFSET"]["value"], dtype=float).ravel()
    general = float(analog["GEN_SCALE"]["value"][0]) if "GEN_SCALE" in analog else 1.0
    ends = [
        sorted(general * s * (end - o) for end in (low, high)) for s, o in zip(scales, offsets, strict=False)
    ]
    return [(first, last) for first, last in ends[:count]]
