"""A verdict for every printed cell: hand-made numbers give each of them."""

import numpy as np
import pytest

from tepsipe.errors import InputError
from tepsipe.io.result import Result
from tepsipe.reporting.ledger import (
    CELL_VERDICTS,
    EXPLAINED,
    FITTED,
    NOT_COMPUTED,
    NOT_REPRODUCED,
    PREDICTED,
    REPRODUCED,
    Explanations,
    Tolerance,
    cells_of_table,
    explanations_of,
    ledger,
    noise_cells,
    ordinary_errors,
    tolerances_of,
)
from tepsipe.reporting.thesis_tables import TableRow
from workflow.support.yaml_file import read_settings

KEY = ("table_4_2", "K", "sine-0.1")


def one(value, printed=10.0, explained=None, recorded=(), **tolerance):
    """Verdict and reason of one cell."""
    entry = {"tables": ["table_4_2"], "rows": ["K"], "reason": "rounding"} | tolerance
    reported = {"table_4_2": {"K": {"sine-0.1": printed}}}
    values = {} if value is None else {KEY: value}
    reasons = Explanations() if explained is None else Explanations({KEY: explained}, {KEY: "because"})
    (row,) = ledger(reported, tolerances_of([entry]), values, reasons, set(recorded))
    return row.verdict, row.reason


