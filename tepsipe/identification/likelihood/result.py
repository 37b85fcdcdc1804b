"""Estimates by the likelihood: I, B, K at the working amplitude and for small movements, residuals.

Estimates describe the linear joint nearest to the fitted law, as a mean over the windows of the perturbations
(`likelihood`). Intervals are Wald's. Contributions of the intervals from onset
to onset, whose mean is the estimate, are for figures: with the residuals r(t) and columns u(t) of the
likelihood in the time domain, n F^-1 sum of u r over the interval.

Residuals of a correct model are white, with unit variance, in the band of the fit. At each frequency two
directions remain when the foot's motion is estimated from three channels: the angle, and the foot's markers
against the log. Both are given in the time domain (`innovations`).
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
import scipy

from tepsipe.identification.likelihood.channels import Channels
from tepsipe.identification.likelihood.likelihood import (
    SOFTENING,
    LikelihoodFit,
    softening_forces,
    softening_slopes,
    step_to,
)
from tepsipe.identification.regression.output_error import intervals_as_windows, sums_by_interval
from tepsipe.identification.regression.windows import WindowedFits
from tepsipe.mechanics.impedance_model import PARAMETERS
from tepsipe.mechanics.segment_kinematics import SegmentMotion
from tepsipe.signals.perturbations import Perturbation
from tepsipe.statistics.bootstrap import Interval
from tepsipe.statistics.goodness_of_fit import explained

# parameters of the law that make up I, B, K
_LAW = ("J", "B", "K", *SOFTENING)


@dataclass(frozen=True)
class LikelihoodEstimates(WindowedFits):
    """I, B, K by the likelihood at the amplitude of the perturbations.

    Torque (N·m) and VAF (%) follow pathway ``leg``, for comparison only.
    """

    angle: Annotated[np.ndarray, "(n,)", "rad"]
    simulated: Annotated[np.ndarray, "(n,)", "rad"]
    """Measured and estimated theta."""
    theta_0_rad: float
    """Angle at rest."""
    fit: LikelihoodFit
    """The likelihood's maximum, with delay, lag and noise levels."""
    covariance: Annotated[np.ndarray, "(3, 3)"]
    """Covariance of I, B, K (units of the parameters)."""
    small: Annotated[np.ndarray, "(3,)"]
    """I, B, K of small movements (N·m·s²/rad, N·m·s/rad, N·m/rad)."""
    small_covariance: Annotated[np.ndarray, "(3, 3)"]

    @property
    def type_a(self) -> tuple[np.ndarray, float]:
        """Type A uncertainty of I, B, K, shape (3,), from the covariance, and its degrees of freedom."""
        return np.sqrt(np.diag(self.covariance)), np.inf

    @property
    def vaf_angle(self) -> float:
        """VAF (%) of theta - theta_0 over the whole trial."""
        return explained(self.angle - self.theta_0_rad, self.simulated - self.theta_0_rad)

    @property
    def delay_s(self) -> float:
        """Delay of the angle after the foot (s)."""
        return self.fit.value("delay")

    @property
    def softening(self) -> tuple[float, float, float] | None:
        """C (N·m/rad), B_s (N·m·s/rad) and phi_h (rad) of a joint that softens; None of a linear one."""
        if not self.fit.softens:
            return None
        return self.fit.value("C"), self.fit.value("B_s"), float(np.exp(self.fit.value("log_phi_h")))

    def interval(self, confidence: float = 0.95) -> Interval:
        """Standard errors and Wald interval of I, B, K, shape (3,) (units of the parameters)."""
        return _wald(self.mean, self.covariance, confidence)

    def small_interval(self, confidence: float = 0.95) -> Interval:
        """The same of ``small`` (N·m·s²/rad, N·m·s/rad, N·m/rad)."""
        return _wald(self.small, self.small_covariance, confidence)


