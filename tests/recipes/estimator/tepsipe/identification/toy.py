"""A toy: I, B, K by ordinary least squares in the window of every perturbation, with a constant torque c.

tau - tau_rest = I theta'' + B theta' + K (theta - theta_rest) + c
"""

import numpy as np

from tepsipe.identification.estimators import Record
from tepsipe.identification.regression.windows import WindowedFits
from tepsipe.mechanics.impedance_model import impedance_torque
from tepsipe.statistics.least_squares import least_squares_line


def fit_windows(record: Record) -> WindowedFits:
    """I, B, K of every perturbation; angle and torque refer to rest."""
    motion, rest = record.motion, record.at_rest
    theta_rest, torque_rest = float(motion.theta[rest].mean()), float(record.torque[rest].mean())
    torque = record.torque - torque_rest
    regressors = np.column_stack([motion.theta_dd, motion.theta_d, motion.theta - theta_rest])
    windows = [slice(p.start, p.stop) for p in record.perturbations]
    parts = [(regressors[window], torque[window]) for window in windows]
    fits = [least_squares_line(x - x.mean(axis=0), y - y.mean()) for x, y in parts]
    mean = np.mean([fit.parameters for fit in fits], axis=0)
    predicted = impedance_torque(mean, regressors[:, 2], regressors[:, 1], regressors[:, 0])
    return WindowedFits(record.perturbations, fits, torque, predicted, regressors, theta_rest, torque_rest)
