"""Checks of a joint likelihood that give warnings, from the residuals of its markers.

Every check has a size in its own unit, a tolerance below which it does not matter, and the probability of so
large a size in a laboratory without the fault. `tepsipe.experiments.dummy.checks` explains them, and adds
those that compare estimators.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
import scipy

from tepsipe.identification.likelihood.likelihood import LikelihoodFit
from tepsipe.identification.likelihood.result import LikelihoodEstimates, innovations
from tepsipe.signals.perturbations import Perturbation
from tepsipe.statistics.uncertainty import FALSE_ALARMS

# check -> what it means, and what to check; the flags of a study have the same texts
MEANINGS = {
    "foot-leg-delay": "the leg moves too early or too late after the foot. Check the sampling instants of "
    "the markers, and whether one on foot or ankle slips",
    "foot-markers-apart": "markers on the foot move against each other. Check their tape, and whether the "
    "foot tilts",
    "camera-scale": "the markers of the leg are further apart or closer than their layout by more than 1 %. "
    "Check the calibration of the cameras, and measure the layout again",
    "markers-slip": "a marker stays displaced after perturbations. Check the tape of all markers",
    "markers-pulse-locked": "markers leave the rigid leg in every perturbation. Look for bending or soft "
    "mounts",
    "lack-of-fit": "the model of the joint leaves a repeated motion or a large part of the signal "
    "unexplained. Inspect the residuals for wobble, hysteresis and wrong time stamps",
}
# tolerances: of K, of a delay (s), of markers (m), of the angle's residual, of I over the leg's, of a scale
TOLERATED = {
    "leg-disagrees": 0.005,
    "foot-leg-delay": 2e-5,
    "joint-inertia": 0.0,
    "foot-markers-apart": 3e-5,
    "markers-slip": 3e-5,
    "markers-pulse-locked": 2e-5,
    "lack-of-fit": 0.003,
    "camera-scale": 0.01,
}
# standard deviation of the scale of markers that are placed within a millimetre
_LAYOUT_SD = 0.002
# time after a perturbation over which its response is averaged, and in which markers may settle (s)
_LOCKED_S, _SETTLED_S = 0.5, 0.2
# share of the samples that stay independent after interpolation to common instants
_INDEPENDENT = 0.6
# sum of squares of markers without noise (m²)
_EXACT = 1e-24


@dataclass(frozen=True)
class Check:
    """One check of one trial."""

    name: str
    """One of `TOLERATED`; also the flag of an estimate."""
    size: float
    """Departure of the trial from its expectation (unit of the check)."""
    probability: float
    """Probability of a size this large without a fault."""
    tolerated: float | None = None
    """A tolerance larger than in `TOLERATED` (unit of the check), if the trial has one."""

    @property
    def tolerance(self) -> float:
        """Size that does not matter (unit of the check)."""
        return max(TOLERATED[self.name], self.tolerated or 0.0)


def failed(checks: Sequence[Check]) -> list[str]:
    """Names of the checks that fail, by Bonferroni's bound over all of them.

    A delay that is fitted by a model that does not fit is no delay: hysteresis would be taken for one.
    """
    bound = FALSE_ALARMS / max(1, len(checks))
    names = [c.name for c in checks if c.size > c.tolerance and c.probability < bound]
    return [name for name in names if name != "foot-leg-delay" or "lack-of-fit" not in names]


def delay_check(fit: LikelihoodEstimates, uncertainty_s: float) -> Check:
    """Delay of the angle after the foot.

    uncertainty_s: standard uncertainty of the correction between foot and leg.
    Returns: its size is the delay.
    """
    error = float(np.hypot(fit.fit.standard_error("delay"), uncertainty_s))
    return Check("foot-leg-delay", abs(fit.delay_s), two_sided(fit.delay_s / error))


def scale_check(layout_scale: float) -> Check:
    """Size of the leg's markers as measured, over the size of their stated layout.

    Lengths that are s times too large change K - k_g and J by s (`tepsipe.identification.budgets.leg`).
    Returns: its size is the difference from 1.
    """
    return Check("camera-scale", abs(layout_scale - 1.0), two_sided((layout_scale - 1.0) / _LAYOUT_SD))


def fit_check(fit: LikelihoodFit, perturbations: list[Perturbation]) -> Check:
    """Power and pulse-locked mean of the likelihood's residuals.

    Returns: its size is the root mean square residual relative to the angle's root mean square.
    """
    white, n = innovations(fit), fit.channels.angle.size
    band = 2.0 * fit.model.bins.size / n
    total = float(np.mean(white[0] ** 2))
    power = scipy.stats.f.sf(total, band * n, fit.channels.marker_freedom)
    length = min(np.diff([p.start for p in perturbations]), default=n - perturbations[0].start)
    folded = _folded(white.T, perturbations, int(min(length, n - perturbations[-1].start)))
    mean, count = folded.mean(axis=0), len(folded)
    freedom = band * mean.size
    locked = scipy.stats.chi2.sf(count * float(np.sum(mean**2)) * band, freedom)
    excess = max(float(np.mean(mean[:, 0] ** 2)) - 1.0 / count, total - 1.0, 0.0)
    unit = fit.channels.marker_noise_m * np.sqrt(fit.channels.geometry[1, 1] * band)
    swing = float(np.sqrt(np.mean(fit.model.motion.phi[perturbations[0].start :] ** 2)))
    return Check("lack-of-fit", float(np.sqrt(excess)) * unit / swing, min(1.0, 2.0 * min(power, locked)))


def foot_check(
    positions: Annotated[np.ndarray, "(n, k, 2)"], perturbations: list[Perturbation], rate_hz: float
) -> Check | None:
    """Markers on the foot alone against each other.

    positions: theirs (m), not filtered.
    Returns: its size is the step or motion of a marker against the others; None with fewer than two.
    """
    k = positions.shape[1]
    if k < 2:
        return None
    deviations = positions - positions.mean(axis=1, keepdims=True)
    deviations = deviations.reshape(len(deviations), -1)
    rank, kept = 2.0 * (k - 1), 1.0 - 1.0 / k
    step, chance = _steps(deviations, perturbations, rate_hz, rank / (2.0 * k))
    motion, locked = _locked(deviations, perturbations, rate_hz, rank / (2.0 * k))
    return Check("foot-markers-apart", max(step, motion) / kept, min(1.0, 2.0 * min(chance, locked)))


def residual_checks(fit: LikelihoodFit, perturbations: list[Perturbation]) -> list[Check]:
    """Steps, and pulse-locked motion, of the markers against the rigid leg on the foot.

    Returns: ``markers-slip`` and ``markers-pulse-locked``, with sizes in m.
    """
    channels = fit.channels
    residuals, rate_hz = channels.residuals, channels.rate_hz
    independent = (residuals.shape[1] - 2.0) / residuals.shape[1]
    return [
        Check("markers-slip", *_steps(residuals, perturbations, rate_hz, independent)),
        Check("markers-pulse-locked", *_locked(residuals, perturbations, rate_hz, independent)),
    ]


def two_sided(z: float) -> float:
    """Probability of a normal deviate beyond z on either side."""
    return 2.0 * float(scipy.stats.norm.sf(abs(z)))


def _folded(signal: np.ndarray, perturbations: list[Perturbation], length: int) -> np.ndarray:
    """Signal (n, c) after each onset, shape (perturbations, length, c)."""
    starts = [p.start for p in perturbations if p.start + length <= len(signal)]
    return np.array([signal[start : start + length] for start in starts])


def _steps(
    residuals: np.ndarray, perturbations: list[Perturbation], rate_hz: float, independent: float
) -> tuple[float, float]:
    """Largest root mean square step (m) of a column between perturbations, and its probability."""
    settled, ends = round(_SETTLED_S * rate_hz), [p.start for p in perturbations[1:]]
    parts = [slice(0, perturbations[0].start)]
    parts += [slice(p.stop + settled, end) for p, end in zip(perturbations, [*ends, None], strict=True)]
    blocks = [residuals[part] for part in parts if len(residuals[part]) > settled]
    if len(blocks) < 2:
        return 0.0, 1.0
    means, sizes = np.array([b.mean(axis=0) for b in blocks]), np.array([len(b) for b in blocks])
    within = max(sum(((b - m) ** 2).sum() for b, m in zip(blocks, means, strict=True)), _EXACT)
    variance = within / (independent * residuals.shape[1] * (sizes.sum() - sizes.size))
    centre = np.average(means, axis=0, weights=sizes)
    between = float(np.sum(sizes[:, None] * (means - centre) ** 2) / variance)
    freedom = independent * residuals.shape[1] * (len(blocks) - 1)
    steps = np.mean(np.diff(means, axis=0) ** 2, axis=0) - 2.0 * variance * np.mean(1.0 / sizes)
    return float(np.sqrt(max(steps.max(), 0.0))), float(scipy.stats.chi2.sf(between, freedom))


def _locked(
    residuals: np.ndarray, perturbations: list[Perturbation], rate_hz: float, independent: float
) -> tuple[float, float]:
    """Root mean square (m) of a column's mean over the perturbations, and its probability."""
    lengths = np.diff([p.start for p in perturbations])
    length = int(min([round(_LOCKED_S * rate_hz), *lengths]))
    folded = _folded(residuals, perturbations, length)
    folded = folded - folded.mean(axis=1, keepdims=True)
    count = len(folded)
    if count < 3:
        return 0.0, 1.0
    mean = folded.mean(axis=0)
    within = max(float(np.sum((folded - mean) ** 2)), _EXACT) / (count - 1)
    freedom = _INDEPENDENT * independent * residuals.shape[1] * (length - 1)
    ratio = count * float(np.sum(mean**2)) / within
    noise = within / mean.size / count
    size = float(np.sqrt(max(np.mean(mean**2, axis=0).max() - noise, 0.0)))
    return size, float(scipy.stats.f.sf(ratio, freedom, (count - 1) * freedom))


def of_likelihood(
    fit: LikelihoodEstimates,
    foot: Annotated[np.ndarray, "(n, k, 2)"],
    perturbations: list[Perturbation],
    rate_hz: float,
    layout_scale: float,
    delay_uncertainty_s: float = 0.0,
) -> list[Check]:
    """All checks of one fit.

    foot: positions of the markers on the foot alone (m), not filtered.
    layout_scale: as for `scale_check`.
    delay_uncertainty_s: standard uncertainty of the correction between foot and leg.
    """
    checks = [delay_check(fit, delay_uncertainty_s), *residual_checks(fit.fit, perturbations)]
    checks += [fit_check(fit.fit, perturbations), foot_check(foot, perturbations, rate_hz)]
    checks.append(scale_check(layout_scale))
    return [check for check in checks if check is not None]