def _wald(values: np.ndarray, covariance: np.ndarray, confidence: float) -> Interval:
    error = np.sqrt(np.diag(covariance))
    half = scipy.stats.norm.ppf(0.5 + 0.5 * confidence) * error
    return Interval(error, values - half, values + half)


def estimates_in_windows(
    fit: LikelihoodFit, motion: SegmentMotion, perturbations: list[Perturbation], at_rest: np.ndarray
) -> LikelihoodEstimates:
    """I, B, K of a fit, over the windows of the perturbations.

    fit: from `maximise_likelihood`.
    motion: filtered motion of the leg, for the torque of ``leg``.
    at_rest: samples at rest.
    """
    names, places = _law_places(fit)
    covariance = fit.covariance[np.ix_(places, places)]
    change = _working_amplitude(fit, names, perturbations)
    small = np.array([fit.value("J") - fit.model.leg_inertia, fit.value("B"), fit.value("K")])
    linear = np.array([*small, *([fit.value("C"), fit.value("B_s")] if fit.softens else [])])
    working = change[:, : linear.size] @ linear
    each = _contributions(fit, change, places, perturbations)
    of_leg = intervals_as_windows(
        working + each - each.mean(axis=0),
        float(np.linalg.cond(covariance / np.sqrt(np.outer(*[np.diag(covariance)] * 2)))),
        motion,
        fit.model.leg,
        perturbations,
        at_rest,
    )
    return LikelihoodEstimates(
        **vars(of_leg),
        angle=fit.channels.angle + fit.channels.theta_0_rad,
        simulated=estimated_angle(fit) + fit.channels.theta_0_rad,
        theta_0_rad=fit.channels.theta_0_rad,
        fit=fit,
        covariance=change @ covariance @ change.T,
        small=small,
        small_covariance=covariance[:3, :3],
    )


def first_order_changes(
    estimates: LikelihoodEstimates, channels: Channels, perturbations: list[Perturbation]
) -> tuple[np.ndarray, np.ndarray]:
    """Change of the estimates by slightly other channels, to first order.

    channels: the same trial with other markers.
    Returns: changes of I, B, K at the working amplitude and of small movements (N·m·s²/rad, N·m·s/rad,
    N·m/rad).
    """
    names, places = _law_places(estimates.fit)
    law = step_to(estimates.fit, channels)[places]
    return _working_amplitude(estimates.fit, names, perturbations) @ law, law[:3]


def _law_places(fit: LikelihoodFit) -> tuple[list[str], list[int]]:
    """Names and positions of the fitted parameters that make up I, B, K."""
    names = [name for name in _LAW if name in fit.point.names]
    return names, [fit.point.names.index(name) for name in names]


def working_covariance(
    fit: LikelihoodFit, perturbations: list[Perturbation], of_parameters: Annotated[np.ndarray, "(p, p)"]
) -> Annotated[np.ndarray, "(3, 3)"]:
    """Covariance of I, B, K over the windows of the perturbations.

    of_parameters: covariance of the fitted parameters.
    Returns: units of I, B, K.
    """
    names, places = _law_places(fit)
    change = _working_amplitude(fit, names, perturbations)
    return change @ of_parameters[np.ix_(places, places)] @ change.T


def _law_forces(fit: LikelihoodFit) -> dict[str, np.ndarray]:
    """Torque of the law per unit of C and B_s, and its derivatives by log(phi_h) and b_0, shape (n,)."""
    motion = fit.model.motion
    rest, half = fit.value("b_0"), float(np.exp(fit.value("log_phi_h")))
    forces, by = (f(motion.phi, motion.phi_d, rest, half) for f in (softening_forces, softening_slopes))
    slopes = {
        name: -fit.value("C") * by[f"C_{key}"] - fit.value("B_s") * by[f"B_s_{key}"]
        for name, key in (("log_phi_h", "half"), ("b_0", "rest"))
    }
    return {"C": -forces["C"], "B_s": -forces["B_s"], **slopes}


