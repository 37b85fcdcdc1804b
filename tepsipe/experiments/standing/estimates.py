"""Fits to the responses of a standing person by any estimator, and their rows in the table of estimates."""

import zlib
from dataclasses import dataclass, field
from typing import Annotated

import numpy as np
import scipy

from tepsipe.experiments.budgets import rows_of
from tepsipe.identification.result import Quantity, symbol_of
from tepsipe.io.estimates import Estimate, flagged
from tepsipe.mechanics.impedance_model import PARAMETERS
from tepsipe.statistics.uncertainty import Budget


@dataclass(frozen=True)
class StandingFit:
    """Parameters of the ankles, from one trial or from several together."""

    names: tuple[str, ...]
    """I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad), then gains of the active torque."""
    parameters: Annotated[np.ndarray, "(1 + draws, p)"]
    """Estimates from the responses (first row), and from resampled ones."""
    delays: dict[str, float]
    """Selected T, L, D (s)."""
    vaf: Annotated[float, "%"]
    """VAF of the mean responses in the window."""
    rotation_rad: float
    """Peak-to-peak mean rotation of the ankle in the window, mean over trials."""
    active_peak: float
    """Peak active torque relative to the peak intrinsic torque in the window."""
    curves: list[dict[str, np.ndarray]]
    """Per trial: ``time`` (s), ``torque``, ``intrinsic``, ``active`` (N·m), ``ankle`` (rad)."""
    responses: int
    """Number of responses."""
    delay_ranges: dict[str, tuple[float, float]] = field(default_factory=dict)
    """Smallest and largest of the values tried for T, L, D (s) that the responses do not reject."""
    delays_at_bound: tuple[str, ...] = ()
    """Parameters among T, L and D for which all values but the first, or all but the last, are rejected."""
    budget: Budget | None = None
    """Type A and B of the parameters in their order; None if only their scatter is known."""
    flags: tuple[str, ...] = ()
    """Checks that the parameters failed."""
    windows: Annotated[np.ndarray, "(w, 3)"] | None = None
    """Window (s), B and K by it, where the estimator tries several."""

    def interval(self, name: str) -> tuple[float, float, float, float]:
        """Value, standard error, and both ends of the 95 % interval of a parameter."""
        if self.budget is not None:
            k = self.names.index(name)
            low, high = self.budget.interval(self.parameters[0])
            return float(self.parameters[0, k]), float(self.budget.combined[k]), float(low[k]), float(high[k])
        draws = self.parameters[:, self.names.index(name)]
        # resampling n responses within each trial underestimates their spread and the tails
        n, freedom = self.responses, self.responses - len(self.curves)
        deviations = np.sqrt(n / freedom) * (draws[1:] - draws[0])
        tails = scipy.stats.t.ppf(0.975, freedom) / scipy.stats.norm.ppf(0.975)
        low, high = tails * np.percentile(deviations, [2.5, 97.5])
        value = float(draws[0])
        return value, float(deviations.std()), value + float(low), value + float(high)

    def quantity(self, name: str) -> Quantity:
        """I, B or K with its uncertainty, which is of Type A without a budget."""
        value, error, low, high = self.interval(name)
        types: tuple[float, ...] = (error,)
        if self.budget is not None:
            k = self.names.index(name)
            types = float(self.budget.type_a[k]), float(self.budget.type_b[k])
        return Quantity(value, symbol_of(name), error, low, high, *types)


# (pathway, estimator) -> fit
Fits = dict[tuple[str, str], StandingFit]


def generator(seed: int, *names: str) -> np.random.Generator:
    """Random generator of one fit, independent of the others."""
    return np.random.default_rng([seed, zlib.crc32("/".join(names).encode())])


def standing_estimates(
    condition: str, pathway: str, estimator: str, fit: StandingFit, critical_stiffness: float
) -> list[Estimate]:
    """Tidy rows: I, B, K, K over m g h, rotation, VAF, and the selected delays.

    ``critical_stiffness`` is m g h (N·m/rad).
    """
    about = ("standing", condition, pathway, estimator)
    n = fit.responses
    names = {"T": "twitch_time", "L": "reflex_delay", "D": "balance_delay"}
    quantities = {name: fit.quantity(name) for name in fit.names if name in PARAMETERS}
    quantities["K_over_mgh"] = quantities["K"].times(1.0 / critical_stiffness, "1")
    rows = flagged(rows_of(about, quantities, n), *fit.flags)
    plain = {
        "rotation": ("rad", fit.rotation_rad),
        "VAF_response": ("%", fit.vaf),
    }
    if fit.delays:
        plain["active_torque_share"] = ("1", fit.active_peak)
    rows += [Estimate(*about, key, unit, float(v), n_perturbations=n) for key, (unit, v) in plain.items()]
    for key, value in fit.delays.items():
        low, high = fit.delay_ranges[key]
        delay = Estimate(*about, names[key], "s", value, ci_low=low, ci_high=high, n_perturbations=n)
        rows += flagged([delay], *["at-bound"] * (key in fit.delays_at_bound))
    return rows
