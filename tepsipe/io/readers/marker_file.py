"""Markers from a file of any kind that holds them."""

from pathlib import Path

from tepsipe.errors import InputError, listed, quoted
from tepsipe.io.readers import c3d
from tepsipe.io.readers.c3d import c3d_markers, open_c3d
from tepsipe.io.readers.file_kind import TABLE, TEXTS, TRC, kind_of
from tepsipe.io.readers.recording import Markers, select_markers


def read_all_markers(path: str | Path) -> Markers:
    """Read all markers of a C3D file, a TRC file or a text table.

    path: the file, plain or, if it is text, compressed with gzip; its kind follows from its content.
    Returns: rate, labels and positions, NaN while a marker was hidden.
    """
    path = Path(path)
    kind = kind_of(path)
    if kind == TRC:
        from tepsipe.io.readers.trc import read_trc

        return read_trc(path)
    if kind == TABLE:
        from tepsipe.io.readers.signal_table import read_table_recording

        recording = read_table_recording(path)
        if recording.markers is None:
            raise InputError(
                f"{path}: expected columns of markers, such as HEEL_x, HEEL_y and HEEL_z, found "
                f"{listed(recording.channels)}: name the coordinates of every marker in the header"
            )
        return recording.markers
    if kind in TEXTS:
        raise InputError(
            f"{path}: expected markers as C3D, TRC or a text table, found {quoted(kind)}: name D-Flow's "
            "mocap file beside its record file, and other files by their own column"
        )
    return c3d_markers(open_c3d(path), path)


def read_markers(path: str | Path, labels: list[str]) -> Markers:
    """Read the wanted markers of a C3D file, a TRC file or a text table.

    path: the file, as in `read_all_markers`.
    labels: names of the wanted markers, in the wanted order.
    Returns: rate, labels and positions.
    """
    if kind_of(path) in TEXTS:
        return select_markers(read_all_markers(path), labels, path)
    return c3d.read_markers(path, labels)
