"""Sampling times of the markers and the printed damping.

In a short pulse the leg turns about its centre of percussion, at the height l above the ankle, which stays
where it is:

    l = (I_l + m r^2 + I) / (m r),      y_f' = -l theta'

Marker k at height h_k is sampled s_k after its frame, and is found s_k (h_k - l) theta' from its place. The
rigid pose nearest to n markers moves the point at height l by E theta',

    E = sum_k s_k (h_k - l) [1/n + (l - h) (h_k - h) / sum (h_k - h)^2],      h = mean of h_k

The torque of eq (3-8) contains m r times the acceleration of this point. With the third derivative of theta
close to -w^2 theta', B shifts by

    m r w^2 E

If the recorded translation of the ankle lags the recorded rotation by a time t, it is y_f(t' - t) at the
instant t', E changes by +l t, and B rises by m r w^2 l t.
"""

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Annotated

import numpy as np

from tepsipe.experiments.thesis_dummy.inverse import (
    LINEAR,
    SCATTER,
    BeltMotion,
    LawFit,
    PrintedPath,
    deviations,
    printed_fits,
    printed_quantities,
    swings,
)
from tepsipe.mechanics.impedance_model import PARAMETERS
from tepsipe.mechanics.inverse_dynamics import Leg
from tepsipe.mechanics.rubber_joint import RubberJoint
from tepsipe.statistics.goodness_of_fit import explained

# lags of the ankle's recorded translation behind the rotation (s)
LAGS_S = tuple(float(x) for x in np.arange(-4, 6) * 5e-5)
STEPS = 4  # Gauss-Newton steps from the constants without lag


def linear_joint(inertia: float, damping: float, stiffness: float) -> RubberJoint:
    """Joint of constant I (N·m·s²/rad), B (N·m·s/rad) and K (N·m/rad)."""
    return RubberJoint(
        stiffness_Nm_per_rad=stiffness, damping_Nms_per_rad=damping, inertia_Nms2_per_rad=inertia, **LINEAR
    )


def percussion_height(leg: Leg, inertia: float) -> float:
    """Height l (m) above the ankle of the centre of percussion of a leg with a joint of I (N·m·s²/rad)."""
    p = leg.mass_kg * leg.com_m
    return (leg.inertia_kgm2 + p * leg.com_m + inertia) / p


def pose_error(
    heights: Annotated[np.ndarray, "(markers,)", "m"],
    sampled_after_s: Annotated[np.ndarray, "(markers,)"],
    height: Annotated[float, "m"],
) -> float:
    """Displacement E of the point at a height (m) per angular velocity of the leg (m·s/rad).

    heights: h_k, above the ankle.
    sampled_after_s: s_k, after the frame.
    """
    from_mean = heights - heights.mean()
    weights = 1.0 / heights.size + (height - heights.mean()) * from_mean / np.sum(from_mean**2)
    return float(np.sum(sampled_after_s * (heights - height) * weights))


def damping_shift(path: PrintedPath, inertia: Annotated[float, "N·m·s²/rad"], squared_rate: float) -> float:
    """Shift of the printed B by the sampling times of the markers (N·m·s/rad).

    inertia: I of the joint.
    squared_rate: w^2 (1/s²), as `WindowedFits.squared_rate`.
    """
    leg = path.leg
    error = pose_error(path.markers.layout_m[:, 1], path.sampled_after_s, percussion_height(leg, inertia))
    return leg.mass_kg * leg.com_m * squared_rate * error


@dataclass(frozen=True)
class LagFit:
    """The law of the joint, fitted with another lag of the ankle."""

    lag_s: float
    """Lag of the ankle's recorded translation behind the rotation."""
    damping_Nms_per_rad: float
    """Fitted B for small bending."""
    rms: Annotated[float, "N·m·s/rad"]
    rms_damping: Annotated[float, "N·m·s/rad"]
    """Root mean square of (value - printed) / scatter over I, B and K, and of B - printed B."""
    unexplained_percent: float
    standard_error_damping: float
    """100 - VAF of a perturbation (%), and standard error of B of a perturbation (N·m·s/rad), without
    noise; means over the conditions."""
    vaf_wristalyzer: float
    vaf_without_handle: float
    """VAF (%) of the angle of this joint by the linear joint of the Wristalyzer, with the inertia of foot
    and handle and without; median over the conditions."""


