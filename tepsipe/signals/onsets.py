"""Onsets of muscle activity in an ensemble of responses, and of a motion in a mechanical signal.

Symbols: x_i(t) band-passed, unrectified response to event i (uV); y(t) mean over events of the detector's
test signal; T onset (s); b baseline of y.

    threshold       y = <|x_i|>                           T: y > b + k SD(baseline), and stays there
    teager-kaiser   y = <x_i(t)^2 - x_i(t-d) x_i(t+d)>    T: the same, d one sampling interval
    changepoint     y = <|e_i|>, e_i = x_i - sum_j a_j x_i(t - j d)    T: most likely start of a ramp

The change point maximises the likelihood of

    y ~ gamma, mean mu(t) = b (1 + c max(0, t - T)),   standard deviation proportional to the mean
    -log L = sum_t [log mu(t) + y(t) / mu(t)] * const

because the standard deviation of rectified noise is proportional to its mean. The a_j predict a sample at
rest from those before it, so e_i is nearly white. The ramp is fitted up to a fraction of the first peak.

The 6 Hz envelope is not used, because it smears activity over more than 60 ms in both directions.

Sources: Hodges & Bui (1996) for the threshold; Li, Zhou & Aruin (2007) and Solnik et al. (2010) for the
energy operator; Staude (2001) for whitening and likelihood.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Literal

import numpy as np
import scipy
from annotated_types import Ge, Gt, Le

from tepsipe.errors import InputError
from tepsipe.quantities import Draws, Fraction, Pair, Pause, Positive, Thesis, Time

DETECTORS = ("threshold", "teager-kaiser", "changepoint")
# smallest number of draws for an uncertainty
FEWEST_DRAWS = 20
# shortest baseline for its mean and standard deviation (s)
SHORTEST_BASELINE_S = 0.1
# the change point: window in which activity must stand out, and window of the first peak (s)
STANDING_OUT_S = 0.011
PEAK_WITHIN_S = 0.05
# baseline that is fitted together with the ramp (s)
BEFORE_RAMP_S = 0.02
# heights of the ramp that are tried, in units of the baseline
HEIGHTS = np.geomspace(0.05, 100.0, 60)
# refinements of the best of the ramps tried
REFINEMENTS = 12
# an onset so near to an end of the searched time is that end, not an onset (s)
EDGE_S = 0.001


@dataclass(frozen=True)
class OnsetOptions:
    """Options of the detection."""

    detector: Annotated[Literal[DETECTORS], Thesis("chapter 5")] = "changepoint"
    """The detector shown in figures and used for intervals; all three are computed."""
    baseline_until_s: Annotated[float, Ge(-60), Le(60)] = 0.0
    """End of the baseline, from the onset."""
    search_s: Pair[Annotated[float, Ge(0), Le(60)]] = (0.02, 0.2)
    """Time of possible onsets; its start at most 0.05 s after `baseline_until_s`."""
    window_s: Time = 0.005
    """Length of the moving mean of `threshold` and `teager-kaiser`."""
    threshold_sd: Positive = 3.0
    """Threshold of both, in standard deviations of the baseline."""
    hold_s: Pause = 0.010
    """Time for which the threshold must be exceeded."""
    whitening_order: Annotated[int, Ge(0), Le(20)] = 1
    """Order of the linear prediction of `changepoint`."""
    signal_to_noise: Positive = 5.0
    """Number of standard errors by which its activity must exceed the baseline."""
    rise_fraction: Annotated[float, Gt(0), Le(1)] = 0.7
    """Its ramp is fitted up to this fraction of the first peak."""
    longest_rise_s: Time = 0.04
    """Greatest length of the ramp."""
    bootstrap_draws: Draws = 500
    """Number of ensembles resampled from the responses."""
    trusted_share: Fraction = 0.9
    """Fraction of them that must also have an onset."""


@dataclass(frozen=True)
class Onset:
    """An onset latency, or the reason why there is none."""

    latency_s: float | None
    """T, from the event."""
    standard_error_s: float | None
    """Standard deviation over resampled ensembles."""
    interval_s: tuple[float, float] | None
    """Their 2.5 and 97.5 % quantiles."""
    found_share: float | None
    """Fraction of the resampled ensembles that have an onset."""
    reason: str | None
    """One sentence if there is no onset."""
    at_edge: bool = False
    """Whether what was found is an end of the searched time."""


def detect_onset(
    time: Annotated[np.ndarray, "(m,)", "s"],
    responses: Annotated[np.ndarray, "(events, m)"],
    options: OnsetOptions,
    rng: np.random.Generator,
) -> Onset:
    """Onset latency of an ensemble of electromyographic responses.

    time: regular time from the event.
    responses: x_i, band-passed and unrectified, without movement artefact.
    Returns: latency, standard error and 95 % interval, or the reason why there is none.
    """
    _refuse_unusable(time, responses, options)
    events = responses.shape[0]
    looked_at = _looked_at(time, responses, options)
    drawn = rng.multinomial(events, np.full(events, 1.0 / events), size=options.bootstrap_draws)
    weights = np.vstack([np.ones(events), drawn]) / events
    y = weights @ looked_at
    if options.detector == "changepoint":
        error = _relative_error(time, looked_at, options)
        onsets, wanted = _change_points(time, y, error, options), 1.0 + options.signal_to_noise * error
    else:
        onsets, wanted = _crossings(time, y, options)
    detected = np.isfinite(onsets[1:])
    share = float(detected.mean()) if detected.size else None
    reason = None
    if np.isnan(onsets[0]):
        first, last = (1e3 * instant for instant in options.search_s)
        reason = (
            f"expected activity that begins to rise above {wanted:.3g} times its baseline {first:g} to "
            f"{last:g} ms after the event, found none: the muscle did not respond, or noise hides it"
        )
    elif min(abs(onsets[0] - end) for end in options.search_s) < EDGE_S:
        reason = (
            f"expected an onset within the searched time, found one at its end, {1e3 * onsets[0]:.3g} ms "
            "after the event: search elsewhere, the activity begins before or after"
        )
        return Onset(None, None, None, share, reason, at_edge=True)
    elif share is not None and share < options.trusted_share:
        reason = (
            f"expected an onset in at least {100 * options.trusted_share:g} % of the ensembles resampled "
            f"from the events, found one in {100 * share:.3g} %: record more perturbations"
        )
    if reason is not None:
        return Onset(None, None, None, share, reason)
    if not detected.size:
        return Onset(float(onsets[0]), None, None, None, None)
    low, high = np.quantile(onsets[1:][detected], [0.025, 0.975])
    spread = float(onsets[1:][detected].std(ddof=1))
    return Onset(float(onsets[0]), spread, (float(low), float(high)), share, None)


def ramp_onset(
    time: Annotated[np.ndarray, "(n,)", "s"],
    x: np.ndarray,
    baseline_until_s: float,
    rise_fraction: float = 0.5,
) -> Annotated[float, "s"]:
    """Instant at which a mechanical signal leaves rest, modelled as the start of a ramp.

    A broken stick, x(t) = b + c max(0, t - T), is fitted by least squares up to a fraction of the first
    peak, on a cubic spline through the samples. A zero-phase low-pass rounds the corner symmetrically, so
    it does not shift T. A soft start is detected late, as by the change point of a subsequent response;
    the delay between the two is unbiased.

    time: regular time.
    x: ensemble mean of a velocity.
    baseline_until_s: the signal is at rest until this instant.
    rise_fraction: the ramp is fitted up to this fraction of the first peak.
    """
    time, x = np.asarray(time, dtype=float), np.asarray(x, dtype=float)
    step = (time[-1] - time[0]) / (time.size - 1) if time.size > 1 else np.nan
    at_rest = time < baseline_until_s
    if not np.isfinite(x).all() or at_rest.sum() < 5 or at_rest.all():
        raise InputError(
            f"onset of a motion: expected at least 5 samples at rest and then a motion without NaN, found "
            f"{at_rest.sum()} of {time.size} samples before {baseline_until_s:g} s: cut longer epochs"
        )
    motion = x - x[at_rest].mean()
    size, noise = np.abs(motion).max(), np.abs(motion[at_rest]).max()
    if size <= 3.0 * noise or size == 0.0:
        raise InputError(
            f"onset of a motion: expected a peak of more than 3 times the largest value at rest, found "
            f"{size:.3g} and {noise:.3g}: check that the perturbation was applied, and when the rest ends"
        )
    first = int(np.argmax(np.abs(motion) >= 0.5 * size))
    motion = np.sign(motion[first]) * motion
    falls = np.flatnonzero(np.diff(motion[first:]) <= 0.0)
    top = first + (int(falls[0]) if falls.size else motion.size - 1 - first)
    fine = np.linspace(time[0], time[top], 10 * top + 1)
    z = scipy.interpolate.CubicSpline(time, motion)(fine)
    last = int(np.flatnonzero(z < rise_fraction * motion[top])[-1])
    t, z = fine[: last + 1], z[: last + 1]
    low, high = max(baseline_until_s, t[0]), t[-1] - 0.5 * step
    if high - low < 2.0 * step:
        raise InputError(
            f"onset of a motion: expected a motion after the rest, which lasts until {baseline_until_s:g} s, "
            f"found one at {t[-1]:.4g} s: end the rest earlier"
        )
    best, half_width = low, high - low
    for finer in (1.0, 0.1, 0.01):  # of a sample
        T = np.arange(max(low, best - half_width), min(high, best + half_width), finer * step)
        explained = _explained_by_ramp(t, z, T)
        k = int(np.clip(explained.argmax(), 1, T.size - 2))
        best, half_width = T[k], 2.0 * finer * step
    return float(best + 0.01 * step * _vertex(*explained[k - 1 : k + 2]))


def _explained_by_ramp(t: np.ndarray, z: np.ndarray, tried: np.ndarray) -> np.ndarray:
    """Sum of squares of z that b + c max(0, t - T) with c >= 0 explains, for each T tried."""
    ramp = np.maximum(t - tried[:, None], 0.0)
    ramp -= ramp.mean(axis=1, keepdims=True)
    return np.maximum(ramp @ (z - z.mean()), 0.0) ** 2 / (ramp**2).sum(axis=1)


# ---- parts of `detect_onset` -------------------------------------------------------------------


def _refuse_unusable(time: np.ndarray, responses: np.ndarray, options: OnsetOptions) -> None:
    """Raise InputError for responses or options that `detect_onset` cannot use."""
    if options.detector not in DETECTORS:
        raise InputError(
            f"onset detector: expected one of {', '.join(DETECTORS)}, found {options.detector!r}: "
            "change standing.latency.detector"
        )
    if responses.ndim != 2 or responses.shape[0] < 5 or responses.shape[1] != time.size:
        raise InputError(
            f"responses: expected at least 5, each with {time.size} samples, found an array of shape "
            f"{responses.shape}: record more perturbations"
        )
    if not np.isfinite(responses).all():
        raise InputError("responses: expected numbers, found NaN or infinite samples: leave these events out")
    if options.bootstrap_draws != 0 and options.bootstrap_draws < FEWEST_DRAWS:
        raise InputError(
            f"bootstrap of the onset: expected no draws or at least {FEWEST_DRAWS}, found "
            f"{options.bootstrap_draws}: change standing.latency.bootstrap_draws"
        )
    first, last = options.search_s
    before = options.longest_rise_s + BEFORE_RAMP_S + STANDING_OUT_S
    if not options.baseline_until_s <= first < last:
        raise InputError(
            f"searched time: expected it after the baseline, which ends at {options.baseline_until_s:g} s, "
            f"found {first:g} to {last:g} s: change standing.latency.search_s"
        )
    needed = min(options.baseline_until_s - SHORTEST_BASELINE_S, first - before)
    if time[0] > needed + 1e-9 or time[-1] < last - 1e-9:
        raise InputError(
            f"responses: expected them from {needed:g} s to {last:g} s from the event, found {time[0]:g} s "
            f"to {time[-1]:g} s: cut longer epochs"
        )


def _looked_at(time: np.ndarray, x: np.ndarray, options: OnsetOptions) -> np.ndarray:
    """Test signal that the detector averages over events, shape (events, m)."""
    if options.detector == "threshold":
        return np.abs(x)
    if options.detector == "teager-kaiser":
        energy = np.zeros_like(x)
        energy[:, 1:-1] = x[:, 1:-1] ** 2 - x[:, :-2] * x[:, 2:]
        energy[:, [0, -1]] = energy[:, [1, -2]]
        return energy
    at_rest = x[:, time < options.baseline_until_s]
    n, order = at_rest.shape[1], options.whitening_order
    covariance = np.array([np.mean(at_rest[:, : n - j] * at_rest[:, j:]) for j in range(order + 1)])
    if order == 0 or covariance[0] == 0.0:
        return np.abs(x)
    covariance[0] *= 1.0 + 1e-6  # otherwise singular for a rest that can be predicted exactly
    a = scipy.linalg.solve_toeplitz(covariance[:-1], covariance[1:])
    e = np.abs(scipy.signal.lfilter(np.concatenate([[1.0], -a]), 1.0, x, axis=1))
    e[:, :order] = e[:, order : order + 1]  # the samples before them are not recorded
    return e


def _relative_error(time: np.ndarray, looked_at: np.ndarray, options: OnsetOptions) -> float:
    """Standard error of the ensemble's moving mean at rest, relative to the baseline."""
    at_rest = _moving_mean(time, looked_at, STANDING_OUT_S)[:, time < options.baseline_until_s]
    around = at_rest - at_rest.mean(axis=1, keepdims=True)
    mean = at_rest.mean()
    return float(around.std(axis=0, ddof=1).mean() / np.sqrt(len(at_rest)) / mean) if mean > 0.0 else 0.0


