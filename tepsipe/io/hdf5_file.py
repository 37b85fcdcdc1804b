"""Read the study's own HDF5 files, or refuse them in one sentence."""

from collections.abc import Callable
from pathlib import Path

from tepsipe.errors import InputError, quoted
from tepsipe.io.readers.guarded import guarded


def read_hdf5(
    read: Callable,
    path: str | Path,
    expected: str,
    found: str = "one that cannot be read",
    advice: str = "make it again",
):
    """What ``read`` returns for an HDF5 file, in a child process with limits (`guarded`).

    Parameters
    ----------
    read : callable
        Takes the path; its result can be pickled.
    path : str or Path
        The file.
    expected, found, advice : str
        Parts of the message: what the file should be, what one is that cannot be read, what to do about it.

    Returns
    -------
    object
        The function's result (units there).

    Raises
    ------
    InputError
        If the file cannot be read, or takes more time or memory than allowed.
    """
    try:
        return guarded(read, path, what=path)
    except InputError:
        raise
    except Exception as error:  # h5py raises many kinds on damaged files
        raise InputError(f"{path}: expected {expected}, found {found} ({quoted(error)}): {advice}") from error
