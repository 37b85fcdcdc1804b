"""Numbers as the report prints them: digits, signs, dashes, and nothing made up."""

import math

import pandas as pd
import pytest
from typst_builders import typeset_words

from tepsipe.reporting.figures.names import short_name, unit_symbol, words
from tepsipe.reporting.numbers.format import number, percent, span
from tepsipe.reporting.numbers.study import (
    flags_data,
    provenance_data,
    slips_data,
)

MINUS = "\N{MINUS SIGN}"


@pytest.mark.parametrize(
    ("value", "digits", "text"),
    [
        (9.9664, 3, "9.97"),
        (0.015043, 3, "0.0150"),
        (123.4, 3, "123"),
        (-0.25, 2, f"{MINUS}0.25"),
        (0.0, 3, "0"),
        (2.0e-4, 2, "2.0·10⁻⁴"),
        (-1.5e7, 2, f"{MINUS}1.5·10⁷"),
        (math.inf, 3, "∞"),
        (-math.inf, 3, f"{MINUS}∞"),
        (math.nan, 3, "\N{EN DASH}"),
        (None, 3, "\N{EN DASH}"),
    ],
)
def test_number_is_printed_with_its_significant_digits(value, digits, text):
    assert number(value, digits) == text


def test_percentage_and_span_are_printed_with_their_signs():
    assert percent(-3.25, 1) == f"{MINUS}3.2"
    assert span([6.9, 6.1, 6.5]) == "6.10 to 6.90"
    assert span([2.0001, 2.0002]) == "2.00"


TABLE = """pathway,estimator,quantity,unit,a,a_reported,b,b_reported
leg,regression,K,Nm/rad,6.4801,6.722,,
leg,regression,SEM_K,as printed,0.0123,,2.0e-4,0.342
leg,regression,SE_K,Nm/rad,0.1,,0.2,
foot,regression,VAF_trial,%,99.4321,99.8,71.26,
foot,regression,I,Nms2/rad,0,-0.00001234,,
"""
HEADER = "experiment,condition,pathway,estimator,quantity,flags"


def table_words(flagged=""):
    tables = {"table_4_2": TABLE, "estimates": f"{HEADER}\ndummy,b,leg,regression,K,{flagged}\n"}
    names = {"units": {"Nm/rad": "N·m/rad", "Nms2/rad": "N·m·s²/rad"}, "short_names": {"a": "A", "b": "B"}}
    source = """#import "figures.typ": *
    #for (k, block) in thesis-blocks("table_4_2").enumerate() [
      block #block.pathway:
      #thesis-table(block, [c], "t" + str(k), reported: k == 0, without: if k == 0 { () } else { ("I",) })
    ]"""
    words = typeset_words(source, names, tables, cells=" | ")
    assert words.count("block") == 2
    return words.split("block")[1:]


def test_table_shows_values_beside_reported_ones_block_by_block():
    first, second = table_words()
    dash = "\N{EN DASH}"
    assert "| A | B |" in first and f"| K | N·m/rad | 6.480 6.722 | {dash} |" in first
    assert "| SEM of K | | 0.012 | 2.0·10-4 0.342 |" in first.replace(MINUS, "-")
    assert "| VAF of the full dataset | % | 99.43 | 71.3 |" in second
    # reported values are left out, and rows
    assert "99.8" not in second and "N·m·s2" not in second


def test_values_of_flagged_estimates_have_a_dagger():
    (first, _), (plain, _) = table_words("at-bound;undefined"), table_words()
    dash, dagger = "\N{EN DASH}", "\N{DAGGER}"
    assert f"| K | N·m/rad | 6.480 6.722 | {dash} {dagger} |" in first
    assert f"| standard error of K | N·m/rad | 0.10 | 0.20 {dagger} |" in first
    assert dagger not in plain


