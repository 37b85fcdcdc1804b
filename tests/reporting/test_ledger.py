"""A verdict for every printed cell: hand-made numbers give each of them."""

import itertools
from dataclasses import replace

import numpy as np
import pytest

from tepsipe.errors import InputError
from tepsipe.reporting.ledger import (
    CELL_VERDICTS,
    CONSISTENT,
    EXPLAINED,
    FITTED,
    IMPLIED,
    INTERPRETATION,
    NOT_COMPUTED,
    NOT_REPRODUCED,
    PREDICTED,
    UNKNOWN,
    Explanations,
    Tolerance,
    best_sem_reading,
    cells_of_table,
    explanations_of,
    ledger,
    noise_cells,
    null_cells,
    printed_cells,
    sem_distances,
    tolerances_of,
    with_sem_reading,
)
from tepsipe.reporting.thesis_tables import TableRow
from workflow.support.yaml_file import read_settings

KEY = ("table_4_2", "K", "sine-0.1")


BASES = {"joint": "a joint", "none": "nothing"}


def one(value, printed=10.0, explained=None, recorded=(), null=None, **tolerance):
    """Verdict and reason of one cell, and the verdict on its null model."""
    entry = {"tables": ["table_4_2"], "rows": ["K"], "reason": "rounding"}
    entry |= {"verdict": FITTED, "used": "joint"} | tolerance
    reported = {"table_4_2": {"K": {"sine-0.1": printed}}}
    values = {} if value is None else {KEY: value}
    reasons = Explanations() if explained is None else Explanations({KEY: explained}, {KEY: "because"})
    nulls = {} if null is None else {KEY: null}
    (row,) = ledger(reported, tolerances_of([entry], BASES), values, reasons, nulls, set(recorded))
    return row.verdict, row.reason, row.null_verdict


@pytest.mark.parametrize(
    ("value", "tolerance", "verdict"),
    [
        (10.5, {"absolute": 0.5}, FITTED),
        (10.5, {"absolute": 0.5, "verdict": INTERPRETATION}, INTERPRETATION),
        (10.5, {"absolute": 0.5, "verdict": UNKNOWN}, UNKNOWN),
        (99.0, {"absolute": 0.5, "verdict": UNKNOWN}, UNKNOWN),
        (10.5, {"absolute": 0.5, "verdict": PREDICTED}, PREDICTED),
        (10.6, {"absolute": 0.5, "verdict": FITTED}, NOT_REPRODUCED),
        (9.0, {"share": 0.1}, FITTED),
        (8.9, {"share": 0.1}, NOT_REPRODUCED),
        (20.0, {"factor": 2}, FITTED),
        (4.9, {"factor": 2}, NOT_REPRODUCED),
        (-10.0, {"factor": 2}, NOT_REPRODUCED),
        (None, {"factor": 2}, NOT_COMPUTED),
        (float("nan"), {"factor": 2}, NOT_COMPUTED),
    ],
)
def test_verdict_follows_from_value_and_tolerance(value, tolerance, verdict):
    assert one(value, **tolerance)[0] == verdict


def test_unexplained_part_of_a_vaf_counts_with_the_rounding_of_the_print():
    near = Tolerance((), (), "", unexplained_factor=3.0)
    assert near.limits(99.94) == pytest.approx((100.0 - 3.0 * 0.065, 100.0 - 0.055 / 3.0))
    assert near.holds(99.94, 99.81)
    assert not near.holds(99.94, 99.80)
    assert not near.holds(99.94, 99.99)
    whole = Tolerance((), (), "", unexplained_factor=3.0, digit=1.0)
    assert whole.holds(96.0, 97.0)
    assert not whole.holds(96.0, 99.0)


def test_printed_zero_has_a_tolerance_of_its_own():
    assert one(4e-5, 0.0, factor=2, zero=5e-5)[0] == FITTED
    assert one(6e-5, 0.0, factor=2, zero=5e-5)[0] == NOT_REPRODUCED
    assert one(1e-12, 0.0, factor=2)[0] == NOT_REPRODUCED


