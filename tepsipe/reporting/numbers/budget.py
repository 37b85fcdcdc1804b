"""Numbers of the uncertainty budgets, and what they say of a laboratory."""

from collections.abc import Sequence

import numpy as np

from tepsipe.io.budget_table import SCATTER, Contribution
from tepsipe.io.estimates import Estimate
from tepsipe.reporting.budgets import RelativeBudget, budgeted, relative_budgets, source_words
from tepsipe.reporting.figures.names import words
from tepsipe.reporting.numbers.format import number, span
from tepsipe.statistics.uncertainty import coverage_factor

# stiffness before damping, as the report discusses them
SHOWN = ("K", "B", "mass")
MORE = 4  # times as many perturbations, in the sentence on repetition


def budgets_data(
    contributions: Sequence[Contribution], estimates: Sequence[Estimate], foot_pathway: str | None
) -> dict:
    """Budgets of the report as text.

    Parameters
    ----------
    contributions : sequence of Contribution
        All rows of the budgets (units in them).
    estimates : sequence of Estimate
        All estimates (units in them).
    foot_pathway : str or None
        Pathway from the foot whose budget is shown.

    Returns
    -------
    dict
        Name of the budget, an experiment or foot -> its pathway, estimator and quantities; without those that
        have none.
    """
    found = {}
    for name, own in budgeted(estimates, foot_pathway).items():
        budgets = relative_budgets(contributions, own, SHOWN)
        if budgets:
            found[name] = {
                "pathway": own[0].pathway,
                "estimator": words(own[0].estimator),
                "sources": list(dict.fromkeys(s for b in budgets.values() for s in b.percent)),
                "trials": str(max(len(b.conditions) for b in budgets.values())),
                "quantities": [_quantity(b, [e for e in own if e.quantity == q]) for q, b in budgets.items()],
            }
    return found


def _quantity(budget: RelativeBudget, estimates: list[Estimate]) -> dict:
    half = [
        50.0 * (e.ci_high - e.ci_low) / abs(e.value)
        for e in estimates
        if e.condition in budget.conditions and e.ci_low is not None and e.ci_high is not None
    ]
    return {
        "quantity": budget.quantity,
        "type_a": span(budget.type_a, 2),
        "type_b": span(budget.type_b, 2),
        "expanded": span(half, 2),
    } | largest_source(budget)


def largest_source(budget: RelativeBudget) -> dict:
    """What to say of the largest source: its name, its size (%), and what repetition would leave (%).

    ``repeating`` is whether it is Type A, which more perturbations reduce. ``after`` is the 95 % half width
    that is left after `MORE` times as many perturbations if it does, after any number of them if not.
    """
    factor = float(coverage_factor(np.array(np.inf)))
    repeating = budget.largest == SCATTER
    a, b = float(np.median(budget.type_a)), float(np.median(budget.type_b))
    after = factor * np.hypot(a / np.sqrt(MORE), b) if repeating else budget.least_expanded
    return {
        "largest": source_words(budget.largest),
        "size": number(float(np.nanmedian(budget.percent[budget.largest])), 2),
        "repeating": repeating,
        "more": str(MORE),
        "now": number(factor * float(np.hypot(a, b)), 2),
        "after": number(float(after), 2),
    }