def _working_amplitude(fit: LikelihoodFit, names: list[str], perturbations: list[Perturbation]) -> np.ndarray:
    """Derivatives of I, B, K over the windows with respect to the law's parameters, shape (3, p)."""
    change = np.zeros((len(PARAMETERS), len(names)))
    change[:, :3] = np.eye(3)
    if not fit.softens:
        return change
    forces, motion = _law_forces(fit), fit.model.motion
    regressors = np.column_stack([motion.phi_dd, motion.phi_d, motion.phi])
    aims = np.column_stack([forces[name] for name in names[3:]])
    slopes = []
    for p in perturbations:
        # trapezoids: the fit is that over a stretch of time, whatever the sampling rate
        weight = np.ones((p.stop - p.start, 1))
        weight[[0, -1]] = np.sqrt(0.5)
        window = slice(p.start, p.stop)
        slope = np.linalg.lstsq(weight * regressors[window], weight * aims[window], rcond=None)
        slopes.append(slope[0])
    change[:, 3:] = np.mean(slopes, axis=0)
    return change


def estimated_angle(fit: LikelihoodFit) -> np.ndarray:
    """Estimated theta - theta_0 (rad), shape (n,), with the measured frequencies outside the band."""
    spectra = fit.model.spectra(fit.point)
    return _in_band(
        fit, fit.channels.angle, spectra.response[1] * fit.residuals.foot + spectra.independent[1]
    )


def estimated_foot(fit: LikelihoodFit) -> np.ndarray:
    """Estimated position of the foot (m), shape (n,), with the measured frequencies outside the band.

    The ramp of its net displacement is excluded.
    """
    return _in_band(fit, fit.channels.foot, fit.residuals.foot)


def _in_band(fit: LikelihoodFit, signal: np.ndarray, spectrum: np.ndarray) -> np.ndarray:
    """A signal (n,) with another spectrum in the band (m,) (units of both)."""
    whole = scipy.fft.rfft(signal)
    whole[fit.model.bins] = spectrum
    return scipy.fft.irfft(whole, signal.size)


def _contributions(
    fit: LikelihoodFit, change: np.ndarray, places: list[int], perturbations: list[Perturbation]
) -> np.ndarray:
    """Contributions of the intervals to I, B, K, shape (intervals, 3); their mean is about 0."""
    information = fit.residuals.information - fit.residuals.excess
    mixed = change @ np.linalg.pinv(information)[places]
    columns = np.einsum("qp,pcm->qcm", mixed, fit.residuals.columns)
    n = fit.channels.angle.size
    whole = np.zeros((len(mixed) + 1, columns.shape[1], n // 2 + 1), dtype=complex)
    whole[:-1, :, fit.model.bins] = columns
    whole[-1][:, fit.model.bins] = fit.residuals.whitened
    signals = scipy.fft.irfft(whole, n)
    products = n * np.einsum("qcn,cn->nq", signals[:-1], signals[-1])
    return len(perturbations) * sums_by_interval(products, perturbations)


def innovations(fit: LikelihoodFit) -> Annotated[np.ndarray, "(1, n)"]:
    """White residuals in the time domain, with unit variance if the model holds.

    fit: from `maximise_likelihood`.
    Returns: innovations of the angle, and of the foot's markers against the log where there is one.
    """
    along, residual = fit.residuals.direction, fit.residuals.whitened
    channels, bins = len(residual), fit.model.bins
    first = -along * along[1].conj()
    first[1] += 1.0
    first = first / np.sqrt(np.sum(np.abs(first) ** 2, axis=0))
    directions = [first]
    if channels == 3:
        directions.append(np.cross(along, first, axis=0).conj())
    n = fit.channels.angle.size
    whole = np.zeros((len(directions), n // 2 + 1), dtype=complex)
    for k, direction in enumerate(directions):
        whole[k, bins] = np.sum(direction.conj() * residual, axis=0)
    return scipy.fft.irfft(whole, n) * n / np.sqrt(2.0 * bins.size)
