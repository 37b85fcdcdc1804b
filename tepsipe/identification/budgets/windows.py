"""Uncertainty of I, B, K of a joint by windowed least squares, from stated sources of Type B."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from tepsipe.errors import InputError
from tepsipe.identification.budgets.leg import KNOWN_OF_LEGS, LegUncertainty, leg_budget
from tepsipe.identification.budgets.manipulator import (
    MANIPULATOR_SOURCES,
    delay_contributions,
    scale_contributions,
)
from tepsipe.identification.estimators import LEAST_SQUARES_THESIS, Record, estimate
from tepsipe.identification.leg_fit import reestimator
from tepsipe.identification.regression.windows import WindowedFits
from tepsipe.identification.result import Quantity, parts_of
from tepsipe.mechanics.impedance_model import PARAMETERS
from tepsipe.mechanics.inverse_dynamics import leg_pathway_torque
from tepsipe.signals.differentiation import derivative
from tepsipe.statistics.uncertainty import Budget, Source, stated_sources

# largest difference of a torque from the leg's own, relative to its spread
LARGEST_DIFFERENCE = 0.1


def windows_budget(
    fit: WindowedFits,
    name: str,
    record: Record,
    uncertainty: Mapping[str, float | Source] | LegUncertainty | None,
) -> tuple[Budget, tuple[str, ...]]:
    """Uncertainty of the means of I, B, K (N·m·s²/rad, N·m·s/rad, N·m/rad).

    name: their estimator.
    record: what they were estimated from.
    uncertainty: stated uncertainty of the scales of torque and angle and of the torque's delay, or of a
    leg.

    Returns:
        budget: type A and one entry per source.
        sources: sources of Type B.
    """
    place = "fit_impedance"
    of_leg = isinstance(uncertainty, LegUncertainty)
    stated = uncertainty.sources if of_leg else uncertainty
    sources = stated_sources(stated, KNOWN_OF_LEGS if of_leg else MANIPULATOR_SOURCES, place)
    if sources and name == LEAST_SQUARES_THESIS:
        raise InputError(
            f"{place}: expected no uncertainty with thesis, because the error of a wrong equation is not due "
            "to its inputs, found both: leave one out"
        )
    if of_leg:
        _refuse_other_torque(uncertainty, record.torque)
        known = replace(uncertainty, sources=sources)
        return leg_budget(fit, reestimator(name, record), known), tuple(sources)
    contributions = scale_contributions(dict(zip(PARAMETERS, fit.mean, strict=True)), sources)
    rate = derivative(record.motion.time, record.torque)
    contributions |= delay_contributions(
        lambda x: estimate(name, replace(record, torque=x)).mean, rate, sources
    )
    freedom = {source: sources[source].freedom for source in contributions}
    return Budget(*fit.type_a, contributions, freedom), tuple(sources)


def _refuse_other_torque(known: LegUncertainty, torque: np.ndarray) -> None:
    of_leg = leg_pathway_torque("leg", known.leg, known.motion)
    if of_leg.shape != torque.shape or np.std(of_leg - torque) > LARGEST_DIFFERENCE * np.std(torque):
        raise InputError(
            "fit_impedance, uncertainty: expected a LegUncertainty whose leg and motion gave the torque, "
            "found another torque: give torque=joint_torque(motion, leg), and the same motion and leg"
        )


def with_scales(
    quantities: Mapping[str, Quantity],
    sources: Mapping[str, Source],
    confidence: float,
    further: Mapping[str, np.ndarray] | None = None,
) -> dict[str, Quantity]:
    """Bootstrapped quantities with Type B of the scales of torque and angle.

    Each end of an interval moves outwards by the half width of Type B, in quadrature, because bootstrapped
    intervals are not symmetric.

    quantities: p estimates of Type A by name.
    sources: torque_scale and angle_scale, as far as they are known.
    confidence: probability of the intervals.
    further: contributions of other sources, as in `Budget.contributions`.
    Returns: by the same names.
    """
    powers = {name: _powers(q.unit) for name, q in quantities.items()}
    values = {name: q.value for name, q in quantities.items()}
    type_a = np.array([q.standard_error for q in quantities.values()])
    contributions = scale_contributions(values, sources, powers) | dict(further or {})
    freedom = {name: sources[name].freedom for name in contributions}
    budget = Budget(type_a, np.inf, contributions, freedom)
    of_b = Budget(np.zeros_like(type_a), np.inf, contributions, freedom)
    half = of_b.interval(np.zeros_like(type_a), confidence)[1]
    wider = {
        name: replace(
            q,
            standard_error=float(budget.combined[k]),
            low=q.value - float(np.hypot(q.value - q.low, half[k])),
            high=q.value + float(np.hypot(q.high - q.value, half[k])),
        )
        for k, (name, q) in enumerate(quantities.items())
    }
    widened = wider if contributions else quantities
    return {
        name: replace(q, parts=parts)
        for (name, q), parts in zip(widened.items(), parts_of(budget), strict=True)
    }


def _powers(unit: str) -> tuple[int, int]:
    """Powers of the torque and of the angle in a unit such as N·m·s/rad."""
    torque = int("N·m" in unit)
    if "/rad" not in unit:
        return torque, int(unit.startswith("rad"))
    return torque, -2 if unit.endswith("rad²") else -1
