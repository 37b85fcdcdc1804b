"""Files that hold a whole trial, each kind by its own reader.

A new kind is one more entry in `READERS`: its ending, in lower case, and a function that takes the path and
returns a `Recording`.
"""

from collections.abc import Callable
from pathlib import Path

from tepsipe.errors import InputError, quoted
from tepsipe.io.readers.file_kind import DFLOW, ending_of, kind_of
from tepsipe.io.readers.recording import Recording


def _read_c3d(path: Path) -> Recording:
    from tepsipe.io.readers.c3d import read_c3d_recording

    return read_c3d_recording(path)


def _read_text(path: Path) -> Recording:
    if kind_of(path) == DFLOW:
        from tepsipe.io.readers.dflow import read_dflow_recording

        return read_dflow_recording(path)
    from tepsipe.io.readers.signal_table import read_table_recording

    return read_table_recording(path)


TEXT_ENDINGS = (".txt", ".csv", ".tsv")
READERS: dict[str, Callable[[Path], Recording]] = {
    ".c3d": _read_c3d,
    **dict.fromkeys(TEXT_ENDINGS, _read_text),
}


def holds_whole_trial(path: str | Path) -> bool:
    """Test for a name whose kind of file holds a whole trial; the file need not exist."""
    return ending_of(path) in READERS


def read_recording(path: str | Path) -> Recording:
    """Read a file that holds a whole trial, by the reader of its kind.

    path: the file; its kind follows from the ending of its name.
    Returns: markers, force plates and analog channels in their units.
    """
    if not holds_whole_trial(path):
        raise InputError(
            f"{path}: expected a file that holds a whole trial ({', '.join(READERS)}), found "
            f"{quoted(ending_of(path))}: name such a file as log, or a log with its calibration and markers"
        )
    return READERS[ending_of(path)](Path(path))
