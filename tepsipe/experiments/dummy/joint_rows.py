"""Rows and facts of the joint likelihood of one trial of the dummy."""

from tepsipe.experiments.budgets import with_budget
from tepsipe.identification.joint_result import JointLikelihood
from tepsipe.io.estimates import Estimate
from tepsipe.mechanics.impedance_model import PARAMETERS, UNITS
from tepsipe.statistics.uncertainty import Budget

# quantities of small movements: name in the rows -> that at the working amplitude
SMALL = {f"{quantity}_small": quantity for quantity in PARAMETERS}


def joint_estimates(
    names: tuple[str, str, str, str], found: JointLikelihood, budget: Budget, count: int
) -> list[Estimate]:
    """I, B, K of small movements, delay (s) of the angle after the foot, and softening where there is some.

    Parameters
    ----------
    names : tuple of str
        Experiment, condition, pathway and estimator.
    found : JointLikelihood
        The fit.
    budget : Budget
        Uncertainty of I, B, K of small movements (their units).
    count : int
        Number of perturbations (-).

    Returns
    -------
    list of Estimate
        Those of delay and softening have Wald intervals.
    """
    rows = with_budget(
        [
            Estimate(*names, name, UNITS[quantity], float(found.small[k]), n_perturbations=count)
            for k, (name, quantity) in enumerate(SMALL.items())
        ],
        budget,
        tuple(SMALL),
    )
    wanted = [("delay", "s", "delay")]
    if found.fit.softens:
        wanted += [("K_softened", "Nm/rad", "C"), ("B_softened", "Nms/rad", "B_s")]
    for quantity, unit, name in wanted:
        value, error = found.fit.value(name), found.fit.standard_error(name)
        ends = (value - 1.96 * error, value + 1.96 * error)
        rows.append(Estimate(*names, quantity, unit, value, error, *ends, n_perturbations=count))
    return rows


def joint_facts(found: JointLikelihood) -> dict:
    """Noise levels, timing and softening of a fit, as plain numbers (units in the keys)."""
    fit = found.fit
    facts = {
        "delay_s": fit.value("delay"),
        "delay_standard_error_s": fit.standard_error("delay"),
        "marker_noise_m": fit.channels.marker_noise_m,
        "log_noise_m_per_s": fit.log_noise_m_per_s,
    }
    if fit.log_noise_m_per_s is not None:
        facts |= {"log_lag_s": fit.value("lag"), "log_gain": fit.value("gain")}
    if found.softening is not None:
        softening, damping, half = found.softening
        facts |= {
            "softening_Nm_per_rad": softening,
            "softened_damping_Nms_per_rad": damping,
            "half_softening_rad": half,
            "softening_chi_square": fit.softening_chi_square,
        }
    return facts
