"""Read the study's own HDF5 files, or refuse them in one sentence; write their arrays."""

from collections.abc import Callable
from pathlib import Path

import h5py
import numpy as np

from tepsipe.errors import InputError, quoted
from tepsipe.io.readers.guarded import guarded

# compression would enlarge an array smaller than this (bytes)
LARGE_BYTES = 4096


def write_array(group: h5py.Group, name: str, values: np.ndarray) -> h5py.Dataset:
    """Write an array and return its dataset; a large one is compressed, without loss."""
    values = np.asarray(values)
    if values.nbytes < LARGE_BYTES:
        return group.create_dataset(name, data=values)
    return group.create_dataset(name, data=values, compression="gzip", compression_opts=1, shuffle=True)


def read_hdf5(
    read: Callable,
    path: str | Path,
    expected: str,
    actual: str = "one that cannot be read",
    advice: str = "make it again",
):
    """Read an HDF5 file with ``read``, in a child process with limits (`guarded`).

    read: takes the path; its result can be pickled.
    expected, actual, advice: parts of the message: what the file should be, what one is that cannot be
    read, what to do about it.

    Returns
    -------
    object
        The function's result.
    """
    try:
        return guarded(read, path, what=path)
    except InputError:
        raise
    except Exception as error:  # h5py raises many kinds on damaged files
        raise InputError(
            f"{path}: expected {expected}, found {actual} ({quoted(error)}): {advice}"
        ) from error
