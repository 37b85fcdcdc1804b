"""Uncertainty of I, B, K of the torque-controlled manipulator, source by source.

With a torque that is s times the commanded one and an encoder that reads a times the angle, every estimate of
a torque over an angle is 1 / (s a) times the true one, friction 1 / s, hardening 1 / (s a^3), and an angle a
times. A torque that acts later than its record by d turns 1 / H by e^(j w d): the spectral fits mistake it
for damping, the regressions estimate it. I is the inertia of everything that turns with the handle.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from tepsipe.identification.admittance_fit import (
    AdmittanceFit,
    Bounds,
    distance_to_other_criterion,
    error_of_misfit,
    fit_scaled,
)
from tepsipe.identification.regression.periods import PeriodFit
from tepsipe.identification.regression.pooled import PooledFit
from tepsipe.signals.response import FrequencyResponse
from tepsipe.statistics.uncertainty import Budget, Source

# sources evaluated from the trial itself: choices that would not matter for a linear joint
CRITERION, BAND = "fit_criterion", "fitted_band"
# powers of the torque and of the angle in a quantity
POWERS = {"friction": (1, 0), "K_cubic": (1, -3), "softening_angle": (0, 1), "delay": (0, 0)}
TORQUE_PER_ANGLE = (1, -1)


def _scales(
    quantities: Mapping[str, float] | Mapping[str, np.floating], sources: Mapping[str, Source]
) -> dict[str, np.ndarray]:
    """Contributions of the scales of torque and angle, shape (1, p) each (units of the quantities)."""
    values = np.array(list(quantities.values()))
    powers = np.array([POWERS.get(name, TORQUE_PER_ANGLE) for name in quantities])
    # estimates are too small if the true torque is larger than the commanded one
    signed = {"torque_scale": -values * powers[:, 0], "angle_scale": values * powers[:, 1]}
    return {
        name: slope[None] * sources[name].standard_uncertainty
        for name, slope in signed.items()
        if name in sources
    }


def _of_joint(parameters: np.ndarray) -> dict[str, float]:
    return dict(zip("IBK", parameters, strict=True))


def _freedom(sources: Mapping[str, Source]) -> dict[str, float]:
    return {name: source.freedom for name, source in sources.items()}


def spectral_budget(
    fit: AdmittanceFit,
    estimate: FrequencyResponse,
    bounds: Bounds,
    sources: Mapping[str, Source],
    power: np.ndarray | None = None,
) -> Budget:
    """Uncertainty of a spectral fit (N·m·s²/rad, N·m·s/rad, N·m/rad).

    Parameters
    ----------
    fit : AdmittanceFit
        The fit.
    estimate : FrequencyResponse
        The n frequencies that were fitted (Hz, rad/(N·m)).
    bounds : Bounds
        Bounds of the fit (its units).
    sources : mapping of str to Source
        torque_scale, angle_scale and torque_delay_s, as far as they are known.
    power : ndarray, shape (n,), optional
        Power of the torque at these frequencies, for averages over whole periods: residuals are
        then unequal, and the distance to another criterion is the half width of a rectangular distribution.

    Returns
    -------
    Budget
        Budget of I, B, K.
    """
    contributions = _scales(_of_joint(fit.parameters), sources)
    if "torque_delay_s" in sources:
        u = sources["torque_delay_s"].standard_uncertainty
        turn = np.exp(2j * np.pi * estimate.frequency_hz * u)
        above, below = (
            fit_scaled(replace(estimate, response=response), bounds, fit.parameters).parameters
            for response in (estimate.response * turn, estimate.response / turn)
        )
        # a later torque would be a response that lags less
        contributions["torque_delay_s"] = 0.5 * (below - above)[None]
    type_a = fit.standard_error
    if power is not None:
        type_a = error_of_misfit(fit, estimate)
        contributions[CRITERION] = distance_to_other_criterion(fit, estimate, power)[None] / np.sqrt(3.0)
    return Budget(type_a, float(fit.degrees_of_freedom), contributions, _freedom(sources))


def period_budget(fit: PeriodFit, sources: Mapping[str, Source]) -> Budget:
    """Uncertainty of the regression over whole periods (units of ``fit``).

    The change with the lower part of the band counts as the half width of a rectangular distribution, because
    the linear joint nearest to a non-linear one differs between bands. The delay is estimated.

    Parameters
    ----------
    fit : PeriodFit
        The fit.
    sources : mapping of str to Source
        torque_scale and angle_scale, as far as they are known.

    Returns
    -------
    Budget
        Budget of I, B, K.
    """
    contributions = _scales(_of_joint(fit.parameters), sources)
    contributions[BAND] = fit.of_band[None] / np.sqrt(3.0)
    return Budget(fit.type_a, fit.freedom, contributions, _freedom(sources))


def pooled_budget(fit: PooledFit, sources: Mapping[str, Source]) -> Budget:
    """Uncertainty of the fit to all trials together (units of ``fit``), of its quantities in their order.

    Parameters
    ----------
    fit : PooledFit
        The fit.
    sources : mapping of str to Source
        torque_scale and angle_scale, as far as they are known.

    Returns
    -------
    Budget
        Budget of every quantity of ``fit.values``.
    """
    type_a = np.array([fit.standard_error[name] for name in fit.values])
    return Budget(type_a, fit.freedom, _scales(fit.values, sources), _freedom(sources))
