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
from study_builders import ROOT
from typst_builders import by_typesetter, report_root, tables_of

from tepsipe.reporting.run import report_content

pytestmark = pytest.mark.study
RESULTS = ROOT / "results"


@pytest.fixture(scope="module")
def shipped():
    """The shipped study as a run, modules of its chapters, and files of its tables."""
    from workflow.scripts.typeset import chapters, read_run

    def settings(path):
        return yaml.safe_load(path.read_text(encoding="utf-8")) if path.is_file() else None

    if settings(RESULTS / "config.yaml") != settings(ROOT / "config/config.yaml"):
        pytest.skip("results/ has no results of the shipped study: run make first")
    data = json.loads((RESULTS / "report/report.json").read_text(encoding="utf-8"))
    tables = tables_of(RESULTS)
    if "measure" not in tables["claims"].read_text(encoding="utf-8").splitlines()[0].split(","):
        pytest.skip("results/ was made by an older version: run make first")
    names = [(group, name) for group, own in data["facts"].items() for name in own]
    places = [RESULTS / f"fits/{group}/{name}.h5" for group, name in names]
    places += [RESULTS / f"fits/{name}.h5" for group, name in names if group == name]
    fits = [str(path) for path in places if path.is_file()]
    files = {name: str(path) for name, path in tables.items()}
    run = read_run(files, fits, data["choices"], data["study"], str(RESULTS / "provenance.json"))
    return run, chapters(data["chapters"]), tables


def test_every_assertion_of_the_article_holds_in_the_shipped_study(shipped):
    assert failing(*shipped) == []


def test_a_number_that_was_altered_by_hand_strikes_its_sentence_through(shipped):
    run, modules, tables = shipped
    rows = run.tables["estimates"].copy()
    printed = (rows.pathway == run.settings["dummy"]["as_printed"]) & (rows.quantity == "K")
    rows.loc[printed, "value"] += 2.0
    assert "dummy.signs_explain" in failing(
        replace(run, tables={**run.tables, "estimates": rows}), modules, tables
    )


def failing(run, modules, tables):
    """Names of the assertions in article and supplement that do not hold."""
    found = []
    with report_root(report_content(run, modules), tables) as root:
        for source in ("report.typ", "supplement.typ"):
            own = {"field": "value", "root": str(root), "ignore_system_fonts": True}
            found += json.loads(by_typesetter(typst.query, str(root / source), "<not-in-this-run>", **own))
    return found


@pytest.mark.usefixtures("shipped")
def test_the_answer_fits_on_the_first_page():
    from pypdf import PdfReader

    first, second, *others = PdfReader(RESULTS / "report/thesis.pdf").pages
    assert "What is simulated" in first.extract_text() and len(others) <= 26
    assert re.search(r"1\s+Introduction", second.extract_text()[:200])
