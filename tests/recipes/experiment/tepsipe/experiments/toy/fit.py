"""Stiffness of a spring by least squares: tau = K theta."""

import numpy as np

from tepsipe.experiments.budgets import rows_of
from tepsipe.experiments.fitted import Fitted
from tepsipe.experiments.toy.ingest import FitOptions
from tepsipe.identification.result import Quantity, symbol_of
from tepsipe.io.estimates import recommended
from tepsipe.io.result import Result
from tepsipe.io.trial import Trial
from tepsipe.statistics.least_squares import least_squares_line


def begin(trial: Trial, section: dict, name: str) -> tuple[np.ndarray, np.ndarray]:
    """Angle (rad), shape (n, 1), and torque (N·m) without the ends of the trial."""
    cut_s, time = FitOptions(**section["analysis"]).cut_s, trial.time
    kept = (time >= time[0] + cut_s) & (time <= time[-1] - cut_s)
    return trial.values("angle")[kept, None], trial.values("torque")[kept]


def fit(trial: Trial, section: dict, condition: str) -> Fitted:
    """Stiffness of the spring."""
    angle, torque = begin(trial, section, condition)
    line = least_squares_line(angle, torque)
    stiffness, u = float(line.parameters[0]), float(line.standard_error[0])
    ends = (stiffness - 1.96 * u, stiffness + 1.96 * u)
    quantities = {"K": Quantity(stiffness, symbol_of("K"), u, *ends)}
    rows = recommended(rows_of(("toy", condition, "spring", "line"), quantities), "spring")
    arrays = {"angle": angle[:, 0], "torque": torque}
    return Fitted(Result(arrays, {"angle": "rad", "torque": "Nm"}, {"samples": len(torque)}), rows)
