"""Results of the fit of a trial, or of several trials together, in one form for all experiments.

The module `fit` of an experiment has two functions. ``begin`` makes the first steps of the analysis, which
refuse an unusable recording, from a trial, the settings of the experiment and the trial's name. ``fit`` makes
all of them and returns a `Fitted`. Settings are plain dictionaries, as the configuration has them.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from tepsipe.experiments.budgets import contributions_of
from tepsipe.io.estimates import Contribution, Estimate
from tepsipe.io.result import Result
from tepsipe.statistics.uncertainty import Budget


@dataclass(frozen=True)
class FittedBudget:
    """Uncertainty of quantities of one pathway and estimator."""

    pathway: str
    estimator: str
    quantities: Sequence[str]
    """Names of the quantities in the order of the budget."""
    budget: Budget


@dataclass(frozen=True)
class Fitted:
    """Everything that is stored of a fit."""

    result: Result
    """Arrays and facts, for figures, pages and claims."""
    estimates: list[Estimate]
    """Rows of the table of estimates."""
    budgets: Sequence[FittedBudget] = ()
    """Uncertainty of the estimates, as far as it has sources."""
    further: dict[str, Any] = field(default_factory=dict)
    """Name of a further output -> its content."""

    @property
    def contributions(self) -> list[Contribution]:
        """Rows of the table of uncertainty."""
        return [
            contribution
            for of in self.budgets
            for contribution in contributions_of(
                [e for e in self.estimates if (e.pathway, e.estimator) == (of.pathway, of.estimator)],
                of.budget,
                of.quantities,
            )
        ]
