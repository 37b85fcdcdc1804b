"""Registry of the estimators of one trial in the torque-controlled manipulator.

To add one, write a function from a `WristalyzerRecord` to a `Fitted`, and enter it in `ESTIMATORS`. Tables,
budgets, the comparison with the truth and the pages then show it.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated

import numpy as np

from tepsipe.experiments.wristalyzer.names import AS_PRINTED, MODULUS, PERIODS, REGRESSION

if TYPE_CHECKING:
    from tepsipe.experiments.wristalyzer.record import WristalyzerRecord
    from tepsipe.identification.admittance_fit import AdmittanceFit
    from tepsipe.signals.response import FrequencyResponse
    from tepsipe.statistics.uncertainty import Budget

# the first of these that a trial allows is recommended
RECOMMENDED = (REGRESSION, AS_PRINTED)


@dataclass(frozen=True)
class Fitted:
    """Result of an estimator of one trial."""

    parameters: Annotated[np.ndarray, "(3,)"]
    """I, B, K (N·m·s²/rad, N·m·s/rad, N·m/rad)."""
    budget: "Budget | None" = None
    """Their uncertainty (same units); None without intervals."""
    spectrum: "FrequencyResponse | None" = None
    """Response that was fitted, over all frequencies (Hz, rad/(N·m))."""
    search: "AdmittanceFit | None" = None
    """Search for the parameters (same units); its error and its SEM as printed become rows."""
    flags: tuple[str, ...] = ()
    """Failed checks, names in `tepsipe.io.estimates.FLAGS`."""


@dataclass(frozen=True)
class Estimator:
    """An estimator of I, B, K from one trial."""

    meaning: str
    """Description in a few words."""
    function: "Callable[[WristalyzerRecord], Fitted]"
    """From a `WristalyzerRecord` to `Fitted`."""
    needs_period: bool = False
    """True if the perturbation must be periodic; other trials do without the estimator."""
    in_table: bool = False
    """True for a block of rows in Table 4-1."""


def _searched(
    search: "AdmittanceFit", spectrum: "FrequencyResponse", budget: "Budget | None" = None
) -> Fitted:
    flags = ("at-bound",) * search.at_bound + ("not-converged",) * (not search.converged)
    return Fitted(search.parameters, budget, spectrum, search, flags)


# modules are imported when their estimator runs, to keep the start of a run short
def _spectral_fit(record: "WristalyzerRecord") -> Fitted:
    from tepsipe.identification.admittance_fit import fit_scaled
    from tepsipe.identification.budgets.manipulator import spectral_budget

    band, bounds = record.averaged.band(*record.options.fit_band_hz), record.options.bounds
    search = fit_scaled(band, bounds)
    budget = spectral_budget(search, band, bounds, record.sources)
    return _searched(search, record.averaged, budget)


def _modulus(record: "WristalyzerRecord") -> Fitted:
    from tepsipe.identification.admittance_fit import fit_as_printed

    # no budget: the sum of squares tells nothing about the scatter of a fit that ends where it began
    search = fit_as_printed(record.averaged.band(*record.options.fit_band_hz), record.options.bounds)
    return _searched(search, record.averaged)


def _over_periods(record: "WristalyzerRecord") -> Fitted:
    from tepsipe.identification.admittance_fit import fit_scaled
    from tepsipe.identification.budgets.manipulator import spectral_budget

    band, bounds = record.periodic.band(*record.options.fit_band_hz), record.options.bounds
    search = fit_scaled(band, bounds)
    budget = spectral_budget(search, band, bounds, record.sources)
    return _searched(search, record.periodic, budget)


def _regression(record: "WristalyzerRecord") -> Fitted:
    from tepsipe.identification.budgets.manipulator import period_budget
    from tepsipe.identification.regression.periods import fit_periods

    # not filtered: its lines are far below half the rate
    signals = (record.recorded("torque"), record.recorded("angle"), record.trial.rate_hz)
    fit = fit_periods(*signals, record.options.perturbation_period_s, record.options.excited_band_hz)
    return Fitted(fit.parameters, period_budget(fit, record.sources))


ESTIMATORS = {
    AS_PRINTED: Estimator(
        "raw spectra averaged over neighbouring frequencies, smallest criterion (3-6)",
        _spectral_fit,
        in_table=True,
    ),
    MODULUS: Estimator(
        "the same with the modulus of the log ratio as residual, as (3-6) is printed", _modulus
    ),
    PERIODS: Estimator(
        "spectra averaged over whole periods, same criterion", _over_periods, needs_period=True, in_table=True
    ),
    REGRESSION: Estimator(
        "linear joint nearest to the torque at the lines of the perturbation, other periods as instruments",
        _regression,
        needs_period=True,
    ),
}
