"""Entry to a benchmark by a method from elsewhere, as an example: an ARX model of the torque, by SysIdentPy.

    python benchmarks/enter_with_sysidentpy.py FOLDER sysidentpy-arx.csv

reads the arrays of the problems in FOLDER (``tepsipe benchmark make``) and writes a table of answers. It
needs NumPy, SciPy and SysIdentPy 0.9 (Lacerda et al. 2020, Journal of Open Source Software 5, 2384), and
nothing of this project. The input of the model is the angle, at 100 to 125 Hz and advanced by 4 samples,
because the torque leads it. I, B and K are fitted to the frequency response of the model below 10 Hz. There
are no intervals.
"""

import csv
import sys
from pathlib import Path

import numpy as np
from scipy.signal import decimate
from sysidentpy.basis_function import Polynomial
from sysidentpy.model_structure_selection import FROLS
from sysidentpy.parameter_estimation import LeastSquares

TORQUE_LAGS, ANGLE_LAGS, AHEAD = 4, 12, 4


def impedance(time: np.ndarray, angle: np.ndarray, torque: np.ndarray) -> dict[str, float]:
    """I (N·m·s²/rad), B (N·m·s/rad) and K (N·m/rad) from a record (s, rad, N·m)."""
    every = int(0.01 / (time[1] - time[0]) + 0.25)
    step_s = every * (time[1] - time[0])
    angle, torque = (decimate(x - x.mean(), every, ftype="fir") for x in (angle, torque))
    model = FROLS(
        order_selection=False,
        n_terms=TORQUE_LAGS + ANGLE_LAGS,
        ylag=TORQUE_LAGS,
        xlag=ANGLE_LAGS,
        basis_function=Polynomial(degree=1),
        estimator=LeastSquares(),
    )
    model.fit(X=angle[AHEAD:, None], y=torque[: angle.size - AHEAD, None])
    w = 2.0 * np.pi * np.linspace(0.5, 10.0, 39)
    numerator, denominator = np.zeros(w.size, dtype=complex), np.ones(w.size, dtype=complex)
    for (code,), coefficient in zip(model.final_model, np.ravel(model.theta), strict=True):
        signal, lag = divmod(int(code), 1000)  # 1: torque, 2: angle
        delayed = coefficient * np.exp(-1j * w * step_s * lag)
        if signal == 1:
            denominator -= delayed
        else:
            numerator += delayed
    stiffness = numerator / denominator * np.exp(1j * w * step_s * AHEAD)
    columns = np.column_stack([-(w**2), np.ones_like(w)])
    inertia, static = np.linalg.lstsq(columns, stiffness.real, rcond=None)[0]
    return {"I": inertia, "B": (w @ stiffness.imag) / (w @ w), "K": static}


def main(folder: Path, answers: Path) -> None:
    """Answer every row of the template."""
    with open(folder / "answers-template.csv", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
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
