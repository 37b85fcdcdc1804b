"""The documentation keeps its promises: links resolve, named functions exist, examples run, lines fit."""

import importlib
import re
import runpy
import textwrap
from pathlib import Path

import pytest

import tepsipe
from tests.test_walls import FLOORS

ROOT = Path(__file__).parents[1]
PAGES = [
    *sorted(ROOT.glob("*.md")),
    ROOT / "config/README.md",
    *(page for folder in ("docs", "benchmarks") for page in sorted((ROOT / folder).rglob("*.md"))),
]
LONGEST_LINE = 100
NUMBERED = ["(2-1)", *(f"(3-{k})" for k in range(1, 15))]


def without_code(text):
    """Markdown without fenced blocks, in which brackets are no links."""
    return re.sub(r"^ *```.*?^ *```", "", text, flags=re.MULTILINE | re.DOTALL)


def anchors(page):
    """Anchors that a forge makes of a page's headings: lower case, hyphens for spaces, no punctuation."""
    text = without_code(page.read_text(encoding="utf-8"))
    headings = re.findall(r"^#+ (.+)$", text, re.MULTILINE)
    # the site writes the documentation of a function there, under its name
    functions = set(re.findall(r"^::: (\S+)$", text, re.MULTILINE))
    return functions | {re.sub(r"[^\w\- ]", "", heading.lower()).replace(" ", "-") for heading in headings}


def links(page):
    """Targets of a page's links and pictures, as (path, anchor)."""
    found = re.findall(r"\]\(([^)\s]+)\)", without_code(page.read_text(encoding="utf-8")))
    return [tuple((target + "#").split("#")[:2]) for target in found if "://" not in target]


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_relative_links_resolve(page):
    for target, anchor in links(page):
        there = (page.parent / target).resolve() if target else page
        assert there.exists(), f"{page.name} links {target}"
        if anchor:
            assert anchor in anchors(there), f"{page.name} links {target}#{anchor}"


def test_pages_have_links_that_are_checked():
    assert sum(len(links(page)) for page in PAGES) > 100


def equation_rows():
    """Rows of the index of equations: number -> cells."""
    text = (ROOT / "docs/method.md").read_text(encoding="utf-8")
    table = text.partition("## Equations of the thesis\n")[2].partition("\n## ")[0]
    rows = [[cell.strip() for cell in line.strip("|").split(" | ")] for line in table.splitlines()]
    return {row[0].strip("| "): row for row in rows if re.fullmatch(r"\|? ?\(\d-\d+\)", row[0])}


def test_index_has_every_numbered_equation_with_a_decision():
    rows = equation_rows()
    assert list(rows) == NUMBERED
    for number, (_, content, functions, decision) in rows.items():
        assert content, number
        assert "`tepsipe." in functions, number
        assert "decisions/" in decision, number


def test_report_indexes_every_numbered_equation():
    text = (ROOT / "report/chapters/index.typ").read_text(encoding="utf-8")
    assert re.findall(r"^  \(\[(\(\d-\d+\))\], .*$", text, re.MULTILINE) == NUMBERED


@pytest.mark.parametrize("number", NUMBERED)
def test_functions_of_an_equation_exist_and_name_it(number):
    names = re.findall(r"`(tepsipe\.[\w.]+)`", equation_rows()[number][2])
    texts = []
    for name in names:
        module, _, attribute = name.rpartition(".")
        loaded = importlib.import_module(module)
        assert callable(getattr(loaded, attribute)), name
        texts.append(f"{loaded.__doc__}{getattr(loaded, attribute).__doc__}")
    short = number.strip("()")
    assert any(short in text for text in texts), f"no docstring of {', '.join(names)} names eq {number}"


def test_modules_and_files_that_pages_name_exist():
    named = re.compile(r"`((?:tepsipe|workflow|tests|examples|benchmarks)/[\w./-]*)`")
    for page in PAGES:
        for name in named.findall(page.read_text(encoding="utf-8")):
            assert (ROOT / name).exists(), f"{page.name} names {name}"


