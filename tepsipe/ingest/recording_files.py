"""Files of one trial to one recording: one that holds everything, or a pair that shares its clock."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from tepsipe.errors import InputError
from tepsipe.ingest.dflow import read_dflow_files
from tepsipe.io.formats import read_all_markers, read_recording, recognised
from tepsipe.io.readers import dflow
from tepsipe.io.readers.recording import Recording

# log and markers start together and last as long as each other within this (s)
LENGTHS_WITHIN_S = 0.1


def read_recording_files(files: dict[str, str], belt_fixed_labels: tuple[str, ...]) -> Recording:
    """Read the recording of a trial without calibration matrix.

    files: Paths: ``log`` alone, which holds everything; or ``log`` and ``markers``: D-Flow's record and
    mocap file, or a file of forces and belt velocity and one of markers that begin at the same instant.
    belt_fixed_labels: belt-fixed markers, which align D-Flow's two files.
    Returns: markers, force plates and channels, in the axes of the files.
    """
    log = files["log"]
    if "markers" not in files:
        return read_recording(log)
    formats = recognised(log), recognised(files["markers"])
    if dflow.FORMAT in formats:
        if formats != (dflow.FORMAT, dflow.FORMAT):
            other = files["markers"] if formats[0] is dflow.FORMAT else log
            raise InputError(
                f"{other}: expected a text file of D-Flow beside the other one, found another kind: name the "
                "record file as log and the mocap file as markers"
            )
        return read_dflow_files(files["markers"], log, belt_fixed_labels)
    recording = read_recording(log)
    markers = read_all_markers(files["markers"])
    frames_s = markers.positions.shape[0] / markers.rate_hz
    rates = [(p.force.shape[0], p.rate_hz) for p in recording.plates]
    rates += [(c.values.size, c.rate_hz) for c in recording.channels.values()]
    log_s = min((n / rate for n, rate in rates), default=np.inf)
    if abs(frames_s - log_s) > LENGTHS_WITHIN_S:
        raise InputError(
            f"{files['markers']}: expected markers for the {log_s:.2f} s of {Path(log).name}, found "
            f"{frames_s:.2f} s: the two must begin and end together, cut them, or correct the trial sheet"
        )
    return replace(recording, markers=markers)
