"""Sentences on the joint likelihood are chosen by the run's numbers, also where checks fail."""

import pandas as pd
import pytest

from tepsipe.reporting.numbers.joint_likelihood import joint_likelihood_data

PATHWAY = "leg-joint-likelihood"


def estimates(softened_low, flags):
    rows = []
    for condition, flag in flags.items():
        for quantity, value in (("I", 0.007), ("B", 0.03), ("K", 9.6), ("B_small", 0.02), ("K_small", 10.3)):
            own = flag if quantity == "K" else ""
            rows.append((PATHWAY, condition, quantity, value, value - 0.1, 0.01, own))
        rows.append((PATHWAY, condition, "delay", -2e-5, -3e-5, 1e-6, ""))
        rows.append((PATHWAY, condition, "K_softened", softened_low + 1.0, softened_low, 0.1, ""))
    columns = ["pathway", "condition", "quantity", "value", "ci_low", "u_type_a", "flags"]
    return pd.DataFrame(rows, columns=columns)


def recovered(covered):
    rows = [("dummy", PATHWAY, q, error, covered) for q, error in (("I", 0.2), ("B", -0.05), ("K", 0.01))]
    return pd.DataFrame(rows, columns=["experiment", "pathway", "quantity", "relative_error", "covered"])


@pytest.mark.parametrize(("low", "softens"), [(0.5, "2"), (-0.5, "0")])
def test_softening_is_counted_from_its_interval(low, softens):
    data = joint_likelihood_data(PATHWAY, estimates(low, {"a": "", "b": ""}), None)
    assert (data["softens"], data["total"], data["recovery"]) == (softens, "2", None)
    assert data["flags"] == []
    assert data["delay_ms"] == "0.02"


def test_failed_checks_and_missed_truths_are_named():
    flags = {"a": "markers-slip;lack-of-fit", "b": "lack-of-fit"}
    data = joint_likelihood_data(PATHWAY, estimates(0.5, flags), recovered("false"))
    assert data["flags"] == [
        {"name": "markers-slip", "conditions": "a"},
        {"name": "lack-of-fit", "conditions": "a, b"},
    ]
    assert (data["recovery"]["covered"], data["recovery"]["total"]) == ("0", "3")
    assert data["recovery"]["worst_damping"].startswith("5")
