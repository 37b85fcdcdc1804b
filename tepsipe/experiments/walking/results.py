"""Rows of the tables of a walking study."""

from dataclasses import dataclass, replace

import numpy as np

from tepsipe.experiments.budgets import contributions_of, rows_of
from tepsipe.experiments.walking.analysis import WalkingImpedance
from tepsipe.experiments.walking.impedance import QUANTITIES
from tepsipe.identification.result import Quantity, quantities_of, symbol_of
from tepsipe.io.estimates import FLAGS, Contribution, Estimate, recommended
from tepsipe.io.tables import Table
from tepsipe.mechanics.impedance_model import UNITS

EXPERIMENT, ESTIMATOR = "walking", "matched-strides"
# from this phase on the foot is in the air (% of stance)
SWING_PERCENT = 100.0


@dataclass(frozen=True)
class WalkingRow:
    """One quantity at one phase; the fields are columns of ``tables/walking.csv``."""

    condition: str
    pulses: str
    """recorded, or none: then random strides stand for perturbed ones."""
    phase_percent: float
    at_percent: float
    """Nominal phase of the onset, and phase to which K belongs."""
    quantity: str
    unit: str
    value: float
    standard_error: float
    ci_low: float
    ci_high: float
    """Estimate, combined standard uncertainty and 95 % interval (``unit``)."""
    u_type_a: float
    u_type_b: float
    """Standard uncertainties from the strides and from everything else (``unit``)."""
    perturbed: int
    unperturbed: int
    """Numbers of strides."""
    response: float
    """RMS response of the mean angle, in standard deviations of its chance."""
    flags: str
    """``no-response``: the angle does not respond; ``no-contact``: the foot is in the air. Then there is no
    value, and the interval is infinite."""


WALKING_ROWS = Table(WalkingRow, "impedance in walking")


def walking_rows(condition: str, pulses: str, impedance: WalkingImpedance) -> list[WalkingRow]:
    """Rows of one trial."""
    rows = []
    for phase, fit in impedance.phases.items():
        combined = fit.budget.combined
        values = np.full(len(QUANTITIES), np.nan) if fit.flags else fit.values
        for i, quantity in enumerate(QUANTITIES):
            numbers = (values, combined, fit.low, fit.high, fit.budget.type_a, fit.budget.type_b)
            rows.append(
                WalkingRow(
                    condition,
                    pulses,
                    phase,
                    impedance.at_percent[phase],
                    quantity,
                    UNITS[quantity],
                    *(float(np.asarray(column)[i]) for column in numbers),
                    perturbed=fit.perturbed,
                    unperturbed=fit.unperturbed,
                    response=fit.response,
                    flags=fit.flags,
                )
            )
    return rows


def phase_pathway(phase: float) -> str:
    """Name of a phase (% of stance) among the pathways of the table of estimates."""
    return f"{'swing' if phase >= SWING_PERCENT else 'stance'}-{phase:g}"


def walking_estimates(
    condition: str, impedance: WalkingImpedance
) -> tuple[list[Estimate], list[Contribution]]:
    """Rows of one trial for the tables of estimates and of uncertainty.

    The pathway is the phase of the onset. K belongs to the quantity ``phase`` of the same pathway (%). Where
    the angle does not respond, or the foot is in the air, there is no value: flags ``not-identified`` and the
    reason.
    """
    rows, contributions = [], []
    for phase, fit in impedance.phases.items():
        names = (EXPERIMENT, condition, phase_pathway(phase), ESTIMATOR)
        if fit.flags:
            why = {"flags": (fit.flags,), "refusal": FLAGS[fit.flags]}
            refused = {name: Quantity(np.nan, symbol_of(name), **why) for name in QUANTITIES}
            rows += rows_of(names, refused, fit.perturbed)
            continue
        quantities = quantities_of(dict(zip(QUANTITIES, fit.values, strict=True)), fit.budget)
        if fit.budget.type_a[0] == 0.0:  # I was not estimated
            quantities["I"] = replace(quantities["I"], flags=("assumed",))
        rows += recommended(rows_of(names, quantities, fit.perturbed), phase_pathway(phase), ESTIMATOR)
        rows += rows_of(names, {"phase": Quantity(float(impedance.at_percent[phase]), "%")})
        contributions += contributions_of(names, quantities)
    return rows, contributions
