"""Article and supplement of the tiny study, read as a reader would: words, references and pages."""

import io
import json
import re
import unicodedata
from dataclasses import dataclass
from html import unescape

import numpy as np
import pytest
import typst
from matplotlib.image import imread
from pdf_pages import pages_of
from study_builders import estimates, table
from typst_builders import findings_of, tables_of

from tepsipe.drawing.style import new_figure, save_figure
from workflow.support.captions import read_captions

pytestmark = pytest.mark.study

FOOTER, HEADER = 55.0, 65.0  # heights (pt) without text of the page
# identifiers that are words, too
PLAIN = ("least-squares", "output-error", "single-joint", "joint-likelihood")
SMALLEST = 7.4  # size of a font (pt)
FILL = 0.6  # a page of a study with few trials; chapters end where they end


@dataclass(frozen=True)
class Piece:
    """A piece of text on a page: words, font, height from the bottom and size of the font (pt)."""

    text: str
    font: str
    height: float
    size: float


PDFS = ("thesis", "supplement")


@pytest.fixture(scope="module")
def documents(study):
    from pypdf import PdfReader

    return [PdfReader(study / f"results/report/{name}.pdf") for name in PDFS]


@pytest.fixture(scope="module")
def read(study):
    """Text and pieces of every page of both documents."""
    return [_read(page) for name in PDFS for page in pages_of(study / f"results/report/{name}.pdf")]


@pytest.fixture(scope="module")
def pages(read):
    return [pieces for _, pieces in read]


@pytest.fixture(scope="module")
def words(pages):
    return re.sub(r"\s+", " ", " ".join(piece.text for page in pages for piece in page))


def _read(page):
    found = []

    def visit(text, matrix, text_matrix, font, size):
        if text.strip():
            name = str(font.get("/BaseFont", "")) if font else ""
            scale = abs(matrix[3] * text_matrix[3])
            found.append(Piece(text, name, matrix[5] + matrix[3] * text_matrix[5], scale * size))

    return page.extract_text(visitor_text=visit), found


def _tagged(element, kind):
    """All structure elements of a kind below one."""
    if element.get("/S") == kind:
        yield element
    below = element.get("/K", [])
    for child in below if isinstance(below, list) else [below]:
        child = child.get_object() if hasattr(child, "get_object") else child
        if isinstance(child, dict):
            yield from _tagged(child, kind)


def test_no_identifier_stands_outside_code(pages, study):
    names = {row[key] for row in estimates(study) for key in ("pathway", "estimator")}
    raw = sorted(name for name in names if "-" in name and name not in PLAIN)
    pattern = re.compile(r"[A-Za-z]+_[A-Za-z_]+|\b(?:" + "|".join(map(re.escape, raw)) + r")\b")
    told = [
        (number, match, piece.text)
        for number, page in enumerate(pages, 1)
        for piece in page
        if "Mono" not in piece.font
        for match in pattern.findall(piece.text)
    ]
    assert told == []


@pytest.mark.parametrize(
    "pattern",
    [r"\bNaN\b", r"\bnan\b", r"\bNone\b of the", r"\u22120\. ?0+(?![0-9])", r"\bAll 1 \w+s\b", r"\?\?"],
)
def test_nothing_is_printed_that_is_not_a_number_or_a_word(words, pattern):
    assert re.findall(".{30}" + pattern + ".{10}", words) == []


def test_every_figure_and_table_is_referenced(words):
    captions = set(re.findall(r"(Figure|Table) (S?\d+) ?\. ", words))
    assert len(captions) > 40
    missing = [
        f"{kind} {number}"
        for kind, number in sorted(captions)
        if not re.search(rf"{kind}[ \u00a0]{number}(?!\d| ?-| ?\. [A-Z])", words)
    ]
    assert missing == []


def test_numbered_items_of_the_thesis_have_their_counterparts(words):
    items = [f"Figure {c}-{n}" for c, last in ((2, 14), (3, 3), (4, 14)) for n in range(1, last + 1)]
    items += [f"Table {c}-{n}" for c, last in ((2, 2), (3, 2), (4, 4)) for n in range(1, last + 1)]
    index = words[words.index("The table lists the counterpart of every numbered table and figure") :]
    for item in [*items, "Figure 5-1", "Appendix A", "Figure B-13"]:
        assert item in index, item
    assert "not in this study" not in index


def test_text_and_tables_can_be_read_in_print(pages):
    """No word is smaller than 7.4 pt; sub- and superscripts are single symbols, not words."""
    small = [
        (number, round(piece.size, 1), piece.text)
        for number, page in enumerate(pages, 1)
        for piece in page
        if piece.size < SMALLEST and "Math" not in piece.font and re.search(r"[A-Za-z]{4}|\d\.\d", piece.text)
    ]
    assert small == []


def test_every_caption_begins_with_the_finding_of_its_figure(study, words):
    data = json.loads((study / "results/report/report.json").read_text())
    plain = re.sub(r"\W", "", words)
    captions = read_captions(study / "report/captions.yaml")
    shown = {name for name in captions if (study / f"results/figures/{name}.svg").is_file()}
    assert len(shown) > 40
    told = findings_of(sorted(shown), data, tables_of(study / "results"), struck=True)
    # a figure of many: the trials of Appendix B are in no PDF
    assert shown - {"figure_b_trial"} == set(told)
    for name, text in told.items():
        assert re.search(r"FigureS?\d+" + re.escape(re.sub(r"\W", "", text)), plain), name


