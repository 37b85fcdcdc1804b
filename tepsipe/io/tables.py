"""Tables of results as CSV: one dataclass per table, one field per column.

The annotation of a field is the type of its column:

    str                 text
    int, float          number; ten significant digits are written
    Undefinable         number that may be undefined: NaN or infinite, and then an empty cell
    bool                true or false
    tuple[float, ...]   numbers separated by blanks
    ... | None          as above; None is an empty cell
"""

import csv
import io
import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, fields
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Any, Generic, TypeVar, get_args, get_origin, get_type_hints

from tepsipe.errors import InputError, listed, quoted
from tepsipe.io.readers.plain_file import read_text

Row = TypeVar("Row")
Undefinable = Annotated[float, "an empty cell is NaN"]
NO_COLUMN = {"column": False}  # metadata of a field that is not a column


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


@dataclass(frozen=True)
class Table(Generic[Row]):
    """A kind of table; a column has one unit, or a column ``unit`` gives the unit of each row."""

    row: type[Row]
    """Dataclass of the rows."""
    what: str
    """Name of the rows in messages."""
    check: Callable[[Row], None] | None = None
    """Raises ValueError for a row that no study writes."""
    complete: Callable[[Row], Row] | None = None
    """Applied to every row before it is written."""
    further: tuple[str, ...] = ()
    """Columns that may follow; they are written from a separate list of cells and not read."""

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns; a name ends in the unit of its column, if that has one."""
        return tuple(field.name for field in fields(self.row) if field.metadata.get("column", True))

    def write(
        self,
        path: str | Path,
        rows: Iterable[Row],
        *,
        without: tuple[str, ...] = (),
        further: Mapping[str, Sequence[str]] = MappingProxyType({}),
    ) -> None:
        """Write rows in their units.

        Columns ``without`` are left out; ``further`` has one cell per row and column.
        """
        names = [name for name in self.columns if name not in without]
        blank = {name for name, kind in self._types().items() if kind is Undefinable}
        cells = []
        for number, row in enumerate(rows):
            row = row if self.complete is None else self.complete(row)
            values = ((name, getattr(row, name)) for name in names)
            cells_of_row = [None if name in blank and not math.isfinite(x) else x for name, x in values]
            cells.append([*cells_of_row, *(column[number] for column in further.values())])
        write_cells(path, [*names, *further], cells)

    def read(self, *paths: str | Path) -> list[Row]:
        """Read the rows of some files, in their units; the files were written with all columns."""
        return [row for path in paths for row in self._rows(path)]

    def _rows(self, path: str | Path) -> list[Row]:
        reader = csv.reader(io.StringIO(read_text(path, self.what, ended=True)), strict=True)
        try:
            names = tuple(next(reader, ()))
            end = len(self.columns)
            if names[:end] != self.columns or not set(names[end:]) <= set(self.further):
                raise InputError(
                    f"{path}: expected the columns {', '.join(self.columns)}, found {listed(names)}: make "
                    "the file again"
                )
            columns = {name: _reading(kind, name) for name, kind in self._types().items()}
            return [self._row(cells, len(names), columns) for cells in reader if cells]
        except InputError:
            raise
        except (ValueError, csv.Error) as error:
            raise InputError(
                f"{path}: expected {self.what}, found a damaged row ({quoted(error)}): make the file again"
            ) from error

    def _types(self) -> dict[str, Any]:
        hints = get_type_hints(self.row, include_extras=True)
        return {name: hints[name] for name in self.columns}

    def _row(self, cells: list[str], length: int, columns: dict[str, Callable[[str], Any]]) -> Row:
        if len(cells) != length:
            raise ValueError("too many or too few cells")
        named = zip(columns.items(), cells, strict=False)  # further columns are not read
        row = self.row(**{name: read(cell) for (name, read), cell in named})
        if self.check is not None:
            self.check(row)
        return row


def _reading(kind: Any, column: str) -> Callable[[str], Any]:
    """What makes a value of a cell; chosen once for a column, because tables have many cells."""
    if kind is Undefinable:
        return lambda cell: float(cell) if cell else math.nan
    if get_origin(kind) is Annotated:  # a unit
        return _reading(get_args(kind)[0], column)
    kinds = get_args(kind)
    if type(None) in kinds:
        read = _reading(kinds[0], column)
        return lambda cell: read(cell) if cell else None
    if kind is bool:
        return partial(_truth, column)
    return (lambda cell: tuple(map(float, cell.split()))) if kinds else kind


def _truth(column: str, cell: str) -> bool:
    if cell not in ("true", "false"):
        raise ValueError(f"{cell!r} in the column {column}")
    return cell == "true"
