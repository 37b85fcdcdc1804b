"""Entry to a benchmark: the parallel cascade of McGill's toolbox NLID, with its defaults, in GNU Octave.

    NLID_FOLDER=/path/to/reklab_public python benchmarks/nlid/enter_with_nlid.py FOLDER nlid.csv

answers the problems of the kind ``ankle`` (``tepsipe benchmark make``), about 3 CPU-s each. The toolbox fits
an impulse response to the intrinsic pathway. I, B and K are those of the second-order model nearest to the
torque that this response predicts below 10 Hz. There are no intervals.
"""

import csv
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from run import DRIVER, LONGEST_S, find_octave, find_toolbox
from scipy.signal import butter, sosfiltfilt

MODEL = "pc-sls-100Hz"


def impedance(time: np.ndarray, angle: np.ndarray, torque: np.ndarray) -> dict[str, float]:
    """I (N·m·s²/rad), B (N·m·s/rad) and K (N·m/rad) from a record (s, rad, N·m)."""
    with tempfile.TemporaryDirectory() as folder:
        np.savetxt(f"{folder}/record.txt", np.column_stack([angle, torque]))
        arguments = [str(find_toolbox()), f"{folder}/record.txt", f"{1.0 / (time[1] - time[0]):.6g}"]
        arguments += ["1", str(time.size), folder, MODEL]
        command = [find_octave(), "--no-gui", "--quiet", str(DRIVER), *arguments]
        # Octave may fail while it ends, after it has written everything
        subprocess.run(command, capture_output=True, timeout=LONGEST_S, check=False)
        predicted = np.loadtxt(f"{folder}/{MODEL}-intrinsic.txt")
    at, intrinsic = predicted.T
    x = low_pass(angle, 1.0 / (time[1] - time[0]))
    velocity = np.gradient(x, time)
    motion = np.column_stack([np.gradient(velocity, time), velocity, x, np.ones_like(x)])
    columns = np.column_stack([np.interp(at, time, column) for column in motion.T])
    wanted = low_pass(intrinsic, 1.0 / (at[1] - at[0]))
    # ends of the prediction are incomplete
    return dict(zip("IBK", np.linalg.lstsq(columns[50:-50], wanted[50:-50], rcond=None)[0], strict=False))


def low_pass(signal: np.ndarray, rate_hz: float) -> np.ndarray:
    """Signal below 10 Hz (its unit)."""
    return sosfiltfilt(butter(2, 10.0, fs=rate_hz, output="sos"), signal)


def main(folder: Path, answers: Path) -> None:
    """Answer the rows of the template that belong to an ankle."""
    with open(folder / "answers-template.csv", encoding="utf-8") as file:
        rows = [row for row in csv.DictReader(file) if row["problem"].startswith("ankle")]
    found: dict[str, dict[str, float]] = {}
    for row in rows:
        if row["problem"] not in found:
            signals = np.genfromtxt(folder / "arrays" / f"{row['problem']}.csv", delimiter=",", names=True)
            named = (signals[name] for name in ("time_s", "angle_rad", "torque_Nm"))
            found[row["problem"]] = impedance(*named)
        row["value"] = f"{found[row['problem']][row['quantity']]:.8g}"
    with open(answers, "w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, rows[0].keys())
        writer.writeheader()
        writer.writerows(rows)


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:]))
