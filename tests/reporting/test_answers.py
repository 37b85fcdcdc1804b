"""Answers of a study: which estimate answers, what is compared with it, and the verdicts."""

import pytest

from tepsipe.io.estimates import FLAGS, Estimate
from tepsipe.reporting.answers import ANSWERS, answers

ASKED = {"standing": {"conditions": ["relax"], "ways": [["compensated", "gls"]]}}


def estimate(estimator="gls", pathway="compensated", condition="relax", quantity="K", **changed):
    return Estimate("standing", condition, pathway, estimator, quantity, "Nm/rad", 300.0, **changed)


def verdicts(*rows):
    found = answers(rows, ASKED)
    return [(row.pathway, row.estimator, row.quantity, row.verdict) for row in found]


def test_recommended_estimate_answers_and_others_are_compared_with_it():
    rows = [
        estimate("window"),
        estimate(recommended=True),
        estimate("window", "raw"),
        estimate("other", "raw"),  # a pathway with two estimators
        estimate("once", "joint"),
        estimate(condition="relax-1"),  # a trial, whose task has the answer
        estimate(quantity="rotation"),
    ]
    assert verdicts(*rows) == [
        ("compensated", "gls", "K", "quotable"),
        ("compensated", "window", "K", "for comparison"),
        ("joint", "once", "K", "for comparison"),
    ]


def test_failed_checks_are_told_with_what_to_do():
    (row,) = answers([estimate(recommended=True, flags="negative;uncompensated")], ASKED)
    assert (row.verdict, row.flags) == ("check first", "negative;uncompensated")
    assert row.reasons.startswith("B or K is negative, which no joint has; no weight was recorded")
    assert row.to_do.startswith("Check signs, clocks and delays of the recording. Record the empty belt")


def test_pathway_for_comparison_only_has_its_reason():
    rows = [estimate(recommended=True), estimate("once", "ankle", flags="negative")]
    _, row = answers(rows, ASKED)
    assert row.reasons.endswith("which no joint has; the belt-induced load is not subtracted")
    # it is no reason of an answer
    (row,) = answers([estimate("once", "ankle", recommended=True)], ASKED)
    assert row.reasons == ""


def test_without_a_recommended_estimate_the_usual_one_is_not_quotable():
    rows = [estimate("window"), estimate(flags="uncompensated")]
    assert verdicts(*rows)[0] == ("compensated", "gls", "K", "not quotable")
    # of a quantity alone, by the way of the recommended one
    rows = [estimate("fit", recommended=True), estimate("fit", quantity="B"), estimate(quantity="B")]
    assert ("compensated", "fit", "B", "not quotable") in verdicts(*rows)
    assert ("compensated", "gls", "B", "for comparison") in verdicts(*rows)


@pytest.mark.parametrize("flag", FLAGS)
def test_every_check_has_a_meaning_and_an_advice(flag):
    (row,) = answers([estimate(recommended=True, flags=flag)], ASKED)
    assert row.reasons and row.to_do.endswith(".") and not row.to_do.endswith("..")


def test_answers_are_read_as_written(tmp_path):
    rows = answers([estimate(recommended=True, ci_low=250.0, ci_high=350.0)], ASKED)
    ANSWERS.write(tmp_path / "answers.csv", rows)
    assert ANSWERS.read(tmp_path / "answers.csv") == rows