@pytest.mark.parametrize(
    ("value", "tolerance", "verdict"),
    [
        (10.5, {"absolute": 0.5}, REPRODUCED),
        (10.5, {"absolute": 0.5, "verdict": FITTED}, FITTED),
        (10.5, {"absolute": 0.5, "verdict": PREDICTED}, PREDICTED),
        (10.6, {"absolute": 0.5, "verdict": FITTED}, NOT_REPRODUCED),
        (9.0, {"share": 0.1}, REPRODUCED),
        (8.9, {"share": 0.1}, NOT_REPRODUCED),
        (20.0, {"factor": 2}, REPRODUCED),
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
    assert one(4e-5, 0.0, factor=2, zero=5e-5)[0] == REPRODUCED
    assert one(6e-5, 0.0, factor=2, zero=5e-5)[0] == NOT_REPRODUCED
    assert one(1e-12, 0.0, factor=2)[0] == NOT_REPRODUCED


def test_explanation_counts_only_with_a_number_that_agrees():
    assert one(5.0, explained=10.2, absolute=0.5) == (EXPLAINED, "because, 10.2")
    verdict, reason = one(5.0, explained=11.0, absolute=0.5)
    assert verdict == NOT_REPRODUCED
    assert "11" in reason
    # a number that agrees needs none
    assert one(10.0, explained=10.2, absolute=0.5)[0] == REPRODUCED
    assert one(None, explained=10.2, absolute=0.5)[0] == NOT_COMPUTED


def test_recorded_trial_is_neither_fitted_nor_predicted():
    assert one(10.0, absolute=0.5, verdict=FITTED, recorded=["sine-0.1"])[0] == REPRODUCED
    assert one(10.0, absolute=0.5, verdict=FITTED, recorded=["sine-0.2"])[0] == FITTED


def test_reason_of_a_cell_is_that_of_its_verdict():
    assert one(10.0, absolute=0.5, outside="known")[1] == "rounding"
    assert one(20.0, absolute=0.5, outside="known")[1] == "known"


@pytest.mark.parametrize("tolerance", [{}, {"absolute": 1.0, "share": 0.1}])
def test_entry_needs_one_tolerance(tolerance):
    with pytest.raises(InputError, match="expected one of absolute, share, factor"):
        one(10.0, **tolerance)


def test_row_without_a_tolerance_or_with_two_is_refused():
    entry = {"tables": ["table_4_2"], "rows": ["K"], "reason": "r", "absolute": 1.0}
    with pytest.raises(InputError, match="one tolerance for K of table_4_2, found two"):
        tolerances_of([entry, entry])
    with pytest.raises(InputError, match="a tolerance for I of table_4_2, found none"):
        ledger({"table_4_2": {"I": {"sine-0.1": 0.061}}}, tolerances_of([entry]), {}, Explanations())


def noise_rows():
    """Both readings of Table 4-4, and another stiffness."""

    def row(reading, quantity, values, stiffness="K = 10 Nm/rad"):
        return TableRow(reading, stiffness, quantity, "", values, [None] * 4)

    return [
        row("as-printed", "I", [0.04, 0.04, 0.05, 0.04]),
        row("as-tabulated", "I", [0.039, 0.039, 0.040, 0.041]),
        row("as-tabulated", "SEM_I", [9.0, 9.0, 9.0, 9.0]),
        row("as-tabulated", "SE_I", [6e-4, 9e-4, 5e-4, None]),
        row("as-tabulated", "I", [0.1, 0.1, 0.1, 0.1], "K = 15 Nm/rad"),
        row("recommended-regression", "I", [0.015, 0.015, 0.015, 0.015]),
    ]


def test_table_4_4_is_read_by_one_reading_with_ordinary_standard_errors():
    found = noise_cells(noise_rows(), "as-tabulated")
    assert found["table_4_4", "I", "both"] == 0.041
    assert found["table_4_4", "SEM_I", "tau"] == 9e-4
    assert ("table_4_4", "SEM_I", "both") not in found
    assert noise_cells([], "as-tabulated") == {}


def test_misprint_and_column_without_noise_are_explained_by_numbers():
    values = {("table_4_2", "I", "sine-0.3"): 0.0611}
    slip = {"table": "table_4_2", "quantity": "I", "condition": "sine-0.3", "printed": 0.614, "meant": 0.061}
    found = explanations_of(values, [slip, slip | {"condition": "sine-0.4"}], noise_rows())
    assert found.values == {
        ("table_4_2", "I", "sine-0.3"): pytest.approx(0.611),
        ("table_4_4", "I", "none"): 0.015,
    }
    assert set(found.texts) == set(found.values)


def test_numbers_come_from_the_block_as_printed_and_from_the_fits():
    rows = [
        TableRow("leg-thesis", "e", "K", "Nm/rad", [6.0, None], [None, None]),
        TableRow("leg-thesis", "e", "SEM_K", "as printed", [9.0, 9.0], [None, None]),
        TableRow("leg", "e", "K", "Nm/rad", [10.0, 10.0], [None, None]),
    ]
    assert ("table_4_1", "SEM_K", "b") in cells_of_table("table_4_1", rows, ["a", "b"])
    assert cells_of_table("table_4_2", rows, ["a", "b"]) == {("table_4_2", "K", "a"): 6.0}
    errors = np.array([[1e-4, 4e-3, 0.2], [3e-4, 6e-3, 0.4]])
    fits = {"a": Result({"leg-thesis/standard_errors": errors}, {}, {}), "b": Result({}, {}, {})}
    found = ordinary_errors("table_4_2", fits, "leg-thesis")
    assert found == {
        ("table_4_2", "SEM_I", "a"): pytest.approx(2e-4),
        ("table_4_2", "SEM_B", "a"): pytest.approx(5e-3),
        ("table_4_2", "SEM_K", "a"): pytest.approx(0.3),
    }


def test_every_printed_cell_has_a_tolerance_that_can_fail(root, tmp_path):
    reported = read_settings(root / "config/reported.yaml")
    tolerances = tolerances_of(reported["cells"])
    rows = ledger(reported["tables"], tolerances, {}, Explanations())
    assert len(rows) == 182
    assert {row.verdict for row in rows} == {NOT_COMPUTED}
    for row in rows:
        low, high = tolerances[row.table, row.row].limits(row.reported)
        assert np.isfinite([low, high]).all(), row
        # three times the printed number is none that agrees, nor its negative
        if row.row in ("I", "K") or row.row.startswith(("SEM", "error")) or row.table == "table_4_1":
            wrong = 3.0 * row.reported + (row.reported == 0.0)
            assert not low <= wrong <= high or abs(row.reported) < 0.1, row
    assert {key[0] for key in tolerances} == set(reported["tables"])
    CELL_VERDICTS.write(tmp_path / "cells.csv", rows)
    assert CELL_VERDICTS.read(tmp_path / "cells.csv") == rows


def test_only_numbers_that_the_fit_used_count_as_fitted(root):
    tolerances = tolerances_of(read_settings(root / "config/reported.yaml")["cells"])
    for printed in ("table_4_2", "table_4_3"):
        roles = {row: t.verdict for (table, row), t in tolerances.items() if table == printed}
        assert {row for row, role in roles.items() if role == FITTED} == {"I", "B", "K", "VAF_trial"}
        assert set(roles.values()) == {FITTED, PREDICTED}
    assert {t.verdict for (table, _), t in tolerances.items() if table == "table_4_4"} == {REPRODUCED}


def test_damaged_verdicts_are_refused(tmp_path):
    path = tmp_path / "cells.csv"
    path.write_text(
        "table,row,column,reported,value,tolerance,verdict,reason\ntable_4_2,K,a,1,1,0.1,perhaps,r\n"
    )
    with pytest.raises(InputError, match="verdicts of printed cells"):
        CELL_VERDICTS.read(path)