def timing_facts(
    path: PrintedPath,
    belts: dict[str, BeltMotion],
    printed: dict[str, dict[str, float]],
    fit: LawFit,
    followed: tuple[RubberJoint, RubberJoint],
) -> dict:
    """Shift of the printed B by the sampling times, in closed form and simulated, and fits by lag.

    Takes the arguments of `lag_fits`. ``pulse_rate_per_s`` is w, ``shift_per_ankle_lag_Nms_per_rad_per_s``
    the rise of B per lag of the ankle; the simulated shift is the difference of B as printed from B with
    all markers sampled at once, mean over the conditions; ``numbers`` counts the printed I, B and K.
    """
    inertia = fit.joint.inertia_Nms2_per_rad
    swung = swings(path, [fit.joint], belts)
    angles = {name: swung[name](belt.time)[:, 0] for name, belt in belts.items()}
    at_once = replace(path, sampled_after_s=np.zeros_like(path.sampled_after_s))
    pairs = [
        [printed_fits(own, belt, angles[name]) for own in (path, at_once)] for name, belt in belts.items()
    ]
    b = PARAMETERS.index("B")
    squared_rate = float(np.mean([exact.squared_rate for _, exact in pairs]))
    p = path.leg.mass_kg * path.leg.com_m
    height = percussion_height(path.leg, inertia)
    return {
        "percussion_height_m": height,
        "pulse_rate_per_s": float(np.sqrt(squared_rate)),
        "shift_Nms_per_rad": damping_shift(path, inertia, squared_rate),
        "simulated_shift_Nms_per_rad": float(np.mean([one.mean[b] - two.mean[b] for one, two in pairs])),
        "shift_per_ankle_lag_Nms_per_rad_per_s": p * squared_rate * height,
        "printed": {
            "unexplained_percent": 100.0 - _mean_printed(printed, "VAF_perturbation"),
            "standard_error_damping": _mean_printed(printed, "SEM_B"),
        },
        "numbers": len(PARAMETERS) * len(belts),
        "lags": [asdict(row) for row in lag_fits(path, belts, printed, fit, followed)],
    }


def _mean_printed(printed: dict[str, dict[str, float]], quantity: str) -> float:
    return float(np.mean([*printed.get(quantity, {}).values()] or [np.nan]))


def lag_fits(
    path: PrintedPath,
    belts: dict[str, BeltMotion],
    printed: dict[str, dict[str, float]],
    fit: LawFit,
    followed: tuple[RubberJoint, RubberJoint],
    lags_s: tuple[float, ...] = LAGS_S,
) -> list[LagFit]:
    """Fit the law for several lags, by Gauss-Newton steps from the fit without lag.

    Where a step would make B negative, B is 0 and only the other constants are fitted.

    path, belts, printed: as `fit_joint`; all conditions are used.
    fit: the law fitted without lag.
    followed: joint of the Wristalyzer (thesis section 4-1-3), and the same without the inertia of foot and
    handle, which do not turn on the treadmill.
    lags_s: lags of the ankle.
    Returns: in the order of the lags.
    """
    names, step = list(belts), 1e-3
    fitted = np.array([getattr(fit.joint, name) for name in fit.free])

    def joint_at(x: np.ndarray) -> RubberJoint:
        return RubberJoint(**vars(fit.joint) | dict(zip(fit.free, map(float, x * fitted), strict=True)))

    def residuals(points: np.ndarray, lags: Sequence[float]) -> tuple[np.ndarray, dict]:
        swung = swings(path, [joint_at(x) for x in points], belts)
        return deviations(path, belts, swung, printed, names, lags), swung

    start = np.ones(fitted.size)
    nearby = np.vstack([start, start + step * np.eye(start.size)])
    moved, _ = residuals(nearby, [0.0])
    slopes = (moved[1:] - moved[0]).T / step
    solve, damping_at = np.linalg.pinv(slopes), fit.free.index("damping_Nms_per_rad")
    others = np.array(fit.free) != "damping_Nms_per_rad"
    points = np.tile(start, (len(lags_s), 1))
    found, _ = residuals(points, lags_s)
    best, least = points, found
    for _ in range(STEPS):
        tried = points - found @ solve.T
        for k in np.flatnonzero(tried[:, damping_at] < 0.0):
            without = found[k] - slopes[:, damping_at] * points[k, damping_at]
            tried[k, damping_at] = 0.0
            tried[k, others] = points[k, others] - np.linalg.pinv(slopes[:, others]) @ without
        points = tried
        found, _ = residuals(points, lags_s)
        better = (np.sum(found**2, axis=1) < np.sum(least**2, axis=1))[:, None]
        best, least = np.where(better, points, best), np.where(better, found, least)
    points, (found, swung) = best, residuals(best, lags_s)
    followed_by = swings(path, list(followed), belts)
    angles, simulated = (
        {name: angle(belts[name].time).T for name, angle in both.items()} for both in (swung, followed_by)
    )
    b = PARAMETERS.index("B")
    rows = []
    for k, lag in enumerate(lags_s):
        scores = [[explained(angles[n][k], simulated[n][j]) for n in names] for j in (0, 1)]
        damping = SCATTER["B"] * found[k].reshape(-1, len(PARAMETERS))[:, b]
        own = [printed_quantities(printed_fits(path, belts[n], angles[n][k], lag_s=lag)) for n in names]
        rows.append(
            LagFit(
                lag_s=lag,
                damping_Nms_per_rad=joint_at(points[k]).damping_Nms_per_rad,
                rms=float(np.sqrt(np.mean(found[k] ** 2))),
                rms_damping=float(np.sqrt(np.mean(damping**2))),
                unexplained_percent=100.0 - float(np.mean([row["VAF_perturbation"] for row in own])),
                standard_error_damping=float(np.mean([row["SEM_B"] for row in own])),
                vaf_wristalyzer=float(np.median(scores[0])),
                vaf_without_handle=float(np.median(scores[1])),
            )
        )
    return rows