def test_tolerance_in_words_is_the_one_of_the_printed_number():
    sem = Tolerance((), (), "", factor=1.5, zero=5e-5)
    assert (sem.text(0.0), sem.text(8e-4)) == ("5e-05", "factor 1.5")
    assert "factor 3 in 100 - VAF" in Tolerance((), (), "", unexplained_factor=3.0).text(99.94)


def test_explanation_counts_only_with_a_number_that_agrees():
    verdict, reason, _ = one(5.0, explained=10.2, absolute=0.5)
    assert (verdict, reason) == (EXPLAINED, "because, 10.2; used: a joint")
    verdict, reason, _ = one(5.0, explained=11.0, absolute=0.5)
    assert verdict == NOT_REPRODUCED
    assert "11" in reason
    # a number that agrees needs none
    assert one(10.0, explained=10.2, absolute=0.5)[0] == FITTED
    assert one(None, explained=10.2, absolute=0.5)[0] == NOT_COMPUTED


def test_misprint_is_compared_as_it_was_meant():
    """A printed 0.614 is ten times 0.0614, whose tolerance is that of 0.061: the verdict can fail."""
    key, slip = (
        ("table_4_2", "I", "a"),
        {"table": "table_4_2", "quantity": "I", "condition": "a", "meant": 0.061},
    )
    entry = {"tables": ["table_4_2"], "rows": ["I"], "reason": "r", "verdict": FITTED, "used": "joint"}
    tolerances = tolerances_of([entry | {"absolute": 6e-4}], BASES)
    for value, verdict in ((0.0617, FITTED), (0.0622, NOT_REPRODUCED)):
        reasons = explanations_of({key: value}, [slip], {})
        (row,) = ledger({"table_4_2": {"I": {"a": 0.614}}}, tolerances, {key: value}, reasons, {key: 0.061})
        # the null model is compared with what was meant, too
        assert (row.reported, row.verdict, row.null_verdict) == (0.614, verdict, IMPLIED)


def test_recorded_trial_is_not_fitted():
    verdict, reason, _ = one(10.0, absolute=0.5, recorded=["sine-0.1"])
    assert verdict == PREDICTED and "to which no constant was fitted" in reason
    assert one(10.0, absolute=0.5, recorded=["sine-0.2"])[0] == FITTED
    assert one(10.0, absolute=0.5, recorded=["sine-0.1"], verdict=UNKNOWN)[0] == UNKNOWN


def test_text_of_a_verdict_names_its_reason_and_what_was_used():
    assert one(10.0, absolute=0.5, outside="known")[1] == "rounding; used: a joint"
    assert one(20.0, absolute=0.5, outside="known")[1] == "known; used: a joint"
    with pytest.raises(InputError, match="used: expected one of joint, none, found 'rubber'"):
        one(10.0, absolute=0.5, used="rubber")


@pytest.mark.parametrize(
    ("null", "found", "says"),
    [(10.4, IMPLIED, True), (10.6, NOT_REPRODUCED, False), (None, NOT_COMPUTED, False)],
)
def test_cell_that_its_null_model_passes_says_that_it_cannot_discriminate(null, found, says):
    for value, verdict in ((10.1, FITTED), (12.0, NOT_REPRODUCED)):
        own, reason, null_verdict = one(value, null=null, absolute=0.5)
        assert (own, null_verdict) == (verdict, found)
        assert ("cannot discriminate" in reason) is says


