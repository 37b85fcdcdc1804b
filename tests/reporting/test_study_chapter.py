"""Conditions and sentences that every report may have: claims, cells, estimates to quote, provenance."""

import pandas as pd
import pytest
from study_chapter_builders import CLAIM, PROVENANCE, estimate, study_content, study_run
from typst_builders import MARK, chapter_words, evaluated

from tepsipe.reporting.chapters import study
from tepsipe.reporting.chapters.study import digest_of, provenance_of
from tepsipe.reporting.ledger import VERDICTS
from tepsipe.reporting.run import Run

REPORTED = {"reported": {"slips": []}, "experiments": {"dummy": list("abcd")}}


def compared(further=None, missing=False, covered=("true", "false", "false", "true"), **changed):
    """A run with three recommended estimates: one covers its truth, two miss it, one of these with a flag."""
    rows = [
        estimate(
            experiment="dummy", condition=c, recommended=c != "d", flags="lack-of-fit" if c == "c" else ""
        )
        for c in "abcd"
    ]
    keys = ("experiment", "condition", "pathway", "estimator", "quantity")
    truth = {"truth": 10.0, "relative_error": -0.1, "value": 9.0, "truth_of": "small movements"}
    truth["unit"] = "Nm/rad"
    recovery = [
        {key: row[key] for key in keys} | truth | {"covered": c} for row, c in zip(rows, covered, strict=True)
    ]
    tables = {"estimates": rows} | ({} if missing else {"recovery": recovery})
    return study_run(tables | (further or {}), **REPORTED | changed)


SOURCES = {"scatter": ("A", 0.3), "leg_mass_kg": ("B", 0.4)}


def explained(**constants):
    """The same with budgets, and constants of the laboratory, drawn around 0.4 with a spread of 0.1."""
    keys = {"pathway": "leg", "estimator": "ls", "quantity": "K", "experiment": "dummy"}
    budget = [
        keys | {"condition": c, "source": name, "type": kind, "u": u}
        for c in "abc"
        for name, (kind, u) in SOURCES.items()
    ]
    drawn = {"kind": "drawn", "nominal": "0.4", "standard_deviation": 0.1}
    laboratory = [drawn | {"key": f"dummy.subject.{name}", "value": x} for name, x in constants.items()]
    return compared(
        {"uncertainty": budget, "laboratory": laboratory or [drawn | {"key": "a.b", "value": "0"}]}
    )


def test_recommended_estimates_are_counted_once_each():
    asked = ["compared-estimates().len()", "compared-estimates().filter(own => own.covered).len()"]
    assert evaluated(asked, "recovery_values.typ", *study_content(compared())) == [3, 1]
    assert evaluated(asked, "recovery_values.typ", *study_content(compared(missing=True))) == [0, 0]


def test_missed_truth_is_compared_with_the_draws_by_hand():
    # an error of -1.0: a mass drawn at +1.5 standard deviations explains at most 0.6 of it, the rest is 0.4
    first, second = study.missed(explained(leg_mass_kg="0.55"))
    assert (first["condition"], second["condition"]) == ("b", "c")
    assert first["source"] == "mass of the leg"
    assert first["drawn_sd"] == pytest.approx(1.5)
    assert first["error_percent"] == pytest.approx(-10.0)
    assert first["error_over_u"] == pytest.approx(-2.0)
    assert first["share_percent"] == pytest.approx(60.0)
    assert first["rest_over_u"] == pytest.approx(0.4 / 0.3)
    # without a draw of any source the whole error remains
    first, _ = study.missed(explained())
    assert first["source"] is None and first["share_percent"] == 0.0
    assert first["rest_over_u"] == pytest.approx(1.0 / 0.5)


@pytest.mark.parametrize(
    ("constants", "told"),
    [
        ({"leg_mass_kg": "0.55"}, "|mass of the leg, drawn at +1.5 standard deviations|60|1.3|"),
        ({}, "|no drawn source|–|2.0|"),
    ],
)
def test_table_of_missed_truths_tells_the_reason(constants, told):
    data, tables = study_content(explained(**constants))
    words = chapter_words("recovery", data | {"short_names": {"b": "S2"}}, tables, cells="|")
    assert "intervals of 2 of the 3 recommended estimates miss the truth" in words
    assert f"|K of the dummy (S2)|ls|−10|−2.0{told}" in words
    assert ("In both cases, the rest" in words) is bool(constants)
    covered = study_content(compared(covered=["true"] * 4))
    assert "miss the truth" not in chapter_words("recovery", *covered)


def alike(third):
    """Five recommended estimates with errors of 1.4 to 1.5 %, but for the third."""
    rows = [estimate(experiment="dummy", condition=c, recommended=True) for c in "abcde"]
    recovery = pd.DataFrame(rows).drop(columns=["recommended", "flags"])
    errors = [0.014, 0.0145, third, 0.0148, 0.0141]
    recovery = recovery.assign(
        covered=["true"] * 4 + ["false"], truth=1.0, relative_error=errors, truth_of="small movements"
    )
    return study_run({"estimates": rows, "recovery": recovery}, **REPORTED)


