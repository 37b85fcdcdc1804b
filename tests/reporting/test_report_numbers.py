"""Numbers as the report prints them: digits, signs, dashes, and nothing made up."""

import pytest
from typst_builders import evaluated, typeset_words

from tepsipe.drawing.names import short_name, words
from tepsipe.quantities import unit_symbol

MINUS = "\N{MINUS SIGN}"


TABLE = """pathway,estimator,quantity,unit,a,a_reported,b,b_reported
leg,regression,K,Nm/rad,6.4801,6.722,,
leg,regression,SEM_norm_K,as printed,9.9,,9.9,0.342
leg,regression,SEM_count_K,as printed,0.0123,,2.0e-4,0.342
leg,regression,SE_K,Nm/rad,0.1,,0.2,
foot,regression,VAF_trial,%,99.4321,99.8,71.26,
foot,regression,I,Nms2/rad,0,-0.00001234,,
"""
HEADER = "experiment,condition,pathway,estimator,quantity,flags"


def table_words(flagged="", sem=None):
    tables = {"table_4_2": TABLE, "estimates": f"{HEADER}\ndummy,b,leg,regression,K,{flagged}\n"}
    chapters = {} if sem is None else {"study": {"numbers": {"sem": sem}, "holds": {}}}
    names = {
        "chapters": chapters,
        "units": {"Nm/rad": "N·m/rad", "Nms2/rad": "N·m·s²/rad"},
        "short_names": {"a": "A", "b": "B"},
    }
    source = """#import "figures.typ": *
    #for (k, block) in thesis-blocks("table_4_2").enumerate() [
      block #block.pathway:
      #thesis-table(block, [c], "t" + str(k))
    ]"""
    words = typeset_words(source, names, tables, cells=" | ")
    assert words.count("block") == 2
    return words.split("block")[1:]


def test_table_shows_values_beside_reported_ones_block_by_block():
    first, second = table_words()
    dash = "\N{EN DASH}"
    assert "| A | B |" in first and f"| K | N·m/rad | 6.480 6.722 | {dash} |" in first
    assert "| SEM of K | | 0.012 | 2.0·10-4 0.342 |" in first.replace(MINUS, "-")
    assert "| VAF of the full dataset | % | 99.43 99.8 | 71.3 |" in second


def test_sem_is_shown_by_the_reading_that_the_run_found_nearest():
    first, _ = table_words(sem={"best": "norm", "readings": {"norm": "the norm"}, "distances": []})
    assert "| SEM of K | | 9.9 | 9.9 0.342 |" in first
    assert first.count("SEM of K") == 1


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
    data = {"study": {"reported": {"slips": slips}}, "short_names": {"sine-0.1": "S1", "sine-0.3": "S3"}}
    asked = ['slips("table_4_2", ("sine-0.1", "sine-0.3"))', 'slips("table_4_2", ("sine-0.1",))']
    told, nothing = evaluated(asked, "figures.typ", data)
    assert told == "The thesis prints 0.614 for I in S3, evidently a misprint of 0.061."
    assert nothing is None


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