def test_null_models_use_printed_numbers_only():
    reported = {
        "table_4_2": {"K": {"sine-0.1": 6.0, "sine-0.5": 5.0}, "I": {"sine-0.1": 0.061, "sine-0.5": 0.614}},
        "table_4_3": {"K": {"minjerk-0.1": 6.6, "minjerk-0.5": 4.8}},
        "table_4_4": {"K": {"none": 10.0, "tau": 3.0, "theta": 1.0}},
    }
    slips = [{"table": "table_4_2", "quantity": "I", "condition": "sine-0.5", "meant": 0.061}]
    entry = {"reason": "r", "verdict": FITTED, "used": "joint", "absolute": 1.0}
    entries = [entry | {"tables": ["table_4_2"], "rows": ["K", "I"]}]
    entries += [entry | {"tables": ["table_4_3"], "rows": ["K"], "null_model": "table_4_2"}]
    entries += [entry | {"tables": ["table_4_4"], "rows": ["K"]}]
    found = null_cells(reported, tolerances_of(entries, BASES), slips)
    assert found["table_4_2", "K", "sine-0.1"] == found["table_4_2", "K", "sine-0.5"] == 5.5
    assert found["table_4_2", "I", "sine-0.5"] == pytest.approx(0.061)  # a misprint is no number of the null
    assert (found["table_4_3", "K", "minjerk-0.1"], found["table_4_3", "K", "minjerk-0.5"]) == (6.0, 5.0)
    # without noise the simulated joint is known; with noise the mean of the noisy columns
    assert [found["table_4_4", "K", column] for column in ("none", "tau", "theta")] == [10.0, 2.0, 2.0]
    assert printed_cells(reported, slips)["table_4_2", "I", "sine-0.5"] == 0.061


@pytest.mark.parametrize("tolerance", [{}, {"absolute": 1.0, "share": 0.1}])
def test_entry_needs_one_tolerance(tolerance):
    with pytest.raises(InputError, match="expected one of absolute, share, factor"):
        one(10.0, **tolerance)


def test_row_without_a_tolerance_or_with_two_is_refused():
    entry = {"tables": ["table_4_2"], "rows": ["K"], "reason": "r", "absolute": 1.0}
    entry |= {"verdict": FITTED, "used": "joint"}
    with pytest.raises(InputError, match="one tolerance for K of table_4_2, found two"):
        tolerances_of([entry, entry], BASES)
    with pytest.raises(InputError, match="a tolerance for I of table_4_2, found none"):
        ledger({"table_4_2": {"I": {"sine-0.1": 0.061}}}, tolerances_of([entry], BASES), {}, Explanations())


def noise_rows():
    """Both readings of Table 4-4, and another stiffness."""

    def row(reading, quantity, values, stiffness="K = 10 Nm/rad"):
        return TableRow(reading, stiffness, quantity, "", values, [None] * 4)

    return [
        row("as-printed", "I", [0.04, 0.04, 0.05, 0.04]),
        row("as-tabulated", "I", [0.039, 0.039, 0.040, 0.041]),
        row("as-tabulated", "SEM_count_I", [6e-4, 9e-4, 5e-4, None]),
        row("as-tabulated", "I", [0.1, 0.1, 0.1, 0.1], "K = 15 Nm/rad"),
        row("recommended-regression", "I", [0.015, 0.015, 0.015, 0.015]),
    ]


def test_table_4_4_is_read_by_one_reading_and_its_first_stiffness():
    found = noise_cells(noise_rows(), "as-tabulated")
    assert found["table_4_4", "I", "both"] == 0.041
    assert found["table_4_4", "SEM_count_I", "tau"] == 9e-4
    assert ("table_4_4", "SEM_count_I", "both") not in found
    assert noise_cells([], "as-tabulated") == {}


def test_misprint_is_listed_and_column_without_noise_is_explained_by_numbers():
    values = {("table_4_2", "I", "sine-0.3"): 0.0611}
    slip = {"table": "table_4_2", "quantity": "I", "condition": "sine-0.3", "printed": 0.614, "meant": 0.061}
    consistent = noise_cells(noise_rows(), CONSISTENT)
    found = explanations_of(values, [slip, slip | {"condition": "sine-0.4"}], consistent)
    assert found.misprints == {("table_4_2", "I", "sine-0.3"): 10.0}
    assert found.values == {("table_4_4", "I", "none"): 0.015}
    assert set(found.texts) == set(found.values)


