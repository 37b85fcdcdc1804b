"""Assertions of the article hold in the shipped study, with its configuration, engine and seed.

The study is not run for this test: it reads the results that ``make`` left in ``results``, and evaluates the
predicates and the sentences of the present sources with their tables and fits.
"""

import json
import re
from dataclasses import replace

import pytest
import typst
import yaml
from report_readers import run_of
from study_builders import ROOT
from typst_builders import by_typesetter, report_root, tables_of

from tepsipe.reporting.run import report_content

pytestmark = pytest.mark.study
RESULTS = ROOT / "results"


@pytest.fixture(scope="module")
def shipped():
    """The shipped study as a run, modules of its chapters, and files of its tables."""

    def settings(path):
        return yaml.safe_load(path.read_text(encoding="utf-8")) if path.is_file() else None

    if settings(RESULTS / "config.yaml") != settings(ROOT / "config/config.yaml"):
        pytest.skip("results/ has no results of the shipped study: run make first")
    tables = tables_of(RESULTS)
    if "measure" not in tables["claims"].read_text(encoding="utf-8").splitlines()[0].split(","):
        pytest.skip("results/ was made by an older version: run make first")
    return *run_of(RESULTS), tables


def test_every_assertion_of_the_article_holds_in_the_shipped_study(shipped):
    assert failing(*shipped, ("report.typ", "supplement.typ")) == []


def test_a_number_that_was_altered_by_hand_strikes_its_sentence_through(shipped):
    run, modules, tables = shipped
    rows = run.tables["estimates"].copy()
    printed = (rows.pathway == run.settings["dummy"]["as_printed"]) & (rows.quantity == "K")
    rows.loc[printed, "value"] += 2.0
    altered = replace(run, tables={**run.tables, "estimates": rows})
    assert "dummy.signs_explain" in failing(altered, modules, tables, ("report.typ",))


def failing(run, modules, tables, sources):
    """Names of the assertions in the article or the supplement that do not hold."""
    found = []
    with report_root(report_content(run, modules), tables) as root:
        for source in sources:
            own = {"field": "value", "root": str(root), "ignore_system_fonts": True}
            found += json.loads(by_typesetter(typst.query, str(root / source), "<not-in-this-run>", **own))
    return found


@pytest.mark.usefixtures("shipped")
def test_the_answer_fits_on_the_first_page():
    from pypdf import PdfReader

    first, second, *others = PdfReader(RESULTS / "report/thesis.pdf").pages
    assert "What is simulated" in first.extract_text() and len(others) <= 26
    assert re.search(r"1\s+Introduction", second.extract_text()[:200])
