"""Fit of one record of a leg by one estimator, with its uncertainty.

The pathways of the dummy and the public functions both call `fit_record`, so they return the same estimates
and intervals.
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from tepsipe.identification.budgets.leg import LegUncertainty, leg_budget
from tepsipe.identification.budgets.markers import likelihood_quantities
from tepsipe.identification.estimators import Record, estimate
from tepsipe.identification.likelihood.result import LikelihoodEstimates
from tepsipe.identification.regression.windows import WindowedFits
from tepsipe.identification.result import Quantity, quantities_of
from tepsipe.mechanics.impedance_model import PARAMETERS
from tepsipe.mechanics.inverse_dynamics import Leg, leg_pathway_torque
from tepsipe.mechanics.segment_kinematics import SegmentMotion
from tepsipe.statistics.uncertainty import CONFIDENCE, Budget


def fit_record(
    name: str,
    record: Record,
    known: LegUncertainty,
    equation: str = "leg",
    confidence: float = CONFIDENCE,
    factor: float = 1.96,
) -> tuple[WindowedFits, dict[str, Quantity], Budget]:
    """Estimates of a record, with their quantities and budget.

    name: one of `ESTIMATORS`.
    known: assumed leg, with its uncertainty.
    equation: torque of the record, as in `leg_pathway_torque`.
    confidence: probability of the intervals of budgets.
    factor: half width of Wald's intervals of a likelihood's further quantities, in standard errors.

    Returns:
        fit: estimates of every window.
        quantities: I, B, K; of a likelihood also those of `likelihood_quantities`.
        budget: uncertainty of the means of I, B, K (N·m·s²/rad, N·m·s/rad, N·m/rad).
    """
    fit = estimate(name, record)
    if isinstance(fit, LikelihoodEstimates):
        return fit, *likelihood_quantities(fit, record, known, confidence, factor)
    reestimate = None if record.torque is None else reestimator(name, record, equation)
    budget = leg_budget(fit, reestimate, known)
    return fit, quantities_of(dict(zip(PARAMETERS, fit.mean, strict=True)), budget, confidence), budget


def reestimator(
    name: str, record: Record, equation: str = "leg"
) -> Callable[[SegmentMotion, Leg], np.ndarray]:
    """Function of motion and leg (s, rad, m, kg) that estimates I, B, K, shape (3,), of a record.

    Arguments are those of `fit_record`.
    """

    def reestimate(motion: SegmentMotion, leg: Leg) -> np.ndarray:
        torque = leg_pathway_torque(equation, leg, motion)
        return estimate(name, replace(record, motion=motion, torque=torque)).mean

    return reestimate