def test_sems_are_compared_by_the_reading_that_is_nearest_over_all_tables():
    printed = {"table_4_1": {"SEM_K": {"a": 8.0}}, "table_4_2": {"SEM_K": {"b": 0.2, "c": 0.4, "d": 0.0}}}

    def run(norm, count):
        """SEMs of the run: a factor of each reading, one for each table."""
        return {
            (table, f"SEM_{reading}_K", column): factor * (number or 1.0)
            for reading, factors in (("norm", norm), ("count", count))
            for (table, rows), factor in zip(printed.items(), factors, strict=True)
            for column, number in rows["SEM_K"].items()
        } | {("table_4_2", "K", "b"): 6.0}

    # the norm fits Table 4-1, the number of residuals the two cells of Table 4-2; a printed 0 has no ratio
    values = run(norm=(1.1, 20.0), count=(0.5, 1.1))
    distances = sem_distances(values, printed)
    of = {(one.reading, one.table): one for one in distances}
    assert set(of) == {(r, t) for r in ("norm", "count") for t in ("table_4_1", "table_4_2", "all")}
    assert of["norm", "table_4_1"].rms_log_ratio == pytest.approx(np.log(1.1))
    assert of["norm", "all"].cells == 3
    assert of["norm", "all"].rms_log_ratio == pytest.approx(
        np.sqrt((np.log(1.1) ** 2 + 2.0 * np.log(20.0) ** 2) / 3.0)
    )
    assert of["count", "all"].median_ratio == pytest.approx(1.1)
    assert best_sem_reading(distances) == "count"
    assert best_sem_reading(sem_distances(run(norm=(1.1, 1.1), count=(0.5, 1.1)), printed)) == "norm"
    assert best_sem_reading(sem_distances({}, printed)) == "count"
    cells = with_sem_reading(values, "norm")
    assert cells["table_4_2", "SEM_K", "b"] == pytest.approx(4.0)
    assert cells["table_4_2", "K", "b"] == 6.0
    assert {row for _, row, _ in cells} == {"K", "SEM_K"}


def test_numbers_come_from_the_block_as_printed():
    rows = [
        TableRow("leg-thesis", "e", "K", "Nm/rad", [6.0, None], [None, None]),
        TableRow("leg-thesis", "e", "SEM_K", "Nm/rad", [0.3, 0.2], [None, None]),
        TableRow("leg", "e", "K", "Nm/rad", [10.0, 10.0], [None, None]),
    ]
    found = cells_of_table("table_4_2", rows, ["a", "b"])
    assert found == {
        ("table_4_2", "K", "a"): 6.0,
        ("table_4_2", "SEM_K", "a"): 0.3,
        ("table_4_2", "SEM_K", "b"): 0.2,
    }


@pytest.fixture(scope="module")
def shipped(root):
    """Reported values of the shipped study, and its tolerances."""
    reported = read_settings(root / "config/reported.yaml")
    return reported, tolerances_of(reported["cells"], reported["bases"])


