"""Pages of trials and index of a tiny study: complete, small, linked, and the same wherever the folder is."""

import re
import shutil
from html import unescape
from urllib.parse import unquote

import pytest
from page_builders import page_data, parsed
from study_builders import TRIALS

pytestmark = pytest.mark.study


def test_every_trial_has_a_small_page_that_loads_nothing(study):
    folder = study / "results/report/trials"
    pages = {path.relative_to(folder).with_suffix("").as_posix(): path for path in folder.rglob("*.html")}
    assert set(pages) == {"/".join(row.split()[:2]) for row in TRIALS}
    for name, path in pages.items():
        html = path.read_text(encoding="utf-8")
        assert len(html) < 1_000_000, name
        assert parsed(html).links == [], name
        assert name.partition("/")[2] in html
        data = page_data(html)
        assert len(data["panels"]) > 2 and all(panel["traces"] for panel in data["panels"]), name


def test_pages_show_what_the_analysis_used(study):
    folder = study / "results/report/trials"
    data = page_data((folder / "dummy/sine-0.5.html").read_text(encoding="utf-8"))
    titles = [panel["title"] for panel in data["panels"]]
    for title in (
        "Angle",
        "Torque, leg",
        "Torque, foot, compensated",
        "Fore-aft force before and after compensation",
    ):
        assert title in titles
    assert len(data["axes"]["time"]["windows"]) > 5
    data = page_data((folder / "weight/minjerk-0.4.html").read_text(encoding="utf-8"))
    titles = [panel["title"] for panel in data["panels"]]
    assert "Belt-induced force, measured and predicted by the models" in titles
    data = page_data((folder / "standing/stiff-pos-0.5.html").read_text(encoding="utf-8"))
    assert sum(panel["title"].startswith("Electromyogram") for panel in data["panels"]) == 5
    assert {band[0] for band in data["axes"]["time"]["windows"]} <= {"epoch", "left-out"}


def test_index_leads_to_every_result_after_the_folder_has_moved(study, tmp_path):
    moved = tmp_path / "elsewhere"
    shutil.copytree(study / "results", moved, ignore=shutil.ignore_patterns("raw", "*.h5"))
    html = (moved / "report/index.html").read_text(encoding="utf-8")
    reader = parsed(html)
    links = [unquote(link) for link in reader.links if not link.startswith("#")]
    assert len(links) > 80
    for link in links:
        assert (moved / "report" / link).is_file(), link
    for kind, pattern in (("tables", "*.csv"), ("figures", "*.svg"), ("report/trials", "*/*.html")):
        for path in (moved / kind).glob(pattern):
            assert any((moved / "report" / link).resolve() == path for link in links), path


def test_index_and_pdf_have_the_same_sentences(study):
    from pypdf import PdfReader

    html = (study / "results/report/index.html").read_text(encoding="utf-8")
    told = re.split('<div class="warning">|<details>', html.partition("<main>")[2])[0]
    told = told.replace("<h2>Findings</h2>", "")
    assert told.count("<p>") >= 6
    pages = PdfReader(study / "results/report/thesis.pdf").pages
    # references and sections have numbers in the PDF, and letters of formulas are of another font
    printed = re.sub(r"\[\d+\]|\W", "", " ".join(page.extract_text() for page in pages[:3]))
    parts = re.split(r"<math>.*?</math>|<a .*?</a>|<[^>]+>", told)
    sentences = [re.sub(r"\W", "", unescape(part)) for part in parts]
    assert len("".join(sentences)) > 1000
    assert [words for words in sentences if words not in printed] == []