def test_errors_of_one_sign_are_one_draw():
    (own,) = study.one_sided(alike(0.015))
    assert (own["n"], own["quantity"]) == (5, "K")
    assert (own["low_percent"], own["high_percent"]) == pytest.approx((1.4, 1.5))
    assert study.one_sided(alike(-0.015)) == []


# ---- claims and cells


def test_verdicts_are_counted():
    claims = [CLAIM | {"verdict": verdict} for verdict in [*VERDICTS, "fitted"]]
    claims[0] |= {"null_verdict": "implied"}
    claims[1] |= {"used": "a joint; our threshold, the thesis prints none"}
    cell = {"table": "table_4_2", "row": "K", "column": "a", "null_verdict": "not reproduced"}
    cell |= {"reason": "", "reported": 10.0, "value": 9.0, "null_value": 10.0}
    rows = [cell | {"verdict": verdict} for verdict in VERDICTS]
    rows[:2] = [row | {"null_verdict": "implied"} for row in rows[:2]]
    made = study_run({"claims": claims, "cells": rows}, made={"dummy": ["a"]}, reported={"assertions": []})
    words = chapter_words("reproduction", *study_content(made))
    assert "We listed 11 claims and 10 printed numbers" in words
    assert (
        "The null model satisfies 1 of all claims. For 1 claims the thesis prints no number, so we set"
        in words
    )
    assert "This run, but not the null model, returns 3 of all 10 numbers." in words
    assert "No numeric result of the thesis was reproduced blind" in words
    (scores,) = evaluated(["plain(score-sentences())"], "verdict_values.typ", *study_content(made))
    assert scores.startswith(
        "Within tolerances derived from the thesis, this run returns 5 of 10 printed values of I, B"
    )
    assert "A null model, which uses only numbers printed in the thesis, returns 2" in scores


def scored(**null):
    """Run with one cell of each kind in Table 4-2 and a second K; ``null`` are cells of the null model."""
    rows = [("table_4_2", "K"), ("table_4_3", "K"), ("table_4_2", "SEM_K"), ("table_4_1", "VAF_trial")]
    cells = [
        {"table": table, "row": row, "column": "a", "verdict": "not reproduced"}
        | {"null_verdict": null.get(row, "implied")}
        for table, row in rows
    ]
    cells[0] |= {"verdict": "fitted"}
    return study_run({"cells": cells})


def test_scores_are_counted_by_kind():
    found = study.scores(scored(SEM_K="not reproduced"))
    kinds = [(one["kind"], one["all"], one["within"], one["null"]) for one in found["kinds"]]
    assert kinds == [("I, B and K", 2, 1, 2), ("SEM", 1, 0, 0), ("VAF", 1, 0, 1)]
    assert (found["dummy"]["within"], found["dummy"]["null"]) == (1, 2)
    assert (found["run_alone"], found["means"]) == (0, 3)
    assert study.scores(study_run({})) is None
    assert study.null_ahead(scored()) and not study.null_ahead(scored(SEM_K="not reproduced"))
    runs = (scored(), scored(SEM_K="not reproduced"))
    ahead, behind = (chapter_words("reproduction", *study_content(run), struck=True) for run in runs)
    assert "than this run, for the parameters, for the SEMs and for the VAFs." in ahead
    assert MARK in behind and MARK not in ahead


@pytest.mark.parametrize(
    ("reported", "found", "tolerance", "shown"),
    [
        (10.0, 9.6, "0.5", ["10", "9.60"]),
        (10.0, 10.004, "0.5", ["10", "10"]),
        (0.0998, 0.09611426, "0.02", ["0.0998", "0.09611"]),
        (-0.25, -0.2512, "below", ["< \N{MINUS SIGN}0.25", "\N{MINUS SIGN}0.251"]),
        (5.0, "", "above", ["> 5", "\N{EN DASH}"]),
    ],
)
def test_a_claim_has_one_digit_more_than_the_thesis_printed(reported, found, tolerance, shown):
    row = CLAIM | {"reported": reported, "reproduced": found, "tolerance": tolerance}
    asked = ["(claims.first().reported, claims.first().found)"]
    assert evaluated(asked, "verdict_values.typ", *study_content(study_run({"claims": [row]}))) == [shown]