def _crossings(time: np.ndarray, y: np.ndarray, options: OnsetOptions) -> tuple[np.ndarray, float]:
    """Instant at which each ensemble mean exceeds its threshold for long enough, NaN if never.

    Also returns the threshold of the first mean, in units of its baseline.
    """
    z = _moving_mean(time, y, options.window_s)
    at_rest = z[:, time < options.baseline_until_s]
    baseline, sd = at_rest.mean(axis=1), at_rest.std(axis=1, ddof=1)
    threshold = (baseline + options.threshold_sd * sd)[:, None]
    above = z > threshold
    hold = max(1, round(options.hold_s * _rate(time)))
    count = np.cumsum(np.pad(above, ((0, 0), (1, 0))), axis=1)
    stays = np.zeros_like(above)
    stays[:, : time.size - hold + 1] = count[:, hold:] - count[:, :-hold] == hold
    stays &= (time >= options.search_s[0]) & (time <= options.search_s[1])
    k = stays.argmax(axis=1)
    rows = np.arange(len(z))
    low, high = z[rows, k - 1], z[rows, k]
    with np.errstate(invalid="ignore", divide="ignore"):
        part = (threshold[:, 0] - low) / (high - low)
    begins = stays.any(axis=1) & ~above[rows, k - 1]  # activity before the searched time has no onset in it
    onsets = np.where(begins, time[k - 1] + part * (time[k] - time[k - 1]), np.nan)
    return onsets, float(threshold[0, 0] / baseline[0]) if baseline[0] else 0.0


