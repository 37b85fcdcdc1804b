"""Rows of the tables of a walking study."""

from dataclasses import dataclass

import numpy as np

from tepsipe.experiments.walking.analysis import WalkingImpedance
from tepsipe.experiments.walking.impedance import QUANTITIES
from tepsipe.mechanics.impedance_model import UNITS


@dataclass(frozen=True)
class WalkingRow:
    """One quantity at one phase; the fields are columns of ``tables/walking.csv``.

    Attributes
    ----------
    condition : str
        The trial (no unit).
    pulses : str
        recorded, or none: then random strides stand for perturbed ones (no unit).
    phase_percent, at_percent : float
        Nominal phase of the onset, and phase to which K belongs (%).
    quantity, unit : str
        I, B or K and its unit.
    value, standard_error, ci_low, ci_high : float
        Estimate, combined standard uncertainty and 95 % interval (``unit``).
    u_type_a, u_type_b : float
        Standard uncertainties from the strides and from everything else (``unit``).
    perturbed, unperturbed : int
        Numbers of strides (-).
    response : float
        RMS response of the mean angle, in standard deviations of its chance (-).
    flags : str
        ``no-response``: the angle does not respond, and the interval is infinite (no unit).
    """

    condition: str
    pulses: str
    phase_percent: float
    at_percent: float
    quantity: str
    unit: str
    value: float
    standard_error: float
    ci_low: float
    ci_high: float
    u_type_a: float
    u_type_b: float
    perturbed: int
    unperturbed: int
    response: float
    flags: str


def walking_rows(condition: str, pulses: str, found: WalkingImpedance) -> list[WalkingRow]:
    """Rows of one trial (units in the rows)."""
    rows = []
    for phase, fit in found.phases.items():
        combined = fit.budget.combined
        for i, quantity in enumerate(QUANTITIES):
            numbers = (fit.values, combined, fit.low, fit.high, fit.budget.type_a, fit.budget.type_b)
            rows.append(
                WalkingRow(
                    condition,
                    pulses,
                    phase,
                    found.at_percent[phase],
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