def test_every_printed_cell_has_a_tolerance_that_can_fail(shipped, tmp_path):
    reported, tolerances = shipped
    nulls = null_cells(reported["tables"], tolerances, reported["slips"])
    rows = ledger(reported["tables"], tolerances, {}, Explanations(), nulls)
    assert len(rows) == len(nulls) == 182
    assert {row.verdict for row in rows} == {NOT_COMPUTED}
    for row in rows:
        low, high = tolerances[row.table, row.row].limits(row.reported)
        assert np.isfinite([low, high]).all(), row
        # three times the printed number is none that agrees, nor its negative
        if row.row in ("I", "K") or row.row.startswith(("SEM", "error")) or row.table == "table_4_1":
            wrong = 3.0 * row.reported + (row.reported == 0.0)
            assert not low <= wrong <= high or abs(row.reported) < 0.1, row
    assert {key[0] for key in tolerances} == set(reported["tables"])
    # printed K falls with amplitude, which no constant can follow: there a null model fails
    assert not any(r.null_verdict == IMPLIED for r in rows if (r.table, r.row) == ("table_4_2", "K"))
    # numbers that do not differ between columns cannot discriminate
    assert all(r.null_verdict == IMPLIED for r in rows if (r.table, r.row) == ("table_4_1", "I"))
    CELL_VERDICTS.write(tmp_path / "cells.csv", rows)
    read = CELL_VERDICTS.read(tmp_path / "cells.csv")
    assert [replace(row, null_value=None) for row in read] == [replace(row, null_value=None) for row in rows]
    assert [row.null_value for row in read] == pytest.approx([row.null_value for row in rows])


def test_tolerances_follow_from_the_printed_numbers(shipped):
    """The rule: half the last digit and one printed SEM; scatter between cells that should agree."""
    reported, tolerances = shipped
    sine, minjerk = (reported["tables"][table] for table in ("table_4_2", "table_4_3"))
    for quantity, half_digit in (("I", 5e-4), ("B", 5e-4), ("K", 5e-4)):
        printed = [*sine[f"SEM_{quantity}"].values(), *minjerk[f"SEM_{quantity}"].values()]
        rule = half_digit + np.median(printed)
        for table in reported["tables"]:
            assert tolerances[table, quantity].absolute == pytest.approx(rule, rel=0.05)
    ratios = [
        np.exp(abs(np.log(b / a)))
        for q in ("SEM_I", "SEM_B", "SEM_K")
        for a, b in zip(sine[q].values(), minjerk[q].values(), strict=True)
    ]
    factors = {t.factor for (_, row), t in tolerances.items() if row.startswith("SEM")}
    assert factors == {round(float(np.median(ratios)), 1)}
    unexplained = [[100.0 - v for v in list(t["VAF_trial"].values())[2:]] for t in (sine, minjerk)]
    widest = max(max(own) / min(own) for own in unexplained)
    assert {t.unexplained_factor for (_, row), t in tolerances.items() if t.unexplained_factor} == {
        round(widest, 1)
    }
    errors = list(reported["tables"]["table_4_1"]["error"].values())
    steps = [b / a for a, b in itertools.pairwise(errors)]
    assert tolerances["table_4_1", "error"].factor == round(max(steps), 1)


def test_classes_of_cells_say_what_the_numbers_rest_on(shipped):
    _, tolerances = shipped
    classes = {key: t.verdict for key, t in tolerances.items()}
    # the inverse problem fits I, B, K and the VAF of the full dataset of both tables
    assert {classes[table, "VAF_trial"] for table in ("table_4_2", "table_4_3")} == {FITTED}
    for table in ("table_4_1", "table_4_2", "table_4_3"):
        assert {classes[table, row] for row in ("I", "B", "K")} == {FITTED}
    assert {v for (table, _), v in classes.items() if table == "table_4_4"} == {INTERPRETATION}
    sems = {
        table: {v for (t, row), v in classes.items() if t == table and row[:3] == "SEM"}
        for table, _ in classes
    }
    assert sems["table_4_1"] == {UNKNOWN} and sems["table_4_2"] == sems["table_4_3"] == {INTERPRETATION}


def test_damaged_verdicts_are_refused(tmp_path):
    path = tmp_path / "cells.csv"
    path.write_text(
        "table,row,column,reported,value,tolerance,verdict,reason,null_value,null_verdict\n"
        "table_4_2,K,a,1,1,0.1,perhaps,r,1,implied\n"
    )
    with pytest.raises(InputError, match="verdicts of printed cells"):
        CELL_VERDICTS.read(path)
