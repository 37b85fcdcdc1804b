"""Rows of the tables of a walking study."""

from dataclasses import dataclass

import numpy as np

from tepsipe.experiments.budgets import rows_of
from tepsipe.experiments.fitted import FittedBudget
from tepsipe.experiments.walking.analysis import WalkingImpedance
from tepsipe.experiments.walking.impedance import QUANTITIES, PhaseImpedance
from tepsipe.identification.result import Quantity, symbol_of
from tepsipe.io.estimates import Estimate, flagged, recommended
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
) -> tuple[list[Estimate], list[FittedBudget]]:
    """Rows of one trial for the table of estimates, and their uncertainty.

    The pathway is the phase of the onset. K belongs to the quantity ``phase`` of the same pathway (%). Where
    the angle does not respond, or the foot is in the air, there is no value: flags ``not-identified`` and the
    reason.
    """
    rows, budgets = [], []
    for phase, fit in impedance.phases.items():
        rows_of_phase = _of_phase(condition, phase, fit)
        if not fit.flags:
            budgets.append(FittedBudget(phase_pathway(phase), ESTIMATOR, QUANTITIES, fit.budget))
            head = (EXPERIMENT, condition, phase_pathway(phase), ESTIMATOR)
            rows_of_phase.append(Estimate(*head, "phase", "%", float(impedance.at_percent[phase])))
            rows_of_phase = recommended(rows_of_phase, phase_pathway(phase), ESTIMATOR)
        rows += rows_of_phase
    return rows, budgets


def _of_phase(condition: str, phase: float, fit: PhaseImpedance) -> list[Estimate]:
    """I, B and K of one phase; without values where they are undetermined."""
    head = (EXPERIMENT, condition, phase_pathway(phase), ESTIMATOR)
    if fit.flags:
        nothing = [
            Estimate(*head, q, UNITS[q], float("nan"), n_perturbations=fit.perturbed) for q in QUANTITIES
        ]
        return flagged(nothing, "not-identified", fit.flags)
    columns = (fit.values, fit.budget.combined, fit.low, fit.high, fit.budget.type_a, fit.budget.type_b)
    quantities = {
        name: Quantity(value, symbol_of(name), *numbers)
        for name, value, *numbers in zip(QUANTITIES, *map(np.ndarray.tolist, columns), strict=True)
    }
    rows = rows_of(head, quantities, fit.perturbed)
    known = fit.budget.type_a[0] == 0.0  # I was not estimated
    return [*flagged(rows[:1], *["assumed"] * bool(known)), *rows[1:]]
