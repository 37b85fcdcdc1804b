"""The report of a study of other recordings: its first page, its marks, and nothing of the thesis."""

import re

import pandas as pd
import pytest
from joint_builders import fit_of, rows_of, run_of
from report_readers import faults_of
from study_chapter_builders import PROVENANCE
from typst_builders import REPORT, page_of, plain_words, typeset_words

from tepsipe.io.estimates import ESTIMATES
from tepsipe.reporting.answers import ANSWERS, answers
from tepsipe.reporting.chapters import position_manipulator, study
from tepsipe.reporting.run import Run, report_content

WAY = ["impedance", "parallel-cascade"]


@pytest.fixture
def report(tmp_path):
    """Content of report.json and tables of two trials of a joint, whose estimates have flags."""

    def make(flags="", recommended=True):
        frame = pd.concat([rows_of("a", flags=flags), rows_of("b")]).assign(pathway="impedance")
        frame["recommended"] &= recommended | (frame.condition != "a")
        frame = frame.reindex(columns=list(ESTIMATES.columns))
        cells = frame.assign(recommended=frame.recommended.map({True: "true", False: "false"}))
        cells.to_csv(tmp_path / "estimates.csv", index=False)
        rows = ESTIMATES.read(tmp_path / "estimates.csv")
        ESTIMATES.write(tmp_path / "estimates.csv", rows)
        asked = {"position_manipulator": {"conditions": ["a", "b"], "ways": [WAY]}}
        ANSWERS.write(tmp_path / "answers.csv", answers(rows, asked))
        tables = {name: (tmp_path / f"{name}.csv").read_text() for name in ("estimates", "answers")}
        base = run_of({"a": fit_of(), "b": fit_of()}, frame)
        about = {
            **base.study,
            "title": "Two ankles",
            "tasks": [],
            "experiments": {"position_manipulator": list("ab")},
        }
        run = Run(base.tables, base.fits, base.settings, about, PROVENANCE)
        modules = {"study": study, "position_manipulator": position_manipulator}
        return report_content(run, modules), tables

    return make


def first_page(page):
    """Words between the title and the first experiment."""
    return plain_words(page.partition("Answers")[2].partition(" in a position-controlled")[0])


def test_first_page_has_the_answers_and_what_is_missing(report):
    page = page_of(*report())
    first = first_page(page)
    assert '<a href="../tables/answers.csv">' in page
    assert "a50.0 (45.0 to 55.0)Quotable." in first
    assert "No check failed" in first


def test_flagged_answer_is_marked_and_its_check_in_words(report):
    first = first_page(page_of(*report("clipped")))
    assert "50.0 (45.0 to 55.0)†" in first
    assert "Check first, because peaks are cut off at one value." in first
    assert "a (K): Choose a larger range of the instrument." in first


def test_values_of_a_check_are_told_trial_by_trial(report):
    content, tables = report("reflex-outside-search")
    found = "reflex delays or thresholds outside"
    tables["answers"] = tables["answers"].replace(found, "reflex delays of 0 ms outside", 1)
    words = plain_words(page_of(content, tables))
    assert "reflex-outside-search, a (K): reflex delays of 0 ms outside the searched range predict" in words
    assert "reflex-outside-search, a (" in words and words.count(f": {found}") > 0


def test_pathway_for_comparison_only_has_its_reason_below_the_table(report):
    content, tables = report()
    rows = tables["answers"].replace("for comparison,", "for comparison,it is printed for comparison")
    source = '#import "study_values.typ": *\n#results-table("position_manipulator")'
    words = typeset_words(source, content, {**tables, "answers": rows})
    assert (
        "another estimate of the quantity is recommended. Impedance: it is printed for comparison." in words
    )


def test_table_of_a_person_explains_intervals_windows_and_negative_stiffness(report):
    content, tables = report()
    content["choices"]["standing"] = {"estimators": {"parallel-cascade": {"window_s": 0.08}}}
    source = '#import "study_values.typ": *\n#notes-of("standing", answers)'
    words = typeset_words(source, content, tables)
    assert words.startswith("Intervals of estimates marked ‡ contain only the scatter (Type A).")
    assert words.endswith("Windows from the onset: 80 ms (parallel cascade).")
    lower = tables["answers"].replace(",100,90,110,for comparison", ",-100,-110,-90,for comparison")
    words = typeset_words(source, content, {**tables, "answers": lower})
    assert words.endswith("an estimator attributes reflexes to K, which can then be negative.")
    both = tables["estimates"].replace(",,false,", ",0.5,false,")
    assert "only the scatter" not in typeset_words(source, content, {**tables, "estimates": both})


def test_number_that_is_not_recommended_is_not_in_the_summary(report):
    first = first_page(page_of(*report("time-varying", recommended=False)))
    assert "not quotable" in first and "Not quotable, because the stiffness differs between segments" in first
    assert first.count("50.0 (45.0 to 55.0)") == 1  # of the other trial


@pytest.mark.parametrize(("flags", "recommended"), [("", True), ("clipped", True), ("time-varying", False)])
def test_report_has_no_thesis_no_dash_and_no_number_without_its_mark(report, flags, recommended):
    content, tables = report(flags, recommended)
    assert faults_of(page_of(content, tables), tables["estimates"]) == []


def test_faults_are_found():
    estimates = "value,ci_low,ci_high,recommended,flags\n50.0,45.0,55.0,true,clipped\n60.0,55.0,65.0,false,\n"
    page = "<p>As in the Thesis.</p><p>K is – N·m/rad.</p><td>–</td>"
    page += "<td>50.0 (45.0 to 55.0)</td><td>60.0 (55.0 to 65.0)†</td>"
    assert faults_of(page, estimates) == [
        "As in the Thesis.",
        "K is – N·m/rad.",
        "50.0 (45.0 to 55.0) without †",
        "60.0 (55.0 to 65.0) without ‡",
    ]


def test_captions_name_no_figure_of_the_thesis(report):
    data, tables = report()
    source = '#import "figures.typ": shown\n#shown("4_5")\n#shown("plate_models")\n#shown("4_14")'
    words = typeset_words(source, data, tables)
    assert "The panels have different scales." in words and "hesis" not in words
    # nor do they explain conditions and models that the study lacks
    assert "S: sinusoidal" not in words and "Mean subtraction" not in words and "Dashed: upper limit" in words
    data["short_names"] = {"sine-0.3": "S3"}
    tables["treadmill_models"] = "model\nmean-subtraction\n"
    data["tables_read"] = [*data["tables_read"], "treadmill_models"]
    words = typeset_words(source, data, tables)
    assert "in 0.1 m/s. The panels" in words and "Mean subtraction uses" in words


@pytest.mark.parametrize("name", ["study", "study_values", "coverage", "plan", "several_joints", "walking"])
def test_sources_of_reports_of_their_own_name_no_thesis(name):
    text = re.sub(r"//.*", "", (REPORT / f"{name}.typ").read_text(encoding="utf-8"))
    assert not re.search(r"thesis(?!\")", text.replace("reproduces-thesis", ""), re.IGNORECASE)
