"""Recordings of several joints in HDF5: unperturbed standing, and epochs of every perturbation."""

from pathlib import Path

import h5py
import numpy as np

from tepsipe.experiments.planning.several_joints import Recording


def read_draws(path: str | Path) -> list[Recording]:
    """Recordings of all simulated persons of a file (rad, N, m/s²).

    Parameters
    ----------
    path : str or Path
        HDF5 file: one group per person with the data set ``unperturbed`` and the groups ``angle`` and
        ``drive`` with a data set per perturbation.

    Returns
    -------
    list of Recording
        In the order of their numbers.
    """
    with h5py.File(path) as file:
        return [_recording(file[name]) for name in sorted(file, key=int)]


def _recording(group) -> Recording:
    def arrays(name: str) -> dict[str, np.ndarray]:
        return {key: group[name][key][()] for key in group[name].attrs["names"]}

    return Recording(
        group["unperturbed"][()],
        arrays("angle"),
        arrays("drive"),
        float(group.attrs["rate_hz"]),
        float(group.attrs["drive_rate_hz"]),
        int(group.attrs["before"]),
    )
