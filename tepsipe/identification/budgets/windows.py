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
from tepsipe.identification.regression.windows import WindowedFits
from tepsipe.mechanics.impedance_model import PARAMETERS
from tepsipe.mechanics.inverse_dynamics import Leg, leg_pathway_torque
from tepsipe.mechanics.segment_kinematics import SegmentMotion
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

    def of_torque(motion: SegmentMotion, torque: np.ndarray) -> np.ndarray:
        return estimate(name, replace(record, motion=motion, torque=torque)).mean

    if of_leg:
        _refuse_other_torque(uncertainty, record.torque)

        def of_leg_motion(motion: SegmentMotion, leg: Leg) -> np.ndarray:
            return of_torque(motion, leg_pathway_torque("leg", leg, motion))

        return leg_budget(fit, of_leg_motion, replace(uncertainty, sources=sources)), tuple(sources)
    contributions = scale_contributions(dict(zip(PARAMETERS, fit.mean, strict=True)), sources)
    rate = derivative(record.motion.time, record.torque)
    contributions |= delay_contributions(lambda x: of_torque(record.motion, x), rate, sources)
    freedom = {source: sources[source].freedom for source in contributions}
    return Budget(*fit.type_a, contributions, freedom), tuple(sources)


def _refuse_other_torque(known: LegUncertainty, torque: np.ndarray) -> None:
    of_leg = leg_pathway_torque("leg", known.leg, known.motion)
    if of_leg.shape != torque.shape or np.std(of_leg - torque) > LARGEST_DIFFERENCE * np.std(torque):
        raise InputError(
            "fit_impedance, uncertainty: expected a LegUncertainty whose leg and motion gave the torque, "
            "found another torque: give torque=joint_torque(motion, leg), and the same motion and leg"
        )
