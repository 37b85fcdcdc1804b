"""Sources of the report ask for predicates that exist, and findings have places."""

import importlib
import re
from itertools import chain
from pathlib import Path

import pytest
import yaml
from typst_builders import REPORT, evaluated

from tepsipe.reporting.run import predicates_of
from workflow.support.captions import read_captions
from workflow.support.outputs import CHAPTERS, OWN_REPORTS

ASKED = re.compile(r'(?:(?:holds|says)\(|^\s*(?:\w+: )?\()"(\w+)\.(\w+)"', re.MULTILINE)
HEADING = re.compile(r"^ *=+ (.+?)(?: <[^>]*>)?$", re.MULTILINE)
MODULES = [*CHAPTERS, *chain(*OWN_REPORTS.values())]
SOURCES = sorted(REPORT.rglob("*.typ"))


def asked():
    """Chapter and predicate of every question in the sources."""
    return {found for path in SOURCES for found in ASKED.findall(path.read_text(encoding="utf-8"))}


def known(chapter):
    """Names of the predicates of a chapter."""
    module = importlib.import_module(f"tepsipe.reporting.chapters.{chapter}")
    return [predicate.__name__ for predicate in predicates_of(module)]


def test_every_module_of_a_chapter_is_evaluated():
    folder = Path(importlib.import_module("tepsipe.reporting.chapters").__file__).parent
    assert {path.stem for path in folder.glob("*.py")} - {"__init__"} == set(MODULES)


@pytest.mark.parametrize("chapter", MODULES)
def test_predicates_of_a_chapter_are_those_that_its_sentences_ask_for(chapter):
    assert sorted(known(chapter)) == sorted(name for own, name in asked() if own == chapter)


def test_every_section_that_discusses_a_claim_is_in_the_report():
    claims = yaml.safe_load((REPORT.parent / "config/reported.yaml").read_text(encoding="utf-8"))["claims"]
    headings = {title for path in SOURCES for title in HEADING.findall(path.read_text(encoding="utf-8"))}
    assert {claim["section"] for claim in claims} <= headings


def test_no_sentence_asks_for_an_unknown_chapter_or_claim():
    assert {chapter for chapter, _ in asked()} - {"claims"} == set(filter(known, MODULES))
    claims = yaml.safe_load((REPORT.parent / "config/reported.yaml").read_text(encoding="utf-8"))["claims"]
    assert {measure for own, measure in asked() if own == "claims"} <= {claim["measure"] for claim in claims}


def test_places_of_findings_are_figures():
    (places,) = evaluated(["findings.keys()"], "findings.typ", EMPTY)
    assert [place for place in places if place not in read_captions(REPORT / "captions.yaml")] == []


EMPTY = {
    "made": 0,
    "trials": 1,
    "recordings_source": None,
    "chapters": {},
}
