"""Files that hold a whole trial, each kind by its own reader.

A new kind is one more entry in `READERS`: its ending, in lower case, and a function that takes the path and
returns a `Recording`.
"""

from collections.abc import Callable
from pathlib import Path

from tepsipe.errors import InputError, quoted
from tepsipe.io.readers.recording import Recording


def _read_c3d(path: Path) -> Recording:
    from tepsipe.io.readers.c3d_recording import read_c3d_recording

    return read_c3d_recording(path)


READERS: dict[str, Callable[[Path], Recording]] = {".c3d": _read_c3d}


def holds_whole_trial(path: str | Path) -> bool:
    """Whether files of this name's kind hold a whole trial (no unit); the file need not exist."""
    return ending_of(path) in READERS


def ending_of(path: str | Path) -> str:
    """Ending of a file's name in lower case, without that of gzip (no unit)."""
    suffixes = [suffix.lower() for suffix in Path(path).suffixes]
    return "".join((suffixes[:-1] if suffixes[-1:] == [".gz"] else suffixes)[-1:])


def read_recording(path: str | Path) -> Recording:
    """Read a file that holds a whole trial, by the reader of its kind.

    Parameters
    ----------
    path : str or Path
        The file; its name's ending says what kind it is.

    Returns
    -------
    Recording
        Markers (m), force plates (N, N·m) and analog channels in their units.

    Raises
    ------
    InputError
        If the kind is unknown, or the file cannot be read.
    """
    if not holds_whole_trial(path):
        raise InputError(
            f"{path}: expected a file that holds a whole trial ({', '.join(READERS)}), found "
            f"{quoted(ending_of(path))}: name such a file as log, or a log with its calibration and markers"
        )
    return READERS[ending_of(path)](Path(path))
