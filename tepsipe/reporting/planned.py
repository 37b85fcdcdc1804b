"""What the planning says about the thesis's own experiments: one row per number of ``tables/planned.csv``.

Before an experiment, from rig and protocol alone: standard uncertainty of I, B, K by profile, amplitude and
free body, the best pulse within the peaks of the thesis's, and what filters do without noise. See
`tepsipe.experiments.planning` for the method.
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace

from tepsipe.experiments.planning.design import FOOT, JOINT_LIKELIHOOD, LEG, Design, Protocol, Rig
from tepsipe.experiments.planning.filtering import mismatch_bias
from tepsipe.experiments.planning.optimal_pulse import best_of
from tepsipe.experiments.planning.plan import Plan, plan_experiment
from tepsipe.experiments.planning.pulses import peaks_of, pulse_of
from tepsipe.io.tables import Table
from tepsipe.mechanics.engines.interface import Joint
from tepsipe.mechanics.impedance_model import PARAMETERS, UNITS
from tepsipe.mechanics.inverse_dynamics import Foot, Leg
from tepsipe.signals.filters import Lowpass
from tepsipe.statistics.uncertainty import Source

# profile, peak velocity (m/s) and pathway of the designs
DESIGNS = (
    ("sine", 0.1, LEG),
    ("sine", 0.3, LEG),
    ("sine", 0.5, LEG),
    ("minjerk", 0.3, LEG),
    ("sine", 0.3, FOOT),
    ("sine", 0.3, JOINT_LIKELIHOOD),
)
# name of a filter's rows -> whether it is zero-lag, and whether torque and motion pass it
FILTERS = {
    "zero-lag, all signals": (True, True, True),
    "zero-lag, torque only": (True, True, False),
    "one-sided, all signals": (False, True, True),
    "one-sided, torque only": (False, True, False),
}
TYPE_A, TYPE_B, BOUND, NUMBER, CHANGE = "u_type_a", "u_type_b", "cramer_rao", "n_for_10_percent", "change"
RATIO, LEAST = "u_over_reference", "least_bound_over_reference"


@dataclass(frozen=True)
class PlannedRow:
    """One number of a plan; the fields are columns of ``tables/planned.csv``."""

    design: str
    """Profile and peak velocity of the command, or a best pulse, or a filter (no unit)."""
    pathway: str
    """Estimator, as of ``tepsipe plan`` (no unit)."""
    quantity: str
    """I, B or K (no unit)."""
    measure: str
    """u_type_a, u_type_b, cramer_rao (``unit``), n_for_10_percent (-), u_over_reference: Type A over that
    of the thesis's pulse, least_bound_over_reference: smallest Cramer-Rao bound of any pulse over that of
    the best one (-), change by a filter without noise (%)."""
    unit: str
    """Unit of the value."""
    value: float | None
    """The number; None where no number of perturbations is enough."""


PLANNED_ROWS = Table(PlannedRow, "planned uncertainties")


def plan_of_thesis(leg: Leg, foot: Foot, joint: Joint, sources: dict[str, Source]) -> list[PlannedRow]:
    """Plan the thesis's experiments on the dummy: 14 perturbations of 100 ms every 4 s.

    Returns: uncertainties, best pulses and filters (units in the rows).
    """
    rows = []
    for profile, amplitude, pathway in DESIGNS:
        protocol = Protocol(
            pulse=pulse_of(profile, amplitude, 0.1), rest_before_s=6.0, rest_after_s=8.0, pathway=pathway
        )
        plan = plan_experiment(
            Design(joint=joint, leg=leg, foot=foot, rig=Rig(), protocol=protocol, sources=sources)
        )
        rows += _of_design(f"{profile}-{amplitude:g}", plan)
    return rows + _best(plan) + _filters(plan)


def _of_design(name: str, plan: Plan) -> list[PlannedRow]:
    rows, pathway = [], plan.design.protocol.pathway
    for k, quantity in enumerate(PARAMETERS):
        head, unit = (name, pathway, quantity), UNITS[quantity]
        rows.append(PlannedRow(*head, TYPE_A, unit, float(plan.type_a[k])))
        rows.append(PlannedRow(*head, TYPE_B, unit, float(plan.type_b[k])))
        if plan.bound is not None:
            rows.append(PlannedRow(*head, BOUND, unit, float(plan.bound[k])))
        number = plan.number_for(0.1, quantity)
        rows.append(PlannedRow(*head, NUMBER, "1", None if number is None else float(number)))
    return rows


def _best(plan: Plan) -> list[PlannedRow]:
    """Best pulses within the peaks of the last design's, beside it."""
    peaks, rows = peaks_of(plan.motion.pulse_velocity), []
    for name, one_way in (("best, belt returns", False), ("best, one way", True)):
        best = best_of(plan, peaks, one_way)
        head = (name, plan.design.protocol.pathway, "K")
        rows.append(PlannedRow(*head, RATIO, "1", float(best.plan.type_a[2] / plan.type_a[2])))
        least = best.found.least_standard_error / best.found.standard_error
        rows.append(PlannedRow(*head, LEAST, "1", float(least)))
    return rows


def _filters(plan: Plan) -> list[PlannedRow]:
    """Change of I, B, K by filters of 20 Hz and fourth order, without noise."""
    design = replace(plan.design, protocol=replace(plan.design.protocol, pathway=LEG), sources={})
    rows = []
    for name, (zero_lag, of_torque, of_motion) in FILTERS.items():
        lowpass = Lowpass(20.0, 4, zero_lag)
        bias = mismatch_bias(
            design, plan.motion, lowpass if of_torque else None, lowpass if of_motion else None
        )
        share = 100.0 * bias / design.parameters
        rows += [
            PlannedRow(name, LEG, quantity, CHANGE, "%", float(share[k]))
            for k, quantity in enumerate(PARAMETERS)
        ]
    return rows


def planned_value(
    rows: Iterable[PlannedRow], design: str, measure: str, quantity: str = "K", pathway: str = LEG
):
    """Value of a row (its unit)."""
    for row in rows:
        if (row.design, row.measure, row.quantity, row.pathway) == (design, measure, quantity, pathway):
            return row.value
    raise KeyError((design, measure, quantity, pathway))
