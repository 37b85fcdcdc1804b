"""Markers from TRC files, the text format of Motion Analysis (Cortex, EVaRT) and of OpenSim.

The layout follows OpenSim's documentation ("Marker (.trc) files"): ``PathFileType`` on the first line,
names of the settings on the second, their values on the third, ``Frame#``, ``Time`` and the markers on the
fourth, ``X1 Y1 Z1 X2 ...`` on the fifth, then one row per frame, all separated by tabs. A hidden marker has
empty fields, or 0 in all three.
"""

from pathlib import Path

import numpy as np

from tepsipe.errors import InputError, listed, quoted
from tepsipe.io.file_format import Channel, Contents, Format
from tepsipe.io.readers.plain_file import read_text
from tepsipe.io.readers.plain_table import number_in
from tepsipe.io.readers.recording import METRES_PER_UNIT, Markers

SETTINGS = ("DataRate", "NumFrames", "NumMarkers", "Units")
HEADER_LINES = 5


def read_trc(path: str | Path) -> Markers:
    """Read all markers of a TRC file.

    path: the file, plain or compressed with gzip.
    Returns: rate, labels and positions, NaN while a marker was hidden.
    """
    path = Path(path)
    lines = read_text(path, "a TRC file").split("\n")
    if not lines[0].startswith("PathFileType") or len(lines) < HEADER_LINES:
        raise InputError(
            f"{path}: expected a TRC file that begins with 'PathFileType', found {quoted(lines[0])}: check "
            "which file the trial sheet names"
        )
    settings = dict(zip(lines[1].split("\t"), (v.strip() for v in lines[2].split("\t")), strict=False))
    settings = {name.strip(): value for name, value in settings.items()}
    rate, frames, count = _rate_and_sizes(settings, path)
    unit = settings["Units"].strip()
    if unit not in METRES_PER_UNIT:
        raise InputError(
            f"{path}: expected marker positions in mm, cm or m, found the unit {quoted(unit)}: set 'Units' "
            "when exporting"
        )
    labels = [label.strip() for label in lines[3].split("\t")[2:] if label.strip()]
    if len(labels) != count:
        raise InputError(
            f"{path}: expected {count} markers as NumMarkers says, found {listed(labels)}: the header is "
            "damaged, export the file again"
        )
    rows = [k for k in range(HEADER_LINES, len(lines)) if lines[k].strip()]
    if len(rows) != frames or not lines[-1].strip() == "":
        raise InputError(
            f"{path}: expected {frames} frames as NumFrames says, the last one with a line break, found "
            f"{len(rows)}: the file is truncated, copy it again or export it again"
        )
    values = np.full((frames, 2 + 3 * count), np.nan)
    for row, k in enumerate(rows):
        fields = lines[k].split("\t")[: values.shape[1]]
        try:
            values[row, : len(fields)] = [number_in(field) if field.strip() else np.nan for field in fields]
        except ValueError as error:
            raise InputError(
                f"{path}: expected numbers on line {k + 1}, found {str(error).partition(': ')[2]}: repair "
                "the file or export it again"
            ) from None
    _refuse_lost_frames(values[:, 0], path)
    positions = values[:, 2:].reshape(frames, count, 3)
    positions[(positions == 0.0).all(axis=2)] = np.nan
    return Markers(rate, tuple(labels), METRES_PER_UNIT[unit] * positions)


def _rate_and_sizes(settings: dict[str, str], path: Path) -> tuple[float, int, int]:
    """Rate (Hz), number of frames and of markers."""
    missing = [name for name in SETTINGS if name not in settings]
    if missing:
        raise InputError(
            f"{path}: expected the setting {missing[0]!r} on line 2, found {listed(settings)}: export the "
            "file again"
        )
    try:
        rate = float(settings["DataRate"])
        frames, count = (int(float(settings[name])) for name in ("NumFrames", "NumMarkers"))
    except (ValueError, OverflowError):
        rate = frames = count = 0
    if not (0.0 < rate < np.inf and 0 < frames < 1e8 and 0 < count < 1e4):
        values = ", ".join(f"{name} {settings[name]!r}" for name in SETTINGS[:3])
        raise InputError(
            f"{path}: expected a positive rate and numbers of frames and markers on line 3, found {values}: "
            "export the file again"
        )
    return rate, frames, count


def _refuse_lost_frames(counter: np.ndarray, path: Path) -> None:
    """Refuse a frame counter that does not count every frame."""
    bad = np.flatnonzero(np.diff(counter) != 1.0)
    if bad.size:
        k = bad[0]
        raise InputError(
            f"{path}: expected every frame after frame {counter[k]:g}, found {counter[k + 1]:g} next: export "
            "all frames, with empty fields where markers were hidden"
        )


def trc_contents(path: Path) -> Contents:
    """Contents of a TRC file (m)."""
    markers = read_trc(path)
    frames = markers.positions.shape[0]
    facts = {"frames": str(frames), "duration": f"{frames / markers.rate_hz:.6g} s"}
    channels = [
        Channel.of(label, "m", markers.rate_hz, markers.positions[:, k])
        for k, label in enumerate(markers.labels)
    ]
    visible = markers.positions[:, np.isfinite(markers.positions).any(axis=(0, 2))]
    upright = 2
    if visible.size:  # markers differ most in height
        upright = int(np.argmax(np.std(np.nanmedian(visible, axis=0), axis=0)))
    return Contents("TRC", facts, channels, tuple(markers.labels), vertical=upright)


FORMAT = Format(
    name="TRC",
    fits=lambda head: head.first_line.startswith("PathFileType"),
    contents=trc_contents,
    endings=(".trc",),
    text=True,
    purpose="markers",
    read_markers=read_trc,
)
