"""Writing of a CSV file: numbers with ten significant digits, the same on every machine."""

import csv
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any


def write_cells(path: str | Path, names: Sequence[str], rows: Iterable[Iterable]) -> None:
    """Write values below the names of their columns."""
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(names)
        writer.writerows(map(_cell, row) for row in rows)


def write_records(path: str | Path, rows: Sequence[Mapping[str, Any]]) -> None:
    """Write rows; the columns are the keys of the first one."""
    write_cells(path, list(rows[0]), ([row[name] for name in rows[0]] for row in rows))


def _cell(value) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, tuple):
        return " ".join(map(_cell, value))
    return f"{value:.10g}" if isinstance(value, float) else str(value)
