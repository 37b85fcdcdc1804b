"""Signals of perturbed strides after the onset of their pulses, minus matched unperturbed strides.

Perturbed strides minus their unperturbed prediction, from unperturbed strides with the same past.

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

from tepsipe.errors import InputError, listed, quoted
from tepsipe.experiments.walking.strides import CONTACT_N, WalkingRecording, ankle_moment
from tepsipe.signals.filters import butterworth_lowpass

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


# signal and order of its time derivative; the value at the onset is subtracted from each
CHANNELS = (
    ("angle", 0),
    ("angle", 1),
    ("angle", 2),
    ("moment", 0),
    ("moment", 1),
    ("vertical", 0),
    ("anterior", 0),
    ("ankle_x", 2),
)
ANGLE, RATE, ACCELERATION, MOMENT, MOMENT_RATE, VERTICAL, ANTERIOR, FOOT_ACCELERATION = range(len(CHANNELS))


@dataclass(frozen=True)
class FilteredWalk:
    """Splines through the low-passed signals of a trial, all filtered alike."""

    splines: "dict[str, scipy.interpolate.CubicSpline]"
    """angle (rad), moment (N·m), vertical and anterior force (N), ankle_x (m) over time (s)."""
    state: list
    """Signals from which unperturbed behaviour is predicted."""
    rate_hz: float
    """Rate of the recording."""


@dataclass(frozen=True)
class Deviations:
    """Strides minus their unperturbed behaviour, for one phase."""

    time: Annotated[np.ndarray, "(w,)", "s"]
    """After the onset."""
    perturbed: Annotated[np.ndarray, "(n, 8, w)"]
    """Perturbed strides: the signals of `CHANNELS` (rad, rad/s, rad/s2, N·m, N·m/s, N, N, m/s2)."""
    unperturbed: Annotated[np.ndarray, "(m, 8, w)"]
    """Unperturbed strides, each minus its prediction by the others, in their order (the same units)."""


def filter_walk(
    recording: WalkingRecording, cutoff_hz: float, order: int, matched_by: tuple[str, ...] | None
) -> FilteredWalk:
    """Low-pass all signals of a trial alike.

    order: order of both passes together.
    matched_by: signals of which the state at the onset is taken: moment, angle, vertical, anterior,
    other_vertical or names of the recording's ``state``; None for all, () for the plain mean.
    """
    contact = recording.vertical > CONTACT_N
    known = {
        "moment": ankle_moment(recording),
        "angle": recording.angle,
        "vertical": np.where(contact, recording.vertical, 0.0),
        "anterior": np.where(contact, recording.anterior, 0.0),
        "ankle_x": recording.ankle_x,
        "other_vertical": recording.other_vertical,
        **recording.state,
    }
    filtered = butterworth_lowpass(
        np.stack(list(known.values()), axis=1), recording.rate_hz, cutoff_hz, order
    )
    splines = {
        name: scipy.interpolate.CubicSpline(recording.time, column)
        for name, column in zip(known, filtered.T, strict=True)
    }
    chosen = [name for name in known if name != "ankle_x"] if matched_by is None else matched_by
    for name in chosen:
        if name not in splines:
            raise InputError(
                f"{recording.name}: expected matched_by to name signals among {listed(known)}, found "
                f"{quoted(name)}: correct it"
            )
    return FilteredWalk(splines, [splines[name] for name in chosen], recording.rate_hz)


def subtract_unperturbed(
    walk: FilteredWalk,
    pulses: tuple[np.ndarray, np.ndarray],
    unperturbed: Annotated[np.ndarray, "(m,)", "s"],
    window_s: float,
    ridge: float,
    before_s: float,
) -> Deviations:
    """Deviations of the perturbed strides of one phase.

    pulses: onsets and their delays after the heel strike (s). Shape (n,).
    unperturbed: heel strikes of unperturbed strides.
    window_s: length of the window.
    ridge: penalty of the matching, relative to the number of strides.
    before_s: the state is that so long before the onset.
    Returns: deviations of the strides of this phase.
    """
    onset, delay = pulses
    time = np.arange(1, round(window_s * walk.rate_hz) + 1) / walk.rate_hz
    rounded = np.round(delay, 3)  # pulses of one delay share their unperturbed strides
    perturbed = np.empty((onset.size, len(CHANNELS), time.size))
    for value in np.unique(rounded):
        alike = rounded == value
        matching, *_ = _matching(walk, unperturbed + delay[alike].mean(), time, ridge, before_s)
        predicted = matching.predict(state_features(walk.state, onset[alike], before_s))
        perturbed[alike] = _signals(walk, onset[alike], time) - predicted.reshape(
            -1, len(CHANNELS), time.size
        )
    matching, features, signals = _matching(walk, unperturbed + delay.mean(), time, ridge, before_s)
    residuals = left_out_residuals(matching, features, signals)
    return Deviations(time, perturbed, residuals.reshape(-1, len(CHANNELS), time.size))


def _matching(walk: FilteredWalk, onsets: np.ndarray, time: np.ndarray, ridge: float, before_s: float):
    """The prediction, and the features and signals of the unperturbed strides that it was fitted to."""
    features = state_features(walk.state, onsets, before_s)
    signals = _signals(walk, onsets, time).reshape(onsets.size, -1)
    return fit_matching(features, signals, ridge), features, signals


def _signals(walk: FilteredWalk, onsets: np.ndarray, time: np.ndarray) -> np.ndarray:
    """Signals of `CHANNELS` after each onset, shape (n, 8, w), relative to the onset.

    This holds for derivatives as well, because a zero-lag filter moves the start of the pulse before the
    onset.
    """
    responses = []
    for name, order in CHANNELS:
        spline = walk.splines[name].derivative(order) if order else walk.splines[name]
        values = cut(spline, onsets, time)
        responses.append(values - spline(onsets)[:, None])
    return np.stack(responses, axis=1)
