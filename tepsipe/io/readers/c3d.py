"""Marker positions from C3D files."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np

from tepsipe.errors import InputError, listed, quoted
from tepsipe.io.readers.guarded import guarded
from tepsipe.io.readers.gzip_file import plain_file

# processor type -> byte order of its words, and the byte of the scale factor that holds the sign
WORDS = {84: ("<u2", 15), 85: ("<u2", 13), 86: (">u2", 12)}
METRES_PER_UNIT = {"mm": 1e-3, "cm": 1e-2, "m": 1.0}


@dataclass(frozen=True)
class Markers:
    """Marker positions as the motion capture system recorded them."""

    rate_hz: float
    """Frames per second."""
    labels: tuple[str, ...]
    positions: Annotated[np.ndarray, "(frames, markers, 3)"]
    """x, y, z (m); NaN while a marker was hidden. One that lacks a coordinate, or has an infinite one, is
    hidden."""

    def __post_init__(self) -> None:
        """Hide markers with incomplete coordinates."""
        whole = np.isfinite(self.positions).all(axis=-1, keepdims=True)
        object.__setattr__(self, "positions", np.where(whole, self.positions, np.nan))


def read_markers(path: str | Path, labels: list[str]) -> Markers:
    """Read the wanted markers of a C3D file.

    path: C3D file.
    labels: names of the wanted markers, in the wanted order.
    Returns: rate, labels and positions.
    """
    path = Path(path)
    return select_markers(c3d_markers(open_c3d(path), path), labels, path)


def select_markers(markers: Markers, labels: list[str], name: str | Path) -> Markers:
    """Select markers of a file (m), in the wanted order.

    A label without the name of a subject before a colon also names the only marker of that label with one.
    """
    available = list(markers.labels)
    without_subject = [label.rpartition(":")[2] for label in available]
    columns = []
    for label in labels:
        known = available if label in available else without_subject
        if label not in known:
            raise InputError(
                f"{name}: expected a marker named {label!r}, found {listed(available)}: "
                "name the file's markers in the configuration"
            )
        if known.count(label) > 1:
            raise InputError(
                f"{name}: expected one marker named {label!r}, found {known.count(label)}: rename them "
                "when exporting"
            )
        columns.append(known.index(label))
    return Markers(markers.rate_hz, tuple(labels), markers.positions[:, columns])


def c3d_markers(file, path: Path) -> Markers:
    """All markers of an opened C3D file (m), NaN where one was hidden."""
    labels = group_labels(file, "POINT")
    scale = metres_per_unit(file, path)
    points, residuals = file["data"]["points"][:3], file["data"]["meta_points"]["residuals"][0]
    labels += [f"unnamed {k + 1}" for k in range(len(labels), points.shape[1])]
    positions = scale * points.transpose(2, 1, 0)
    positions[residuals.T < 0.0] = np.nan
    return Markers(frame_rate(file, path), tuple(labels[: points.shape[1]]), positions)


def frame_rate(file, path: Path) -> float:
    """Frames per second of an opened C3D file (Hz)."""
    rate = float(file["parameters"]["POINT"]["RATE"]["value"][0])
    if not 0.0 < rate < np.inf:
        raise InputError(
            f"{path}: expected a positive number of frames per second in POINT:RATE, found {rate:g}: it is "
            "damaged, export it again"
        )
    return rate


def metres_per_unit(file, path: Path) -> float:
    """Factor from the positions of an opened C3D file to metres (m per unit)."""
    point = file["parameters"]["POINT"]
    unit = str(point["UNITS"]["value"][0]).strip() if point["UNITS"]["value"] else ""
    if unit not in METRES_PER_UNIT:
        raise InputError(
            f"{path}: expected marker positions in mm, cm or m, found the unit {quoted(unit)}: set "
            "POINT:UNITS when exporting"
        )
    return METRES_PER_UNIT[unit]


def group_labels(file, group: str) -> list[str]:
    """Labels of POINT or ANALOG, also beyond the 255 that one parameter can hold."""
    parameters = file["parameters"].get(group, {})
    names = ["LABELS", *(f"LABELS{k}" for k in range(2, 100))]
    groups = [parameters[name]["value"] for name in names if name in parameters]
    return [str(label).strip() for labels in groups for label in labels]


def open_c3d(path: Path):
    """Parameters, data and number of the first frame of a C3D file, as ezc3d reads it (units of the file)."""
    import ezc3d

    def parsed(plain: Path) -> dict:
        file = ezc3d.c3d(str(plain))
        first = int(file["header"]["points"]["first_frame"])
        return {"parameters": dict(file["parameters"]), "data": dict(file["data"]), "first_frame": first}

    if not path.is_file():
        raise InputError(f"{path}: expected a C3D file, found no file: correct its path in the trial sheet")
    with plain_file(path, "a C3D file") as plain:
        _refuse_truncated(path, plain.read_bytes())
        try:
            return guarded(parsed, plain, what=path)
        except InputError:
            raise
        except Exception as error:  # ezc3d raises many kinds on damaged files
            raise InputError(
                f"{path}: expected a C3D file, found one that cannot be read ({type(error).__name__}): "
                "it is damaged, export it again"
            ) from error


def _refuse_truncated(path: Path, content: bytes) -> None:
    """Compare the size of the file with the size given by its header block."""
    if len(content) < 1024 or content[1] != 0x50:
        raise InputError(
            f"{path}: expected a C3D file, found {len(content)} bytes without its header: check which "
            "file the trial sheet names"
        )
    parameters = 512 * (content[0] - 1)
    if len(content) < parameters + 512:
        raise InputError(
            f"{path}: expected parameters from byte {parameters} on, found {len(content)} bytes: the file is "
            "truncated, copy it again from the instrument"
        )
    processor = content[parameters + 3]
    if processor not in WORDS:
        raise InputError(
            f"{path}: expected a C3D file of an Intel, DEC or MIPS processor (84 to 86), found "
            f"{processor}: it is damaged, export it again"
        )
    word, sign_byte = WORDS[processor]
    _, points, analog, first, last = np.frombuffer(content[:10], dtype=word).tolist()
    data_block = int(np.frombuffer(content[16:18], dtype=word)[0])
    if last == 65535:
        return  # more frames than the header block can hold: their number is a parameter
    bytes_per_value = 4 if content[sign_byte] & 0x80 else 2  # a negative scale means floating point
    frames = last - first + 1
    expected = 512 * (data_block - 1) + frames * bytes_per_value * (4 * points + analog)
    if len(content) < expected:
        raise InputError(
            f"{path}: expected {frames} frames ({expected} bytes), found {len(content)} bytes: the "
            "file is truncated, copy it again from the instrument"
        )
