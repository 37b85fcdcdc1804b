"""Reading of a run for a report, and typesetting of the report by Typst."""

import json
import shutil
import tempfile
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from types import ModuleType

import pandas as pd
import typst

from tepsipe.io.result import Result, read_result
from tepsipe.reporting.run import Run

TEXT = dict.fromkeys(("condition", "participant", "belt", "flags", "column", "train", "test", "failed"), str)


def read_run(
    tables: Mapping[str, str], fits: Iterable[str], settings: Mapping, study: Mapping, provenance: str = ""
) -> Run:
    """Run of a report; tables, fits and the record of provenance, if there is one, are files."""
    rows = {name: pd.read_csv(path, dtype=TEXT) for name, path in tables.items()}
    record = json.loads(Path(provenance).read_text(encoding="utf-8")) if provenance else {}
    return Run(rows, _read_fits(fits), settings, study, record)


def table_files(paths: Iterable[str]) -> dict[str, str]:
    """Name of a table -> its file."""
    return {Path(path).stem: path for path in paths}


def _read_fits(paths: Iterable[str]) -> dict[str, dict[str, Result]]:
    """Results below ``fits/``: folder -> name -> result; one without a folder has its name twice.

    A file of JSON, for example of a walking trial, has facts alone.
    """
    fits: dict[str, dict[str, Result]] = {}
    for path in map(Path, paths):
        group = path.stem if path.parent.name == "fits" else path.parent.name
        only_facts = path.suffix == ".json"
        fit = Result({}, {}, json.loads(path.read_text("utf-8"))) if only_facts else read_result(path)
        fits.setdefault(group, {})[path.stem] = fit
    return fits


def chapters(names: Iterable[str]) -> dict[str, ModuleType]:
    """Modules of chapters; the rule lists them as inputs."""
    return {name: import_module(f"tepsipe.reporting.chapters.{name}") for name in names}


def source_files(sources: Iterable[str], folder: str) -> dict[str, str]:
    """Sources of the reports, as seen from their folder."""
    return {str(Path(source).relative_to(folder)): source for source in sources}


def report_files(data: str, tables: Mapping[str, str], figures: Iterable[str] = ()) -> dict[str, str]:
    """Data, tables and figures of a report, as its sources see them."""
    files = {f"figures/{Path(path).name}": path for path in figures}
    return files | {f"tables/{name}.csv": path for name, path in tables.items()} | {"report.json": data}


def write_json(path: str | Path, content: dict) -> None:
    """Write a file of JSON that people can read, too."""
    Path(path).write_text(json.dumps(content, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")


def typeset(files: Mapping[str, str | Path], documents: Mapping[str, str | Path]) -> list[str]:
    """Typeset sources to PDFs, the same bytes from the same files.

    Typst reads below one root only: ``files`` maps paths below it to files. ``documents`` maps a source, one
    of these paths, to its PDF. Documents name each other's sections, figures, tables and equations in words,
    from ``elsewhere.yaml`` (``across`` in ``report/style.typ``).
    Returns: names of the assertions that do not hold in this run (``says`` in ``report/data.typ``).
    """
    with _gathered(files) as root:
        places = {main: _asked(root, main, "<places>") for main in documents} if len(documents) > 1 else {}
        failed: list[str] = []
        for main, pdf in documents.items():
            others = (own for other, found in places.items() if other != main for own in found)
            elsewhere = {label: words for own in others for label, words in own.items()}
            write_json(root / "elsewhere.yaml", elsewhere)
            _compiler(root, main).compile(output=pdf, timestamp=0, pdf_standards="a-2b")
            failed += _asked(root, main, "<not-in-this-run>")
    return list(dict.fromkeys(failed))


def _compiler(root: Path, main: str) -> typst.Compiler:
    return typst.Compiler(str(root / main), root=str(root), ignore_system_fonts=True)


def _asked(root: Path, main: str, selector: str) -> list:
    """Values of the metadata with a label in the source ``main``."""
    return json.loads(_compiler(root, main).query(selector, field="value"))


def typeset_page(files: Mapping[str, str | Path], main: str) -> str:
    """Typeset the source ``main`` as HTML, to be framed by `tepsipe.reporting.report_page`."""
    with _gathered(files) as root:
        page = typst.compile(
            str(root / main),
            root=str(root),
            format="html",
            ignore_system_fonts=True,
            sys_inputs={"web": "true"},
        )
    return page.decode()


@contextmanager
def _gathered(files: Mapping[str, str | Path]) -> Iterator[Path]:
    """A root with all files of a report."""
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder)
        for name, path in files.items():
            (root / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(path, root / name)
        yield root
