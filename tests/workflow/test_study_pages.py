"""Pages of a tiny study, of its trials and of its report: complete, small, linked, and as the PDF."""

import re
import shutil
from urllib.parse import unquote

import pytest
from page_builders import page_data, parsed
from study_builders import TRIALS

pytestmark = pytest.mark.study


def test_every_trial_has_a_small_page_with_links_to_its_files_and_to_the_report(study):
    folder = study / "results/report/trials"
    pages = {path.relative_to(folder).with_suffix("").as_posix(): path for path in folder.rglob("*.html")}
    assert set(pages) == {"/".join(row.split()[:2]) for row in TRIALS}
    index = (folder.parent / "index.html").read_text(encoding="utf-8")
    for name, path in pages.items():
        html = path.read_text(encoding="utf-8")
        assert len(html) < 1_000_000, name
        reader = parsed(html)
        assert not any(link.startswith(("http", "/")) for link in reader.links), name
        for link in reader.links:
            assert (path.parent / unquote(link).partition("#")[0]).is_file(), (name, link)
        chapter = next(
            link.partition("#")[2] for link in reader.links if "#" in link and "trials" not in link
        )
        assert f'id="{chapter}"' in index, name
        picture = path.with_suffix(".svg").read_text(encoding="utf-8")
        assert picture.startswith("<svg") and len(picture) < 4000, name
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


def test_true_values_stand_beside_the_estimates(study):
    html = (study / "results/report/trials/dummy/sine-0.5.html").read_text(encoding="utf-8")
    first = html.partition("</table>")[0]
    assert first.count("(recommended)") >= 1 and "leg, thesis equation" not in first
    assert re.search(r'class="truth">true 10\.\d', html)


def test_a_page_has_the_command_of_its_trial_and_reasons_against_its_other_estimates(study):
    html = (study / "results/report/trials/dummy/sine-0.5.html").read_text(encoding="utf-8")
    assert re.search(r"<code>snakemake -c1 dummy/sine-0\.5 --forcerun ingest_dummy( |<)", html)
    folded = html.partition("Not recommended because")[2].partition("</table>")[0]
    assert "method of the thesis" in folded and "the study recommends leg, joint likeli" in folded


def report_page(study):
    return (study / "results/report/index.html").read_text(encoding="utf-8")


def test_report_page_leads_to_every_result_after_the_folder_has_moved(study, tmp_path):
    moved = tmp_path / "elsewhere"
    shutil.copytree(study / "results", moved, ignore=shutil.ignore_patterns("raw", "*.h5"))
    reader = parsed((moved / "report/index.html").read_text(encoding="utf-8"))
    outside = [link for link in reader.links if link.startswith("http")]
    assert all("doi.org" in link or "://" in link for link in outside)
    links = [unquote(link) for link in reader.links if not link.startswith(("#", "http"))]
    assert len(links) > 150
    for link in links:
        assert (moved / "report" / link).is_file(), link
    for kind, pattern in (("tables", "*.csv"), ("report/trials", "*/*.html")):
        for path in (moved / kind).glob(pattern):
            assert any((moved / "report" / link).resolve() == path for link in links), path
    assert {unquote(link[1:]) for link in reader.links if link.startswith("#")} <= set(reader.ids)


def test_every_figure_and_table_has_data_code_command_and_the_figures_a_decision(study):
    figures = re.findall(r"(?s)<figure.*?</figure>", report_page(study))
    assert len(figures) > 60
    for figure in figures:
        name = re.search(r'<figure id="([^"]+)"', figure)[1]
        origin = re.sub(r"<[^>]+>", " ", figure.partition('<details class="origin">')[2])
        assert re.search(r"Data\s+\S+\.(csv|json|svg)", origin), name
        assert re.search(r"(Rule|Typeset by)\s+\S+ ?\(?[\w/]+\.(smk|typ):\d+", origin), name
        assert "snakemake -c1 results/" in origin and "--forcerun " in origin, name
        assert "decision" in origin, name
    drawn = [figure for figure in figures if "<img" in figure]
    assert all(
        re.search(r"<code>\w+ \((?:tepsipe/\S+\.py|report/drawings\.typ):\d+\)</code></summary>", figure)
        for figure in drawn
    )
    assert all(
        'loading="lazy"' in figure and re.search(r' width="\d+" height="\d+"', figure) for figure in drawn
    )


def test_tables_without_caption_have_the_origin_of_their_chapter(study):
    body = report_page(study).partition('<h2 id="trials"')[0]
    plain = re.sub(r"(?s)<figure.*?</figure>|<div class=.printed-cells.*?</dl>", "", body)
    after = re.split(r"</table></div>(?!\s*<div class=.wide)\s*", plain)[1:]
    assert len(after) > 2 and all(text.startswith('<details class="origin">') for text in after)


def test_report_page_is_small(study):
    assert len(report_page(study)) < 2_000_000
    pictures = sum(path.stat().st_size for path in (study / "results/figures").glob("*.svg"))
    assert pictures < 15_000_000
