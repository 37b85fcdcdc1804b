"""Rows of the joint likelihood of small movements, with their budget."""

from tepsipe.experiments.budgets import with_budget
from tepsipe.identification.likelihood.result import LikelihoodEstimates
from tepsipe.io.estimates import Estimate
from tepsipe.mechanics.impedance_model import PARAMETERS, UNITS
from tepsipe.statistics.uncertainty import Budget

# quantities of small movements: name in the rows -> name at the working amplitude
SMALL = {f"{quantity}_small": quantity for quantity in PARAMETERS}


def joint_estimates(
    names: tuple[str, str, str, str], fit: LikelihoodEstimates, budget: Budget, count: int
) -> list[Estimate]:
    """I, B, K of small movements, delay (s) of the angle after the foot, and softening if present.

    names: experiment, condition, pathway and estimator.
    budget: uncertainty of I, B, K of small movements.
    count: number of perturbations.
    Returns: those of delay and softening have Wald intervals.
    """
    rows = with_budget(
        [
            Estimate(*names, name, UNITS[quantity], float(fit.small[k]), n_perturbations=count)
            for k, (name, quantity) in enumerate(SMALL.items())
        ],
        budget,
        tuple(SMALL),
    )
    wanted = [("delay", "s", "delay")]
    if fit.fit.softens:
        wanted += [("K_softened", "Nm/rad", "C"), ("B_softened", "Nms/rad", "B_s")]
    for quantity, unit, name in wanted:
        value, error = fit.fit.value(name), fit.fit.standard_error(name)
        ends = (value - 1.96 * error, value + 1.96 * error)
        rows.append(Estimate(*names, quantity, unit, value, error, *ends, n_perturbations=count))
    return rows
