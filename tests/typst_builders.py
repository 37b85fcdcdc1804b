"""Sources of the reports, evaluated and typeset by Typst with altered data and tables."""

import html
import json
import os
import re
import shutil
import tempfile
import unicodedata
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from contextlib import contextmanager
from functools import cache
from multiprocessing import get_context
from pathlib import Path

import typst

from workflow.support.captions import read_captions

REPORT = Path(__file__).parents[1] / "report"
# facts of a study with three trials of the dummy
STUDY = {"title": "t", "recordings_source": None, "experiments": {"dummy": list("abc")}, "made": {}}


@cache
def _typesetter() -> ProcessPoolExecutor:
    """One process that typesets for all tests of this one.

    Typst remembers what it has typeset, up to gigabytes. Each fork copies the table of all pages, so that a
    test which reads a file in a child would take several times as long in a process of this size.
    """
    return ProcessPoolExecutor(1, get_context("spawn"))


def by_typesetter(function: Callable, *arguments: object, **options: object):
    """What a function that calls Typst returns, in the process for it."""
    return _typesetter().submit(function, *arguments, **options).result()


@contextmanager
def report_root(
    data: Mapping, tables: Mapping[str, str | Path], files: Mapping[str, str] | None = None
) -> Iterator[Path]:
    """Root with the sources of the reports, blank figures, ``data`` as report.json, tables and other files.

    Parameters
    ----------
    data : mapping
        Content of report.json; the names of the tables are added.
    tables : mapping of str to str or Path
        Name of a table -> its text (CSV) or file.
    files : mapping of str to str, optional
        Name of another file below the root -> its text.
    """
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder) / "report"
        shutil.copytree(_sources().name, root, copy_function=os.link)
        for name, table in tables.items():
            text = table if isinstance(table, str) else table.read_text(encoding="utf-8")
            (root / f"tables/{name}.csv").write_text(text, encoding="utf-8")
        content = json.dumps({**data, "tables_read": list(tables)})
        for name, text in {"report.json": content, **(files or {})}.items():
            (root / name).unlink(missing_ok=True)  # a link to the file of all roots
            (root / name).write_text(text, encoding="utf-8")
        yield root


@cache
def _sources() -> tempfile.TemporaryDirectory:
    """Sources of the reports and a blank picture for every figure, copied once and linked into every root."""
    folder = tempfile.TemporaryDirectory()
    root = Path(folder.name)
    shutil.copytree(REPORT, root, dirs_exist_ok=True)
    for name in ("tables", "figures"):
        (root / name).mkdir()
    for name in _figures(root):
        (root / f"figures/{name}.svg").write_text(
            '<svg xmlns="http://www.w3.org/2000/svg" width="9" height="9"></svg>'
        )
    return folder


def _figures(root: Path) -> set[str]:
    """Names of the figures with a caption, and of those that a source shows by itself."""
    sources = "".join(path.read_text(encoding="utf-8") for path in root.rglob("*.typ"))
    captions = read_captions(root / "captions.yaml")
    return {*captions, *re.findall(r'"figures/(\w+)\.svg"', sources)}


def evaluated(
    expressions: Sequence[str],
    imports: str,
    data: Mapping | None = None,
    tables: Mapping[str, str | Path] | None = None,
    files: Mapping[str, str] | None = None,
) -> list:
    """Values of Typst expressions, in code mode, after ``imports`` of the report's sources.

    Parameters
    ----------
    expressions : sequence of str
        For example ``num(1.5)``; their values must be text, numbers, truth values, arrays or dictionaries.
    imports : str
        For example ``format.typ``: sources of which everything is imported, separated by spaces.
    data, tables, files : mapping, optional
        As in `report_root`.
    """
    lines = [f'#import "{name}": *' for name in imports.split()]
    lines.append("#metadata((" + "".join(f"{{ {e} }}, " for e in expressions) + ")) <values>")
    files = {**(files or {}), "expressions.typ": "\n".join(lines)}
    with report_root(data or {}, tables or {}, files) as root:
        given = {"root": str(root), "ignore_system_fonts": True}
        (found,) = json.loads(by_typesetter(typst.query, str(root / "expressions.typ"), "<values>", **given))
    return found["value"]


