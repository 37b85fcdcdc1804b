"""Expressions of the report's sources, evaluated by Typst with altered data and tables."""

import json
import shutil
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

import typst

REPORT = Path(__file__).parents[1] / "report"


def evaluated(
    expressions: Sequence[str],
    imports: str,
    data: Mapping | None = None,
    tables: Mapping[str, str] | None = None,
    files: Mapping[str, str] | None = None,
) -> list:
    """Values of Typst expressions, in code mode, after ``imports`` of the report's sources.

    Parameters
    ----------
    expressions : sequence of str
        For example ``num(1.5)``; their values must be text, numbers, truth values, arrays or dictionaries.
    imports : str
        For example ``format.typ``: sources of which everything is imported, separated by spaces.
    data : mapping, optional
        Content of report.json.
    tables : mapping of str to str, optional
        Name of a table -> its text (CSV).
    files : mapping of str to str, optional
        Name of another file below the root -> its text.
    """
    tables, files = tables or {}, files or {}
    with tempfile.TemporaryDirectory() as folder:
        root = Path(folder) / "report"
        shutil.copytree(REPORT, root)
        (root / "tables").mkdir()
        content = {"tables_read": list(tables), **(data or {})}
        (root / "report.json").write_text(json.dumps(content), encoding="utf-8")
        for name, text in tables.items():
            (root / f"tables/{name}.csv").write_text(text, encoding="utf-8")
        for name, text in files.items():
            (root / name).write_text(text, encoding="utf-8")
        lines = [f'#import "{name}": *' for name in imports.split()]
        lines.append("#metadata((" + "".join(f"{{ {e} }}, " for e in expressions) + ")) <values>")
        (root / "expressions.typ").write_text("\n".join(lines), encoding="utf-8")
        (found,) = json.loads(typst.query(str(root / "expressions.typ"), "<values>", root=str(root)))
    return found["value"]
