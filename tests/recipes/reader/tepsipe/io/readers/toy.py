"""Markers from a toy format: ``TOY`` and the rate, labels, then a row (mm) for every frame."""

from pathlib import Path

import numpy as np

from tepsipe.errors import InputError, quoted
from tepsipe.io.file_format import Channel, Contents, Format
from tepsipe.io.readers.plain_file import read_text
from tepsipe.io.readers.recording import Markers


def read_toy(path: str | Path) -> Markers:
    """All markers of a file in the toy format (m)."""
    head, *lines = read_text(path, "a toy file").splitlines()
    try:
        rate, labels = float(head.split()[1]), tuple(lines[0].split())
        rows = np.array([line.split() for line in lines[1:]], dtype=float)
        return Markers(rate, labels, 1e-3 * rows.reshape(-1, len(labels), 3))
    except (IndexError, ValueError):
        raise InputError(
            f"{path}: expected a rate, labels and three numbers for each of them in every frame, found "
            f"{quoted(head)} and {len(lines)} further lines: export the file again"
        ) from None


def toy_contents(path: Path) -> Contents:
    """Contents of a file in the toy format (m)."""
    markers = read_toy(path)
    channels = [
        Channel.of(label, "m", markers.rate_hz, markers.positions[:, k])
        for k, label in enumerate(markers.labels)
    ]
    return Contents("TOY", {"frames": str(len(markers.positions))}, channels, markers.labels)


FORMAT = Format(
    name="TOY",
    fits=lambda head: head.first_line.startswith("TOY"),
    contents=toy_contents,
    endings=(".toy",),
    text=True,
    purpose="markers",
    read_markers=read_toy,
)