def _change_points(time: np.ndarray, y: np.ndarray, error: float, options: OnsetOptions) -> np.ndarray:
    """Most likely start of a ramp in each ensemble mean, NaN without significant activity, shape (draws,)."""
    rate = _rate(time)
    z = _moving_mean(time, y, STANDING_OUT_S)
    # a rest without any noise has no scale of its own
    b = np.maximum(y[:, time < options.baseline_until_s].mean(axis=1), 1e-3 * y.max(axis=1))[:, None]
    b[b == 0.0] = 1.0
    searched = (time >= options.search_s[0]) & (time <= options.search_s[1])
    standing_out = (z > b * (1.0 + options.signal_to_noise * error)) & searched
    active = standing_out.any(axis=1)
    sample = np.arange(time.size)
    first = standing_out.argmax(axis=1)[:, None]
    near = (sample >= first) & (sample <= first + round(PEAK_WITHIN_S * rate))
    peak = np.where(near, z, 0.0).max(axis=1, keepdims=True)
    risen = (z >= b + options.rise_fraction * (peak - b)) & (sample >= first - round(STANDING_OUT_S * rate))
    end = risen.argmax(axis=1)
    # the same lags for all means, counted from the end of each rise
    longest = round(options.longest_rise_s * rate)
    lags = np.arange(-longest - round(BEFORE_RAMP_S * rate), 1)
    Y = np.take_along_axis(y, np.maximum(end[:, None] + lags, 0), axis=1) / b
    onsets = time[end] + _ramp_starts(lags.astype(float), Y, longest) / rate
    inside = (onsets >= options.search_s[0]) & (onsets <= options.search_s[1])
    return np.where(active & inside, onsets, np.nan)