@pytest.mark.parametrize("page", PAGES, ids=lambda page: str(page.relative_to(ROOT)))
def test_prose_is_wrapped(page):
    """Tables, code, and lines that are one address may be longer."""
    text = without_code(page.read_text(encoding="utf-8"))
    prose = [line for line in text.splitlines() if not re.match(r" *\|| {4}|\S*$", line)]
    assert [line for line in prose if len(line) > LONGEST_LINE] == []


def test_example_of_the_readme_runs(tmp_path, monkeypatch, capsys):
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    (code,) = re.findall(r"```python\n(.*?)```", readme, re.DOTALL)
    assert len(code.splitlines()) <= 12
    (tmp_path / "example.py").write_text(code, encoding="utf-8")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    found = runpy.run_path("example.py")
    truth, intervals = found["example"].truth, found["fit"].intervals
    for name in ("I", "B", "K"):
        low, high = intervals[name]
        assert 0.0 < low < truth[name] < high
    assert found["fit"].notes == ()
    printed = capsys.readouterr().out
    assert "10.0 in truth" in printed
    assert textwrap.indent(printed, "    ") in readme
    assert (tmp_path / "impedance.csv").is_file()
    assert (tmp_path / "impedance.png").is_file()


def test_picture_of_the_architecture_is_that_of_its_script_and_of_the_walls():
    drawn = runpy.run_path(str(ROOT / "docs/draw_architecture.py"))
    assert (ROOT / "docs/architecture.svg").read_text(encoding="utf-8") == drawn["drawing"]()
    floors = {name: floor for floor, packages in enumerate(drawn["FLOORS"]) for name, _ in packages}
    assert floors.pop("workflow") == max(FLOORS.values())
    assert floors == FLOORS


def test_every_decision_is_listed():
    index = (ROOT / "docs/decisions/README.md").read_text(encoding="utf-8")
    for page in sorted((ROOT / "docs/decisions").glob("0*.md")):
        assert f"({page.name})" in index, page.name
        number = int(page.name[:4])
        assert page.read_text(encoding="utf-8").startswith(f"# {number}. "), page.name


def guideline_rows():
    """Cells of the rows of the guideline's tables: rule, reason, and what checks the rule."""
    text = (ROOT / "docs/guideline.md").read_text(encoding="utf-8")
    lines = re.findall(r"^\|.*\|$(?!\n\|---)", text, re.MULTILINE)
    return [[cell.strip() for cell in line.strip("|").split(" | ")] for line in lines if line[1] != "-"]


@pytest.mark.parametrize("row", guideline_rows(), ids=lambda row: row[0])
def test_rules_of_the_guideline_name_their_checks_and_the_sources_of_their_numbers(row):
    _, reason, checked = row
    pages = [page for page in PAGES if "docs" in page.parts or page.parent.name == "config"]
    known = "".join(page.read_text(encoding="utf-8") for page in pages if page.name != "guideline.md")
    names = re.findall(r"`([^`]+)`", checked)
    assert names
    for name in names:
        command, *options = name.split(" --")
        assert command in known, name
        assert all(f"--{option.split()[0]}" in known for option in options), name
    links = re.findall(r"\]\(([^)#]+)", reason)
    sources = "".join((ROOT / "docs" / link).read_text(encoding="utf-8") for link in links)
    said = re.sub(r"\[[^]]*\]\([^)]*\)|`[^`]*`", "", reason)
    for number in re.findall(r"\d+(?:\.\d+)?", said):
        assert re.search(rf"(?<![\d.]){re.escape(number)}(?!\.?\d)", sources), f"{number} has no source"


def test_picture_of_the_rig_is_that_of_its_script():
    drawn = runpy.run_path(str(ROOT / "docs/draw_rig.py"))
    assert (ROOT / "docs/rig.svg").read_text(encoding="utf-8") == drawn["drawing"]()


def test_every_public_function_is_on_the_page_of_functions():
    text = (ROOT / "docs/api.md").read_text(encoding="utf-8")
    assert sorted(re.findall(r"^::: tepsipe\.(\w+)$", text, re.MULTILINE)) == sorted(tepsipe.__all__)
