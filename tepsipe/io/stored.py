"""A trial or a result of the study, whichever of the two an HDF5 file holds."""

from pathlib import Path

import h5py

from tepsipe.errors import InputError
from tepsipe.io.hdf5_file import read_hdf5
from tepsipe.io.result import Result, read_result
from tepsipe.io.trial import Trial, read_trial


def read_stored(path: str | Path) -> Trial | Result:
    """Read an HDF5 file of the study (arrays in the units that it names)."""
    path = Path(path)
    if not path.is_file():
        raise InputError(f"{path}: expected a file of the study, found none: correct its path")
    is_trial = read_hdf5(
        _is_trial,
        path,
        expected="an HDF5 file of the study (trials/ or fits/)",
        actual="another kind or a damaged one",
        advice="correct its path or make it again",
    )
    return read_trial(path) if is_trial else read_result(path)


def _is_trial(path: Path) -> bool:
    with h5py.File(path, "r") as file:
        return "experiment" in file.attrs