def test_rows_of_noise_are_told_by_their_cells():
    def cell(row, verdict, column="tau"):
        names = {"table": "table_4_4", "row": row, "column": column}
        return names | {"verdict": verdict, "null_verdict": "not reproduced"}

    rows = [cell("I", "interpretation"), cell("SEM_K", "not reproduced"), cell("K", "fitted")]
    rows += [cell("K", "not reproduced", "theta"), cell("SEM_K", "interpretation", "none")]
    data = study_content(study_run({"cells": rows}))
    kinds = {"all": ["I"], "some": ["K"], "none": ["SEM of K"], "cells": 4, "within": 2, "null": 0}
    assert evaluated(["noisy-rows()"], "verdict_values.typ", *data) == [kinds]


SEM_TABLE = {"pathway": "leg-thesis", "estimator": "ls", "unit": "Nm/rad"}


@pytest.mark.parametrize(("factors", "best"), [((30.0, 1.1, 1.2), "count"), ((0.9, 0.2, 0.3), "norm")])
def test_sems_are_told_by_the_reading_that_is_nearest_in_this_run(factors, best):
    rows = [
        SEM_TABLE | {"quantity": f"SEM_{reading}_K", "a": 0.5 * factor, "a_reported": 0.5}
        for reading, factor in zip(("norm", "count", "freedom"), factors, strict=True)
    ]
    # another block does not count
    rows.append(rows[0] | {"pathway": "leg", "a": 0.5})
    reported = {"slips": [], "tables": {"table_4_2": {"SEM_K": {"a": 0.5}}}}
    columns = ["pathway", "estimator", "quantity", "unit", "a", "a_reported"]
    run = study_run({"cells": []}, **REPORTED | {"reported": reported})
    run = Run(run.tables | {"table_4_2": pd.DataFrame(rows)[columns]}, run.fits, run.settings, run.study)
    found = study.sem(run)
    assert found["best"] == best
    assert {(one["reading"], one["table"]): one["median_ratio"] for one in found["distances"]} == {
        (reading, table): pytest.approx(factor)
        for reading, factor in zip(("norm", "count", "freedom"), factors, strict=True)
        for table in ("table_4_2", "all")
    }
    assert study.sem(study_run({}, **REPORTED))["distances"] == []


def test_flagged_estimates_are_counted():
    rows = [
        estimate(experiment="dummy", condition=c, quantity=q, flags=f)
        for c, q, f in (("a", "K", ""), ("b", "K", "at-bound;undefined"), ("a", "B", ""))
    ]
    words = chapter_words("recovery", *study_content(study_run({"estimates": rows})))
    assert "Of 3 estimates, 1 failed a check. None of these is a recommended estimate;" in words
    assert "at-bound (1): a parameter lies" in words and "undefined (1): the value" in words
    rows = [
        estimate(condition=c, quantity=q, flags="at-bound", recommended=True) for c in "abcde" for q in "BK"
    ]
    words = chapter_words("recovery", *study_content(study_run({"estimates": rows})))
    assert "Of 10 estimates, 10 failed a check. 10 of these are recommended estimates (" in words
    assert "K and B of the position-controlled manipulator (a, b, c, d and 1 more)" in words


@pytest.mark.parametrize(
    ("engine", "shown"),
    [
        ({"name": "equations", "version": "1.0.0", "by_equations": []}, ["equations 1.0.0"]),
        (
            {"name": "mujoco", "version": "4.0.0", "by_equations": ["corrected", "joint-likelihood"]},
            ["MuJoCo 4.0.0; by the equations of motion: corrected; joint likelihood"],
        ),
        (None, []),  # a study without simulations
    ],
)
def test_provenance_names_the_engine_that_ran(engine, shown):
    (facts,) = evaluated(
        ["facts"], "provenance_values.typ", *study_content(study_run({}, {"engine": engine}))
    )
    assert [text for name, text in facts if name == "Engine of the simulations"] == shown
    assert ["Python", "3.13.0"] in facts and ["Commit", "abc"] in facts


@pytest.mark.parametrize(
    ("commit", "modified", "shown"),
    [("abc", True, "abc, with uncommitted changes"), (None, None, "not a git checkout")],
)
def test_provenance_names_the_commit(commit, modified, shown):
    run = study_run({}, {"commit": commit, "modified": modified})
    (facts,) = evaluated(["facts"], "provenance_values.typ", *study_content(run))
    assert facts[0] == ["Commit", shown]


def test_digest_does_not_depend_on_the_order_of_the_files():
    files = [{"file": "b", "sha256": "2"}, {"file": "a", "sha256": "1"}]
    assert digest_of(files) == digest_of(files[::-1])
    assert digest_of(files) != digest_of([{"file": "b", "sha256": "3"}, files[1]])
    printed = provenance_of(PROVENANCE | {"raw_files": {"dummy/a": {"log": files[0], "markers": files[1]}}})
    assert [(d["of"], d["files"]) for d in printed["digests"]] == [
        ("Files of the study", 1),
        ("Raw files", 2),
    ]
    assert printed["digests"][1]["sha256"] == digest_of(files)
    assert printed["files"] == {"sheet": "a.tsv"} and "raw_files" not in printed