def test_no_text_of_a_figure_is_cut_off_at_its_edge(study):
    """Figures have a white margin; a title that is too long would run through it."""
    folder = study / "results/figures"
    files = [
        path.relative_to(folder).as_posix() for kind in ("svg", "png") for path in folder.rglob(f"*.{kind}")
    ]
    assert len(files) > 40
    assert [
        name for name, edges in zip(files, edges_of(files, folder), strict=True) if edges.min() < 0.9
    ] == []


def test_a_title_that_is_too_long_is_cut_off(tmp_path):
    figure, axes = new_figure()
    axes.set_title("A title that is longer than the figure is wide. " * 3)
    save_figure(figure, tmp_path / "long.svg")
    axes.set_title("A title")
    save_figure(figure, tmp_path / "short.svg")
    long, short = edges_of(["long.svg", "short.svg"], tmp_path)
    assert long.min() < 0.9 < short.min()


def edges_of(files, folder):
    """Brightness of the pixels at the edges of pictures: each is a page without margins, set by Typst."""
    bare = "#set page(width: auto, height: auto, margin: 0pt)\n"
    source = bare + "#pagebreak()\n".join(f'#image("/{name}")\n' for name in files)
    pages = typst.compile(
        source.encode(), root=str(folder), format="png", ppi=144.0, ignore_system_fonts=True
    )
    for page in [pages] if isinstance(pages, bytes) else pages:
        image = imread(io.BytesIO(page))[:, :, :3]
        yield np.concatenate([image[0], image[-1], image[:, 0], image[:, -1]])


def test_pages_are_filled(pages, documents):
    height = float(documents[0].pages[0].mediabox.height)
    empty = []
    for number, page in enumerate(pages[:-1], 1):
        body = [piece.height for piece in page if piece.height > FOOTER]
        filled = (height - HEADER - min(body)) / (height - HEADER - FOOTER)
        if filled < FILL:
            empty.append(number)
    # the last page of a part that begins on a page of its own
    assert len(empty) <= 5, empty


def test_the_article_is_as_short_as_an_article(documents):
    assert len(documents[0].pages) <= 28


def test_places_of_the_other_document_are_named(words):
    assert "Section S3 of the supplement" in words and "of the article" in words
    # the tiny study has too few printed numbers for the dummy that they describe, and no plan
    assert {*re.findall(r"a section that this study lacks", words)} <= {"a section that this study lacks"}


def test_nothing_of_the_thesis_is_lost(study):
    """Every figure and claim is in the article, in the supplement, or in the list on the page."""
    sources = [(study / f"report/{name}.typ").read_text("utf-8") for name in ("article", "supplement")]
    shown = set()
    for source in sources:
        for name in re.findall(r'"(\w+)"', source):
            path = study / f"report/chapters/{name}.typ"
            text = path.read_text("utf-8") if path.is_file() else ""
            shown |= {f"figure_{own}" for own in re.findall(r'shown\("(\w+)"\)', text)}
            shown |= {f"figure_budget_{own}" for own in re.findall(r'^  \("(\w+)", \[', text, re.MULTILINE)}
    of_thesis = {path.stem for path in (study / "results/figures").glob("figure_*.svg")}
    # one per trial, which the page of the trial shows
    assert {name for name in of_thesis - shown if not re.fullmatch(r"figure_b_\d+", name)} == set()
    page = (study / "results/report/index.html").read_text(encoding="utf-8")
    words = unicodedata.normalize("NFKC", unescape(re.sub(r"<[^>]+>", "", page))).replace("\u2060", "")
    claims = {
        unicodedata.normalize("NFKC", row["claim"].replace(" - ", ": ")) for row in table(study, "claims")
    }
    assert len(claims) > 90
    plain = re.sub(r"\W", "", words)
    assert [claim for claim in claims if re.sub(r"\W", "", claim) not in plain] == []


@pytest.mark.parametrize("which", [0, 1], ids=PDFS)
def test_a_document_names_itself_and_can_be_archived(documents, which):
    document = documents[which]
    data = document.trailer["/Root"]["/Metadata"].get_data().decode()
    assert "<pdfaid:part>2</pdfaid:part>" in data.replace("\n", "")
    assert document.metadata.title
    assert "/StructTreeRoot" in document.trailer["/Root"]
    figures = list(_tagged(document.trailer["/Root"]["/StructTreeRoot"], "/Figure"))
    assert len(figures) > 15
    assert all(len(figure["/Alt"]) > 20 for figure in figures)


def test_report_page_has_the_numbers_of_the_pdf(study, read):
    def numbers(words):
        words = unicodedata.normalize("NFKC", words).replace("\u2060", "").replace("\u2212", "-")
        return set(re.findall(r"(?<![\w.])\d+\.\d{2,}", words))

    html = (study / "results/report/index.html").read_text(encoding="utf-8")
    for other in ("<details class=.code.*?</details>", "<details class=.origin.*?</details>"):
        html = re.sub(f"(?s){other}|<script.*?</script>|<style.*?</style>", "", html)
    shown = numbers(unescape(re.sub(r"<[^>]+>", " ", html.partition('<h2 id="trials"')[0])))
    printed = numbers(" ".join(text for text, _ in read))
    assert len(shown) > 450
    assert shown - printed == set()
    assert len(printed - shown) < 0.01 * len(printed)
