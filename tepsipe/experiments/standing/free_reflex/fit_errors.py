"""Effect of each source of uncertainty on B and K of a fit of mean responses, and on differences of fits.

Effects are of first order, with the weights of the fit kept. Signs, draws and single responses are kept as
well, so that errors common to two fits of the same trials cancel in their difference.
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np

from tepsipe.experiments.standing.free_reflex.broadband import BroadbandEpochs
from tepsipe.identification.regression.generalised import (
    GeneralisedFit,
    Record,
    sensitivity,
    squared_exponential,
)
from tepsipe.statistics.uncertainty import Source, root_of_draws

TORQUE, ANKLE, ANKLE_D = range(3)
# signals that B and K multiply
REGRESSORS = [ANKLE_D, ANKLE]
TREADMILL = "treadmill_model"


@dataclass(frozen=True)
class FitErrors:
    """Errors of B and K by source."""

    parameters: Annotated[np.ndarray, "(2,)"]
    """B (N·m·s/rad) and K (N·m/rad)."""
    scatter: Annotated[np.ndarray, "(responses, 2)"]
    """Share of every response in the error, scaled so that the sum of squares is the variance."""
    freedom: float
    """Its degrees of freedom."""
    contributions: dict[str, np.ndarray]
    """Source -> root of its covariance, shape (k, 2)."""
    discrepancy: Annotated[np.ndarray, "(trials, n, 2)"]
    """For each trial, root of the covariance by a misfit of the rig's model of the size of its largest
    torque."""

    def minus(self, other: "FitErrors") -> "FitErrors":
        """Errors of the difference from another fit of the same trials and sources."""
        n = max(self.discrepancy.shape[1], other.discrepancy.shape[1])
        nothing = np.zeros((1, 2))
        return FitErrors(
            self.parameters - other.parameters,
            self.scatter - other.scatter,
            self.freedom,
            {
                name: self.contributions.get(name, nothing) - other.contributions.get(name, nothing)
                for name in dict.fromkeys([*self.contributions, *other.contributions])
            },
            _padded(self.discrepancy, n) - _padded(other.discrepancy, n),
        )

    def variance(self, discrepancy: float) -> np.ndarray:
        """Variance by scatter, sources, and a share of misfit that is common to all trials, shape (2,).

        In squared units of B and K.
        """
        rows = [self.scatter, *self.contributions.values(), discrepancy * self.discrepancy.sum(axis=0)]
        return sum((x**2).sum(axis=0) for x in rows)


def _padded(rows: np.ndarray, most: int) -> np.ndarray:
    """Root of a covariance for every trial, shape (trials, n, 2), padded with rows of 0 to ``most`` rows.

    Roots of a process in windows that begin together are Cholesky factors: row k belongs to the same deviate.
    """
    return np.pad(rows, ((0, 0), (0, most - rows.shape[1]), (0, 0)))


def fit_errors(
    trials: list[BroadbandEpochs],
    fit: GeneralisedFit,
    records: list[Record],
    inside: np.ndarray,
    sources: list[Source],
    discrepancy_s: float,
) -> FitErrors:
    """Errors of a fit.

    fit, records: the fit of their means, and what it was fitted to.
    inside: samples of the window.
    sources: uncertain constants; sources that move no signal are ignored.
    discrepancy_s: length of the misfit.
    """
    responses = sum(trial.count for trial in trials)
    freedom = max(1.0, float(responses - len(trials)))
    return FitErrors(
        fit.parameters,
        np.sqrt(responses / freedom) * _of_responses(trials, fit, records, inside),
        freedom,
        _of_signals(trials, fit, records, inside, sources) | _of_treadmill(trials, fit, records, inside),
        _of_discrepancy(fit, records, trials[0].time[inside], discrepancy_s),
    )


def _of_responses(
    trials: list[BroadbandEpochs], fit: GeneralisedFit, records: list[Record], inside: np.ndarray
) -> np.ndarray:
    """Change of B and K by every response's deviation from the mean of its trial, shape (responses, 2)."""
    changes = []
    for k, trial in enumerate(trials):
        around = (trial.perturbed[:, inside] - trial.perturbed[:, inside].mean(axis=0)) / trial.count
        regressors = [np.zeros((trial.count, *record.regressors.shape)) for record in records]
        target = [x[..., 0] for x in regressors]
        regressors[k], target[k] = around[..., REGRESSORS], around[..., TORQUE]
        changes.append(sensitivity(fit, records, target, regressors))
    return np.concatenate(changes)


def _of_signals(
    trials: list[BroadbandEpochs],
    fit: GeneralisedFit,
    records: list[Record],
    inside: np.ndarray,
    sources: list[Source],
) -> dict[str, np.ndarray]:
    """Signed contributions to B and K of the sources that move the signals, each of shape (1, 2)."""
    contributions = {}
    for source in sources:
        if source.name in trials[0].slopes:
            errors = [source.standard_uncertainty * trial.slopes[source.name][inside] for trial in trials]
            changes = sensitivity(
                fit, records, [m[:, TORQUE] for m in errors], [m[:, REGRESSORS] for m in errors]
            )
            contributions[source.name] = changes[None]
    return contributions


def _of_treadmill(
    trials: list[BroadbandEpochs], fit: GeneralisedFit, records: list[Record], inside: np.ndarray
) -> dict[str, np.ndarray]:
    """Root of the covariance of B and K by the calibration of the treadmill model, if it has draws."""
    shared = min((len(trial.draws) for trial in trials), default=0)
    if shared < 2:
        return {}
    errors = sensitivity(fit, records, [trial.draws[:shared, inside] for trial in trials])
    return {TREADMILL: root_of_draws(errors)}


def _of_discrepancy(
    fit: GeneralisedFit, records: list[Record], time: np.ndarray, length_s: float
) -> np.ndarray:
    """Root of the covariance of B and K by a smooth misfit of the largest torque of each trial."""
    smooth = squared_exponential(time, length_s) + 1e-6 * np.eye(time.size)
    shapes = np.linalg.cholesky(smooth).T
    roots = []
    for k, record in enumerate(records):
        peak = record.target[np.abs(record.target).argmax()]
        alone = [(peak if j == k else 0.0) * shapes for j in range(len(records))]
        roots.append(sensitivity(fit, records, alone))
    return np.stack(roots)
