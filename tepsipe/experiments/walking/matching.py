"""Perturbed strides minus their unperturbed prediction, from unperturbed strides with the same past.

An unperturbed stride is cut at the same time after its heel strike as the pulse. What follows is predicted
from the state at the onset, by ridge regression on standardised features of the unperturbed strides:

    y_hat = y_mean + Z b,    b = (Z'Z + lambda n 1)^-1 Z'(Y - y_mean)

Without features this is the plain mean (Rouse et al. 2014). The value at the onset is subtracted from
each signal first. Nearest neighbours and an extrapolation of slopes do worse with some 40 strides.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
import scipy

FEATURE_STEP_S = 0.02  # a feature's slope is a difference over this time


@dataclass(frozen=True)
class Matching:
    """Prediction of unperturbed behaviour after an onset."""

    centre: Annotated[np.ndarray, "(f,)"]
    scale: Annotated[np.ndarray, "(f,)"]
    """Mean and standard deviation of the features over the unperturbed strides."""
    slope: Annotated[np.ndarray, "(f, k)"]
    """Change of the predicted signals per standard deviation of a feature (units of the signals)."""
    mean: Annotated[np.ndarray, "(k,)"]
    """Mean of the signals over the unperturbed strides (units of the signals)."""
    leverage: np.ndarray
    """Share of each unperturbed stride in its own prediction."""

    def predict(self, features: np.ndarray) -> np.ndarray:
        """Unperturbed behaviour, shape (m, k) (units of the signals), for features, shape (m, f)."""
        return self.mean + (features - self.centre) / self.scale @ self.slope


def fit_matching(
    features: Annotated[np.ndarray, "(n, f)"], signals: Annotated[np.ndarray, "(n, k)"], ridge: float
) -> Matching:
    """Fit the prediction to unperturbed strides.

    features: state at the onset; f may be 0.
    signals: signals after the onset.
    ridge: strength of the penalty lambda, relative to the number of strides.
    """
    n, f = features.shape
    centre, scale = features.mean(axis=0), features.std(axis=0)
    # a feature without scatter predicts nothing
    scale = np.where(scale > 1e-6 * np.abs(features).max(axis=0, initial=0.0), scale, np.inf)
    z, mean = (features - centre) / scale, signals.mean(axis=0)
    inverse = np.linalg.inv(z.T @ z + ridge * n * np.eye(f)) @ z.T
    leverage = 1.0 / n + np.einsum("nf,fn->n", z, inverse)
    return Matching(centre, scale, inverse @ (signals - mean), mean, leverage)


def left_out_residuals(matching: Matching, features: np.ndarray, signals: np.ndarray) -> np.ndarray:
    """Difference of each unperturbed stride from its prediction by the others, shape (n, k).

    The residual over 1 - leverage, exact for the mean and for a ridge regression whose standardisation is
    kept.
    """
    return (signals - matching.predict(features)) / (1.0 - matching.leverage)[:, None]


def cut(spline: "scipy.interpolate.CubicSpline", onsets: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Values of a signal at times ``after`` each onset (s), shape (onsets, after) (unit of the signal)."""
    return spline(onsets[:, None] + after)


def state_features(
    splines: list, onsets: Annotated[np.ndarray, "(n,)", "s"], before_s: float
) -> Annotated[np.ndarray, "(n, 2 f)"]:
    """State shortly before each onset: value and change of each signal.

    before_s: the state is that so long before the onset (s): a zero-lag filter brings the pulse forward.
    Returns: value of each signal and its change within 20 ms (units of the signals).
    """
    at = onsets - before_s
    columns = []
    for spline in splines:
        now = spline(at)
        columns += [now, now - spline(at - FEATURE_STEP_S)]
    return np.stack(columns, axis=1) if columns else np.zeros((onsets.size, 0))