def test_slip_of_the_print_is_told_for_the_conditions_that_are_shown():
    slips = [
        {"table": "table_4_2", "quantity": "I", "condition": "sine-0.3", "printed": 0.614, "meant": 0.061},
        {"table": "table_4_3", "quantity": "I", "condition": "minjerk-0.3", "printed": 0.611, "meant": 0.061},
    ]
    told = slips_data(slips, "table_4_2", ["sine-0.1", "sine-0.3"], ["S1", "S3"])
    assert "0.614 for I in S3" in told
    assert "0.061" in told
    assert slips_data(slips, "table_4_2", ["sine-0.1"], ["S1"]) == ""


@pytest.mark.parametrize(
    ("condition", "label"),
    [
        ("sine-0.3", "S3"),
        ("minjerk-0.5-8s", "M52"),
        ("minjerk-0.1", "M1"),
        ("0.16", "0.16"),
        ("mine", "mine"),
    ],
)
def test_conditions_have_the_thesis_labels(condition, label):
    assert short_name(condition) == label


@pytest.mark.parametrize(
    ("engine", "shown"),
    [
        ({"name": "mujoco", "version": "4.0.0"}, ["mujoco 4.0.0"]),
        (None, []),  # a study without simulations
    ],
)
def test_provenance_names_the_engine_that_ran(engine, shown):
    record = {
        "commit": "abc",
        "modified": False,
        "python": "3.13.0",
        "engine": engine,
        "config_sha256": "f00",
        "seed": 1,
        "packages": {},
        "files": {},
        "raw_files": {},
    }
    facts = provenance_data(record)["facts"]
    assert [text for name, text in facts if name == "Engine of the simulations"] == shown
    assert ["Python", "3.13.0"] in facts


@pytest.mark.parametrize(
    ("name", "shown"),
    [
        ("leg-thesis", "leg, thesis equation"),
        ("leg-thesis-aligned", "leg, thesis equation, aligned markers"),
        ("foot-compensated", "foot, compensated"),
        ("windowed-least-squares", "windowed least squares"),
        ("windowed-least-squares-thesis", "windowed least squares, thesis"),
        ("bidirectional 20 Hz", "zero-lag 20 Hz"),
        ("unidirectional 20 Hz", "forward-only 20 Hz"),
        ("teager-kaiser", "Teager-Kaiser"),
    ],
)
def test_figures_show_words_for_names(name, shown):
    assert words(name) == shown


def test_units_are_typeset_in_figures_and_kept_in_files():
    assert [unit_symbol(u) for u in ("Nms2/rad", "Nms/rad", "Nm/rad", "Nm", "N", "%")] == [
        "N·m·s²/rad",
        "N·m·s/rad",
        "N·m/rad",
        "N·m",
        "N",
        "%",
    ]


def test_flagged_estimates_are_counted():
    frame = pd.DataFrame(
        {
            "pathway": "leg",
            "estimator": "regression",
            "quantity": ["K", "K", "B"],
            "condition": ["a", "b", "a"],
            "flags": [None, "at-bound;undefined", None],
            "recommended": [True, False, True],
            "experiment": "dummy",
        }
    )
    told = flags_data(frame)
    assert (told["count"], told["total"]) == (1, 3)
    assert [(kind["name"], kind["count"]) for kind in told["kinds"]] == [
        ("at-bound", "1"),
        ("undefined", "1"),
    ]
    assert flags_data(frame.assign(flags=None))["count"] == 0
    # only of estimates that are to be quoted, in words that say what to look at
    assert told["recommended"] == {"count": "0", "total": "2", "kinds": []}
    quoted = flags_data(frame.assign(recommended=True))["recommended"]
    assert (quoted["count"], quoted["total"]) == ("1", "3")
    assert [(k["name"], k["where"]) for k in quoted["kinds"]] == [
        ("at-bound", "K of the dummy (b)"),
        ("undefined", "K of the dummy (b)"),
    ]
    assert quoted["kinds"][0]["meaning"].endswith("check units and signs")