# end of an assertion that is struck through, because it does not hold in the run
MARK = "(not in this run)"


def findings_of(
    places: Sequence[str], data: Mapping, tables: Mapping[str, str | Path] | None = None, struck: bool = False
) -> dict[str, str]:
    """First sentences of the captions that have one, by name of the figure; also ``struck`` ones."""
    told = evaluated([f'finding("{place}")' for place in places], "figures.typ", data, tables)
    found = {place: text for place, text in zip(places, told, strict=True) if text is not None}
    return {place: text for place, text in found.items() if struck or MARK not in text}


def typeset_words(
    source: str,
    data: Mapping,
    tables: Mapping[str, str | Path] | None = None,
    cells: str = "",
    struck: bool = False,
) -> str:
    """Words of a source, typeset without figures; ``cells`` of tables end with that text.

    Assertions that do not hold are left out, unless ``struck`` ones are wanted.
    """
    with report_root(data, tables or {}, {"words.typ": source}) as root:
        given = {"root": str(root), "ignore_system_fonts": True, "format": "html"}
        page = by_typesetter(typst.compile, str(root / "words.typ"), **given).decode()
    if not struck:
        page = without_struck(page)
    return plain_words(re.sub("(<tr>)|<br>|(</t[dh]>)", lambda m: cells if m[1] or m[2] else " ", page))


def without_struck(page: str) -> str:
    """A page of HTML without assertions that do not hold."""
    return re.sub(rf"(?s)<s>.*?</s>\s*{re.escape(MARK)}", "", page)


def plain_words(page: str) -> str:
    """Words of a page of HTML."""
    words = html.unescape(re.sub(r"<[^>]+>", "", page))
    return " ".join(unicodedata.normalize("NFKC", words).split())


def page_of(
    data: Mapping, tables: Mapping[str, str | Path] | None = None, source: str = '#include "report.typ"'
) -> str:
    """A source as it is typeset for the page of a browser, from the content of report.json and tables."""
    from workflow.scripts.typeset import typeset_page

    with report_root(data, tables or {}, {"page.typ": source}) as root:
        files = {str(path.relative_to(root)): path for path in root.rglob("*") if path.is_file()}
        return by_typesetter(typeset_page, files, "page.typ").partition("<body>")[2]


def tables_of(results: Path) -> dict[str, Path]:
    """Tables of a run that its report reads."""
    data = json.loads((results / "report/report.json").read_text(encoding="utf-8"))
    found = {path.stem: path for path in (results / "treadmill_models").glob("*.csv")}
    found |= {path.stem: path for path in (results / "tables").glob("*.csv")}
    # the kept campaign and the kept studies with other plates, which the report of the thesis's study quotes
    found.setdefault("coverage", REPORT.parent / "benchmarks/coverage/coverage.csv")
    found.setdefault("plate_constants", REPORT.parent / "benchmarks/plate_constants.csv")
    return {name: found[name] for name in data["tables_read"]}


def chapter_words(
    name: str,
    data: Mapping,
    tables: Mapping[str, str | Path] | None = None,
    cells: str = "",
    struck: bool = False,
) -> str:
    """Words of a chapter of the article and its supplement, without references; arguments as above."""
    parts = "".join(f'#include "chapters/{part}.typ"\n' for part in parts_of(name))
    return typeset_words(f"#show ref: none\n{parts}", data, tables, cells, struck)


def parts_of(chapter: str) -> list[str]:
    """A chapter, and what continues it in the supplement; of every study, the chapters on the whole."""
    if chapter == "study":
        return ["reproduction", "recovery"]
    return [part for part in (chapter, f"{chapter}_further") if (REPORT / f"chapters/{part}.typ").is_file()]
