"""Fits to the responses of a standing person by any estimator, and their rows in the tables of a study."""

import zlib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Annotated

import numpy as np

from tepsipe.experiments.budgets import contributions_of, rows_of
from tepsipe.identification.result import Quantity
from tepsipe.io.estimates import Contribution, Estimate
from tepsipe.statistics.uncertainty import Budget


@dataclass(frozen=True)
class StandingFit:
    """Parameters of the ankles, from one trial or from several together."""

    quantities: dict[str, Quantity]
    """I, B and K, as far as they are estimated; `of_responses`; then, if there are delays, peak active torque
    relative to the peak intrinsic torque in the window, and the delays with the smallest and largest of the
    values tried that the responses do not reject."""
    curves: list[dict[str, np.ndarray]]
    """Per trial: ``time`` (s), ``torque``, ``intrinsic``, ``active`` (N·m), ``ankle`` (rad)."""
    responses: int
    """Number of responses."""
    gains: dict[str, float] = field(default_factory=dict)
    """Gains of the active torque."""
    budget: Budget | None = None
    """Type A and B of B and K; None if only their scatter is known."""
    windows: Annotated[np.ndarray, "(w, 3)"] | None = None
    """Window (s), B and K by it, where the estimator tries several."""
    apart: tuple[str, ...] = ()
    """A sentence for every trial of a task that differs from the others."""
    quotable: bool = True
    """False where trials differ so much that no value of the task is quoted."""


# (pathway, estimator) -> fit
Fits = dict[tuple[str, str], StandingFit]


def generator(seed: int, *names: str) -> np.random.Generator:
    """Random generator of one fit, independent of the others."""
    return np.random.default_rng([seed, zlib.crc32("/".join(names).encode())])


def of_responses(curves: list[dict[str, np.ndarray]], vaf: Annotated[float, "%"]) -> dict[str, Quantity]:
    """Peak-to-peak mean rotation of the ankle in the window, mean over trials, and VAF of the responses."""
    rotation = float(np.mean([np.ptp(curve["ankle"]) for curve in curves]))
    return {"rotation": Quantity(rotation, "rad"), "VAF_response": Quantity(float(vaf), "%")}


def with_share(
    quantities: Mapping[str, Quantity], critical_stiffness: Annotated[float, "N·m/rad"]
) -> dict[str, Quantity]:
    """The quantities, and after K the same over m g h, the critical stiffness."""
    found = {}
    for name, quantity in quantities.items():
        found[name] = quantity
        if name == "K":
            # the table of uncertainty has K alone
            found["K_over_mgh"] = replace(quantity.times(1.0 / critical_stiffness, "1"), parts={})
    return found


def fit_rows(
    condition: str, fits: Fits, critical_stiffness: Annotated[float, "N·m/rad"]
) -> tuple[list[Estimate], list[Contribution]]:
    """Rows of a trial or task in the tables of estimates and of uncertainty.

    critical_stiffness: m g h.
    """
    rows, contributions = [], []
    for key, fit in fits.items():
        names = ("standing", condition, *key)
        rows += rows_of(names, with_share(fit.quantities, critical_stiffness), fit.responses)
        contributions += contributions_of(names, fit.quantities)
    return rows, contributions
