"""Rows of a table as CSV: one dataclass per table, one field per column."""

import csv
import io
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import fields
from pathlib import Path

from tepsipe.errors import InputError, listed, quoted
from tepsipe.io.readers.text_file import read_text


def column_names(kind: type) -> tuple[str, ...]:
    """Columns of the table whose rows are of the dataclass ``kind`` (no unit)."""
    return tuple(field.name for field in fields(kind))


def write_rows(
    path: str | Path,
    kind: type,
    rows: Iterable,
    without: tuple[str, ...] = (),
    further: Mapping[str, Sequence[str]] | None = None,
) -> None:
    """Write rows of the dataclass ``kind``, numbers with 10 significant digits (units as in ``kind``).

    None is an empty cell; truth values are true and false. Columns ``without`` are not written; those of
    ``further`` follow the others, with one cell per row.
    """
    names = [name for name in column_names(kind) if name not in without]
    further = further or {}
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow([*names, *further])
        for number, row in enumerate(rows):
            cells = [column[number] for column in further.values()]
            writer.writerow([*(_cell(getattr(row, name)) for name in names), *cells])


def _cell(value) -> str:
    if value is None:
        return ""
    if isinstance(value, bool):
        return str(value).lower()
    return f"{value:.10g}" if isinstance(value, float) else str(value)


def read_rows(
    path: str | Path,
    kind: type,
    row: Callable[[dict[str, str]], object],
    what: str,
    further: tuple[str, ...] = (),
) -> list:
    """Read a table written by `write_rows` (units as in ``kind``).

    Parameters
    ----------
    path : str or Path
        The table.
    kind : type
        Dataclass of its rows.
    row : callable
        Makes a row of its cells; raises ValueError where they cannot be one.
    what : str
        What the rows are, in messages.
    further : tuple of str
        Columns that may follow those of ``kind``; they are not read.

    Returns
    -------
    list
        Of ``kind``.

    Raises
    ------
    InputError
        If the file is missing, truncated or not text, its columns are not those of ``kind``, or a row is
        damaged.
    """
    reader = csv.DictReader(io.StringIO(read_text(path, what, ended=True)), strict=True)
    try:
        own = column_names(kind)
        names = tuple(reader.fieldnames or ())
        if names[: len(own)] != own or not set(names[len(own) :]) <= set(further):
            raise InputError(
                f"{path}: expected the columns {', '.join(column_names(kind))}, found "
                f"{listed(reader.fieldnames or [])}: make the file again"
            )
        return [row({name: _complete(cells)[name] for name in own}) for cells in reader]
    except InputError:
        raise
    except (ValueError, csv.Error) as error:
        raise InputError(
            f"{path}: expected {what}, found a damaged row ({quoted(error)}): make the file again"
        ) from error


def _complete(cells: dict) -> dict[str, str]:
    if None in cells or None in cells.values():
        raise ValueError("too many or too few cells")
    return cells
