"""Uncertainty of I, B, K from torque and angle of a manipulator, source by source.

With a torque that is s times the commanded one and an encoder that reads a times the angle, every estimate of
a torque over an angle is 1 / (s a) times the true one, friction 1 / s, hardening 1 / (s a^3), and an angle a
times. A torque that acts later than its record by d turns 1 / H by e^(j w d): the spectral fits mistake it
for damping, the regressions estimate it. I is the inertia of everything that turns with the handle.
"""

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from tepsipe.identification.admittance_fit import (
    AdmittanceFit,
    Bounds,
    change_by_smearing,
    distance_to_other_criterion,
    error_of_misfit,
    fit_as_printed,
    fit_scaled,
)
from tepsipe.identification.regression.periods import PeriodFit
from tepsipe.identification.regression.pooled import PooledFit
from tepsipe.identification.result import Quantity, quantities_of, symbol_of
from tepsipe.signals.response import FrequencyResponse
from tepsipe.statistics.uncertainty import CONFIDENCE, Budget, Source

# sources evaluated from the trial itself: choices that would not matter for a linear joint, and the width of
# the bands over which a response is averaged
CRITERION, BAND, RESOLUTION = "fit_criterion", "fitted_band", "frequency_resolution"
# powers of the torque and of the angle in a quantity
POWERS = {"friction": (1, 0), "K_cubic": (1, -3), "softening_angle": (0, 1), "delay": (0, 0)}
TORQUE_PER_ANGLE = (1, -1)
# sources of Type B
SCALES = ("torque_scale", "angle_scale")
MANIPULATOR_SOURCES = (*SCALES, "torque_delay_s")


def scale_contributions(
    quantities: Mapping[str, float] | Mapping[str, np.floating],
    sources: Mapping[str, Source],
    powers_of: Mapping[str, tuple[int, int]] = POWERS,
) -> dict[str, np.ndarray]:
    """Contributions of the scales of torque and angle.

    quantities: estimates by name (their units).
    sources: torque_scale and angle_scale, as far as they are known.
    powers_of: powers of the torque and of the angle in a quantity; a torque per angle where none are named.
    Returns: for `Budget.contributions`.
    """
    values = np.array(list(quantities.values()))
    powers = np.array([powers_of.get(name, TORQUE_PER_ANGLE) for name in quantities])
    # estimates are too small if the true torque is larger than the commanded one
    signed = {"torque_scale": -values * powers[:, 0], "angle_scale": values * powers[:, 1]}
    return {
        name: slope[None] * sources[name].standard_uncertainty
        for name, slope in signed.items()
        if name in sources
    }


def delay_contributions(
    of_torque: Callable[[np.ndarray], np.ndarray], rate: np.ndarray, sources: Mapping[str, Source]
) -> dict[str, np.ndarray]:
    """Contribution of a torque that acts later than its record, to estimates that are linear in the torque.

    of_torque: from a torque (N·m), shape (n,), to the estimates, shape (p,).
    rate: derivative of the torque (N·m/s).
    sources: torque_delay_s, if it is known.
    Returns: for `Budget.contributions`.
    """
    name = "torque_delay_s"
    return {name: -of_torque(sources[name].standard_uncertainty * rate)[None]} if name in sources else {}


def _of_joint(parameters: np.ndarray) -> dict[str, float]:
    return dict(zip("IBK", parameters, strict=True))


def _freedom(sources: Mapping[str, Source]) -> dict[str, float]:
    return {name: source.freedom for name, source in sources.items()}


def fit_response(
    estimate: FrequencyResponse,
    bounds: Bounds,
    sources: Mapping[str, Source],
    as_printed: bool = False,
    confidence: float = CONFIDENCE,
) -> tuple[AdmittanceFit, dict[str, Quantity]]:
    """Search for I, B, K, and what it finds, with standard errors by thesis eq (3-2) as printed.

    estimate: the n frequencies to fit.
    sources: torque_scale, angle_scale and torque_delay_s, as far as they are known.
    as_printed: the search is `fit_as_printed`. It has no intervals, because the sum of squares tells nothing
    about the scatter of a fit that ends where it began.
    confidence: probability of the intervals.
    """
    fit = (fit_as_printed if as_printed else fit_scaled)(estimate, bounds)
    values = _of_joint(fit.parameters)
    if as_printed:
        quantities = {name: Quantity(float(x), symbol_of(name)) for name, x in values.items()}
    else:
        quantities = quantities_of(values, spectral_budget(fit, estimate, bounds, sources), confidence)
    printed = zip(quantities.items(), fit.sem_as_printed.tolist(), strict=True)
    return fit, {name: replace(q, as_printed=sem) for (name, q), sem in printed}


def spectral_budget(
    fit: AdmittanceFit, estimate: FrequencyResponse, bounds: Bounds, sources: Mapping[str, Source]
) -> Budget:
    """Uncertainty of a spectral fit (N·m·s²/rad, N·m·s/rad, N·m/rad).

    The change by smearing and, for averages over whole periods, the distance to another criterion are half
    widths of rectangular distributions. Residuals are unequal.

    estimate: the n frequencies that were fitted.
    sources: torque_scale, angle_scale and torque_delay_s, as far as they are known.
    """
    contributions = scale_contributions(_of_joint(fit.parameters), sources)
    if "torque_delay_s" in sources:
        u = sources["torque_delay_s"].standard_uncertainty
        turn = np.exp(2j * np.pi * estimate.frequency_hz * u)
        above, below = (
            fit_scaled(replace(estimate, response=response), bounds, fit.parameters).parameters
            for response in (estimate.response * turn, estimate.response / turn)
        )
        # a later torque would be a response that lags less
        contributions["torque_delay_s"] = 0.5 * (below - above)[None]
    if estimate.resolution_hz > 0.0:
        contributions[RESOLUTION] = change_by_smearing(fit, estimate, bounds)[None] / np.sqrt(3.0)
    if estimate.input_power is not None:
        contributions[CRITERION] = distance_to_other_criterion(fit, estimate)[None] / np.sqrt(3.0)
    return Budget(*error_of_misfit(fit, estimate), contributions, _freedom(sources))


def period_budget(fit: PeriodFit, sources: Mapping[str, Source]) -> Budget:
    """Uncertainty of the regression over whole periods (units of ``fit``).

    The change with the lower part of the band counts as the half width of a rectangular distribution, because
    the linear joint nearest to a non-linear one differs between bands. The delay is estimated.

    sources: torque_scale and angle_scale, as far as they are known.
    """
    contributions = scale_contributions(_of_joint(fit.parameters), sources)
    contributions[BAND] = fit.of_band[None] / np.sqrt(3.0)
    return Budget(fit.type_a, fit.freedom, contributions, _freedom(sources))


def pooled_budget(fit: PooledFit, sources: Mapping[str, Source]) -> Budget:
    """Uncertainty of the fit to all trials together (units of ``fit``), of its quantities in their order.

    sources: torque_scale and angle_scale, as far as they are known.
    Returns: budget of every quantity of ``fit.values``.
    """
    type_a = np.array([fit.standard_error[name] for name in fit.values])
    return Budget(type_a, fit.freedom, scale_contributions(fit.values, sources), _freedom(sources))