def _ramp_starts(t: np.ndarray, y: np.ndarray, longest: int) -> np.ndarray:
    """Maximum-likelihood T of mu = 1 + c max(0, t - T) in each row of ``y``, T in the last samples."""
    T_tried, logarithms, weights = _tried_ramps(t.size, longest)
    tried = logarithms + y @ weights.T
    height, k = np.unravel_index(tried.argmin(axis=1), (HEIGHTS.size, longest))
    T, c, least = T_tried[k], HEIGHTS[height] / -T_tried[k], tried.min(axis=1)
    size = np.ones_like(T)
    for _ in range(REFINEMENTS):  # Fisher's scoring, halved where it overshoots
        past = np.maximum(t - T[:, None], 0.0)
        mu = 1.0 + c[:, None] * past
        d_c, d_T = past / mu, np.where(past > 0.0, -c[:, None], 0.0) / mu
        r = y / mu - 1.0
        cc, cT, TT = (d_c**2).sum(axis=1), (d_c * d_T).sum(axis=1), (d_T**2).sum(axis=1)
        g_c, g_T = (d_c * r).sum(axis=1), (d_T * r).sum(axis=1)
        det = cc * TT - cT**2
        det = np.where(det > 1e-12 * cc * TT, det, np.inf)
        new_T = np.clip(T + size * np.clip((cc * g_T - cT * g_c) / det, -2.0, 2.0), -longest, -0.25)
        new_c = np.maximum(c + size * (TT * g_c - cT * g_T) / det, 1e-6)
        mu = 1.0 + new_c[:, None] * np.maximum(t - new_T[:, None], 0.0)
        value = (np.log(mu) + y / mu).sum(axis=1)
        better = value < least
        T, c, least = np.where(better, new_T, T), np.where(better, new_c, c), np.where(better, value, least)
        size = np.where(better, np.minimum(1.0, 2.0 * size), 0.5 * size)
    return T


