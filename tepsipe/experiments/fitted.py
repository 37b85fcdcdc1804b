"""Results of the fit of a trial, or of several trials together, in one form for all experiments.

The module `fit` of an experiment has two functions. ``begin`` makes the first steps of the analysis, which
refuse an unusable recording, from a trial, the settings of the experiment and the trial's name. ``fit`` makes
all of them and returns a `Fitted`. Settings are plain dictionaries, as the configuration has them.
"""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from tepsipe.io.estimates import Contribution, Estimate, flagged
from tepsipe.io.result import Result
from tepsipe.io.trial import Trial, recorded_faults


@dataclass(frozen=True)
class Fitted:
    """Everything that is stored of a fit."""

    result: Result
    """Arrays and facts, for figures, pages and claims."""
    estimates: list[Estimate]
    """Rows of the table of estimates."""
    contributions: Sequence[Contribution] = ()
    """Rows of the table of uncertainty, as far as the estimates have a budget."""
    further: dict[str, Any] = field(default_factory=dict)
    """Name of a further output -> its content."""


def checked(trial: Trial, rows: Sequence[Estimate], *failed: str) -> list[Estimate]:
    """Rows of one trial with the faults of its recording and its failed checks as flags.

    None is recommended where the joint changes (``time-varying``).

    failed: names in `tepsipe.flags.FLAGS`.
    """
    changes, flags = "time-varying" in failed, (*recorded_faults(trial), *failed)
    return [replace(e, recommended=e.recommended and not changes) for e in flagged(rows, *flags)]
