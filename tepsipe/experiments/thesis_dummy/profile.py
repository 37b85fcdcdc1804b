"""Profile of the misfit of the printed I, B and K over the lag of the ankle.

With the scatter s_i of n printed numbers p_i as their standard deviations, minus twice the log-likelihood of
a fitted law is, but for a constant,

    chi^2(lag) = sum_i ((value_i - p_i) / s_i)^2 = n rms(lag)^2

Lags at which chi^2 is at most 3.84 above its minimum are the 95 % interval of one parameter (Wilks 1938).
"""

import numpy as np
import scipy

LIMIT_95 = 3.84  # of chi^2 with one degree of freedom


def misfit_over_least(timing: dict) -> np.ndarray:
    """chi^2 above its minimum for every lag; ``timing`` has the facts of `timing_facts`."""
    misfit = timing["numbers"] * np.array([row["rms"] for row in timing["lags"]]) ** 2
    return misfit - misfit.min()


def profile(timing: dict) -> dict:
    """Best lag, and the intervals of lag and fitted B that the printed numbers allow.

    timing: facts of `timing_facts`.
    Returns: ``best`` and ``unlagged``, the rows with the smallest chi^2 and with the lag nearest to 0, with
    ``over_least``, chi^2 above its minimum; ``lags_s`` and ``dampings_Nms_per_rad``, ends of the 95 %
    intervals, interpolated linearly between lags (None at an end of the range); ``limit``, `LIMIT_95`.
    """
    rows, over = timing["lags"], misfit_over_least(timing)
    lags, dampings = (np.array([row[key] for row in rows]) for key in ("lag_s", "damping_Nms_per_rad"))
    best, zero = int(np.argmin(over)), int(np.argmin(np.abs(lags)))
    ends = [_crossing(lags, dampings, over, best, step) for step in (-1, 1)]
    return {
        "best": rows[best] | {"over_least": float(over[best])},
        "unlagged": rows[zero] | {"over_least": float(over[zero])},
        "lags_s": [None if end is None else end[0] for end in ends],
        "dampings_Nms_per_rad": [None if end is None else end[1] for end in ends],
        "limit": LIMIT_95,
    }


def last_match(timing: dict, percent: float) -> dict | None:
    """Largest lag at which the Wristalyzer's parameters follow the angle with a VAF (%), between fitted lags.

    Monotone cubic interpolation (Fritsch and Carlson 1980).
    Returns: ``lag_s``; there ``unexplained_ratio``, the unexplained part of a perturbation over the printed
    one, and ``over_least``, chi^2 above its minimum. None if the VAF does not fall below it in the range.
    """
    rows = timing["lags"]
    lags, vaf, unexplained = (
        np.array([row[key] for row in rows]) for key in ("lag_s", "vaf_wristalyzer", "unexplained_percent")
    )
    matched = np.flatnonzero(vaf >= percent)
    if not matched.size or matched[-1] == lags.size - 1:
        return None
    vaf_at, unexplained_at, over_at = (
        scipy.interpolate.PchipInterpolator(lags, y) for y in (vaf, unexplained, misfit_over_least(timing))
    )
    k = matched[-1]
    lag = scipy.optimize.brentq(lambda t: vaf_at(t) - percent, lags[k], lags[k + 1])
    return {
        "lag_s": lag,
        "unexplained_ratio": float(unexplained_at(lag)) / timing["printed"]["unexplained_percent"],
        "over_least": float(over_at(lag)),
    }


def _crossing(
    lags: np.ndarray, dampings: np.ndarray, over: np.ndarray, best: int, step: int
) -> tuple[float, float] | None:
    """Lag (s) and B (N·m·s/rad) where chi^2 first exceeds its limit, on one side of the best lag."""
    k = best
    while 0 <= k + step < over.size:
        if over[k + step] > LIMIT_95:
            part = (LIMIT_95 - over[k]) / (over[k + step] - over[k])
            return tuple(float(x[k] + part * (x[k + step] - x[k])) for x in (lags, dampings))
        k += step
    return None
