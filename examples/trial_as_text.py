"""Write a trial of the study as D-Flow's two text files, and as one table with its markers as TRC.

    python examples/trial_as_text.py results/trials/dummy/sine-0.5.h5 recordings/dflow recordings/table

Use it to see what such files look like, and to try them without recordings of your own.
"""

import sys
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from tepsipe import Trial, read_trial

Samples = npt.NDArray[np.floating[Any]]

LATE_S = 1.3  # error of the record file's time stamps
# the study's x to the right, y forward, z up -> D-Flow's x to the right, y up, z backward
TO_DFLOW = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [0.0, -1.0, 0.0]])


def write(path: Path, names: list[str], columns: list[Samples], delimiter: str) -> None:
    """Columns with six decimals under a header; the frame counter in whole numbers."""
    formats = ["%d" if name in ("FrameNumber", "Frame#") else "%.6f" for name in names]
    header = delimiter.join(names)
    np.savetxt(path, np.column_stack(columns), formats, delimiter, header=header, comments="")


def write_dflow(trial: Trial, folder: Path) -> None:
    """Mocap and record file."""
    time, markers = trial.time, trial.axes["marker"].tolist()
    names, columns = ["TimeStamp", "FrameNumber"], [208.0 + time, 1.0 + np.arange(time.size)]
    for label, position in zip(markers, trial.values("marker_position").transpose(1, 0, 2), strict=True):
        names += [f"{label}.Pos{axis}" for axis in "XYZ"]
        columns += list((position @ TO_DFLOW.T).T)
    for k in range(trial.axes["belt"].size):
        for kind, signal in (("For", "force"), ("Mom", "moment")):
            names += [f"FP{k + 1}.{kind}{axis}" for axis in "XYZ"]
            columns += list((trial.values(signal)[:, k] @ TO_DFLOW.T).T)
    write(folder / "Mocap0001.txt", names, columns, "\t")
    # D-Flow's own rate: irregular, about 200 Hz
    instants = np.cumsum(np.random.default_rng(1).uniform(0.003, 0.007, round(200.0 * time[-1])))
    instants = instants[instants < time[-1]]
    speed = -np.interp(instants, time, trial.values("belt_velocity"))
    columns = [208.0 + LATE_S + instants, 0.0 * speed, speed]
    write(folder / "Record0001.txt", ["Time", "LeftBeltSpeed", "RightBeltSpeed"], columns, "\t")


def write_table(trial: Trial, folder: Path) -> None:
    """Forces, moments and belt velocity as CSV, markers as TRC."""
    time, markers = trial.time, trial.axes["marker"].tolist()
    names, columns = ["time (s)", "belt (m/s)"], [time, trial.values("belt_velocity")]
    for k, belt in enumerate(trial.axes["belt"].tolist()):
        for kind, signal, unit in (("F", "force", "N"), ("M", "moment", "Nm")):
            names += [f"{kind}{axis}_{belt} ({unit})" for axis in "xyz"]
            columns += list(trial.values(signal)[:, k].T)
    write(folder / "trial.csv", names, columns, ",")
    path, positions = folder / "trial.trc", 1000.0 * trial.values("marker_position")
    names, columns = ["Frame#", "Time"], [1.0 + np.arange(time.size), time]
    names += [name for label in markers for name in (label, "", "")]
    write(path, names, [*columns, *positions.reshape(time.size, -1).T], "\t")
    first, _, rest = path.read_text().partition("\n")
    numbers = "\t".join(f"{axis}{k + 1}" for k in range(len(markers)) for axis in "XYZ")
    head = [
        "PathFileType\t4\t(X/Y/Z)\ttrial.trc",
        "DataRate\tCameraRate\tNumFrames\tNumMarkers\tUnits",
        f"{trial.rate_hz:g}\t{trial.rate_hz:g}\t{time.size}\t{len(markers)}\tmm",
        first,
        f"\t\t{numbers}",
    ]
    path.write_text("\n".join(head) + "\n" + rest)


def main(trial: str, dflow: str, table: str) -> None:
    """Write both kinds into two folders."""
    content = read_trial(trial)
    for folder, make in ((Path(dflow), write_dflow), (Path(table), write_table)):
        folder.mkdir(parents=True, exist_ok=True)
        make(content, folder)
        print(f"written: {', '.join(str(path) for path in sorted(folder.iterdir()))}")


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(__doc__)
    main(*sys.argv[1:])