# every ensemble of a search tries the same
@lru_cache(maxsize=8)
def _tried_ramps(samples: int, longest: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """T, shape (longest,), and of all ramps sum of log mu, and 1 / mu, shape (heights * longest, samples)."""
    T = np.arange(-longest, 0, dtype=float)
    ramp = np.maximum(np.arange(1.0 - samples, 1.0) - T[:, None], 0.0)
    mu = 1.0 + HEIGHTS[:, None, None] * ramp / -T[:, None]
    return T, np.log(mu).sum(axis=2).ravel(), (1.0 / mu).reshape(-1, samples)


def _moving_mean(time: np.ndarray, y: np.ndarray, window_s: float) -> np.ndarray:
    """Centred moving mean along the last axis over an odd number of samples."""
    return scipy.ndimage.uniform_filter1d(
        y, 2 * round(0.5 * window_s * _rate(time) - 0.5) + 1, axis=-1, mode="nearest"
    )


def _rate(time: np.ndarray) -> float:
    """Sampling rate (Hz) of regular time (s)."""
    return (time.size - 1) / (time[-1] - time[0])


def _vertex(before: float, at: float, after: float) -> float:
    """Position of the extremum of a parabola through three neighbours, relative to the middle one."""
    bend = before - 2.0 * at + after
    return float(np.clip(0.5 * (before - after) / bend, -0.5, 0.5)) if bend else 0.0
