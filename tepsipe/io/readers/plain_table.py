"""Text tables of numbers with unknown columns: D-Flow, TRC, exports of EMG, plain CSV.

`tepsipe.io.readers.text_table.read_text_table` reads named columns of a table that a configuration
describes; here every column is read, and the delimiter and the decimal sign are found in the file.
"""

import csv
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np

from tepsipe.errors import InputError, listed, quoted
from tepsipe.io.readers.plain_file import read_text

NUMBER = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)(e[-+]?\d+)?|[-+]?(nan|inf)", re.IGNORECASE)
DECIMAL_COMMA = re.compile(r"[-+]?\d*,\d+(e[-+]?\d+)?", re.IGNORECASE)
# a larger number is not a measurement, and would overflow when its unit is converted
LARGEST = 1e100
# name of a delimiter in a configuration -> character between columns
DELIMITERS = {"comma": ",", "tab": "\t", "semicolon": ";"}


@dataclass(frozen=True)
class PlainTable:
    """All columns of a text table."""

    name: str
    """Names the file in messages."""
    preamble: tuple[str, ...]
    """Lines above the header."""
    names: tuple[str, ...]
    """Names of the columns."""
    values: Annotated[np.ndarray, "(n, columns)"]
    """Numbers in the units of the file; NaN where a field is empty or infinite."""
    lines: np.ndarray
    """Line of the file on which each row stands."""
    delimiter: str
    """Character between columns."""

    def column(self, name: str) -> np.ndarray:
        """Numbers of the only column of a name, shape (n,), in the unit of the file."""
        if self.names.count(name) != 1:
            raise InputError(
                f"{self.name}: expected one column named {name!r}, found {self.names.count(name)} among "
                f"{listed(dict.fromkeys(self.names))}: correct the name in the configuration or in the header"
            )
        return self.values[:, self.names.index(name)]


def number_in(field: str) -> float:
    """Number in a field of text; ``float`` alone would read a damaged ``1_0`` as 10."""
    if "_" in field:
        raise ValueError(f"could not convert string to float: {field!r}")
    return float(field)


def delimiter_in(header: str) -> str:
    """Character between the columns of a table with this header: tab, semicolon or comma."""
    if header.count("\t"):
        return "\t"
    return ";" if header.count(";") else ","


def column_names(header: str, delimiter: str) -> list[str]:
    """Names in a header line, without quotes and surrounding spaces."""
    try:
        return [name.strip() for name in next(csv.reader([header], delimiter=delimiter), [])]
    except csv.Error:  # a name that is longer than any
        return [name.strip() for name in header.split(delimiter)]


def read_plain_table(
    path: str | Path, what: str, is_header: Callable[[str], bool] | None = None, ragged: bool = False
) -> PlainTable:
    """Read all columns of a text table.

    Lines that begin with ``#`` and empty lines are skipped. A last line without a line break may have been
    cut within its last number, so it is omitted. Commas are decimal signs where they do not separate columns.

    path: the file, plain or compressed with gzip.
    what: expected kind of file, for messages.
    is_header: whether a line is the header; by default the first line that is not skipped.
    ragged: whether rows may end before the header does, as columns of a lower rate do; what is missing is
    NaN.
    Returns: numbers in the units of the file.
    """
    path = Path(path)
    text = read_text(path, what)
    lines = text.split("\n")
    ended = lines[-1].strip() == ""
    used = [k for k, line in enumerate(lines) if line.strip() and not line.lstrip().startswith("#")]
    header = next((k for k in used if is_header is None or is_header(lines[k])), None)
    if header is None:
        first_line = quoted(lines[used[0]]) if used else "an empty file"
        raise InputError(
            f"{path}: expected the header of {what}, found {first_line}: check which file is named"
        )
    delimiter = delimiter_in(lines[header])
    names = column_names(lines[header], delimiter)
    if sum(bool(NUMBER.fullmatch(name)) for name in names) > len(names) // 2:
        raise InputError(
            f"{path}: expected a header that names the columns, found {quoted(lines[header])}: add a first "
            "line with a name for every column"
        )
    rows = [k for k in used if k > header]
    if not rows:
        raise InputError(f"{path}: expected samples under the header, found none: record or export it again")
    body = [lines[k] for k in rows]
    if not names[-1]:  # the header ends with a delimiter, and rows may
        names.pop()
        body = [line if ragged else line.rstrip("\r ").removesuffix(delimiter) for line in body]
    _refuse_other_counts(path, body, rows, delimiter, len(names), ragged)
    if not ended:
        body.pop()
        rows.pop()
    if not rows:
        raise InputError(
            f"{path}: expected samples that end with a line break, found one line without: the file is "
            "truncated, copy it again from the instrument"
        )
    values = _numbers(path, body, rows, delimiter, names, ragged)
    values[np.isinf(values)] = np.nan
    large = np.argwhere(np.abs(values) > LARGEST)
    if large.size:
        row, column = large[0]
        raise InputError(
            f"{path}: expected numbers that can be measured, found {values[row, column]:g} in column "
            f"{names[column]!r} on line {rows[row] + 1}: repair the file or export it again"
        )
    return PlainTable(str(path), tuple(lines[:header]), tuple(names), values, np.array(rows) + 1, delimiter)


def refuse_short_header(path: Path, count: int, body: list[str], delimiter: str) -> None:
    """Refuse a header of ``count`` names above lines that all have the same larger number of fields."""
    counts = [line.rstrip(f"{delimiter} ").count(delimiter) + 1 for line in body]
    usual = counts[-1]
    decimal = delimiter == "," and usual == 2 * count  # with commas as decimal signs, too
    if usual > count + 1 and not decimal and len(counts) > 2 * counts.count(usual) - len(counts) > 0:
        first = quoted(body[counts.index(usual)].strip())
        raise InputError(
            f"{path}: expected the names of {usual} columns in the header, found {count} names there, and "
            f"{first} further down: export the trial as C3D or TRC, or give every column a name in the first "
            "line"
        )


def _refuse_other_counts(path, body, rows, delimiter, count, ragged) -> None:
    """Refuse a row with more fields than the header or, unless rows may be short, with fewer."""
    refuse_short_header(path, count, body, delimiter)
    for k in (len(body) - 1, *range(len(body))):
        fields = body[k].count(delimiter) + 1
        long = fields > count and body[k].rstrip(delimiter).count(delimiter) + 1 > count
        if long or (fields < count and not ragged):
            cut = k == len(body) - 1 and not long
            if cut:
                hint = "the file is truncated, copy it again from the instrument"
            elif long and delimiter == ",":
                hint = "if commas are decimal signs, export it with decimal points or semicolons"
            else:
                hint = "the line is damaged, copy the file again from the instrument"
            raise InputError(
                f"{path}: expected {count} fields on every line, found {fields} on line {rows[k] + 1}: {hint}"
            )


def _numbers(path, body, rows, delimiter, names, ragged) -> np.ndarray:
    """Numbers of all rows; a field that is empty is NaN."""
    body = with_points(body, delimiter)
    if not ragged:
        try:
            return np.loadtxt(body, delimiter=delimiter, ndmin=2, comments=None, usecols=range(len(names)))
        except ValueError:
            pass  # an empty field, or one that is no number
    values = np.full((len(body), len(names)), np.nan)
    for i, line in enumerate(body):
        for j, field in enumerate(line.split(delimiter)[: len(names)]):
            try:
                if field and not field.isspace():
                    values[i, j] = number_in(field)
            except ValueError:
                raise InputError(
                    f"{path}: expected a number, found {quoted(field.strip())} in column {names[j]!r} on "
                    f"line {rows[i] + 1}: repair the file or export it again"
                ) from None
    return values


def with_points(body: list[str], delimiter: str) -> list[str]:
    """Lines with decimal points in place of commas that do not separate columns."""
    if delimiter == "," or not any("," in line for line in body):
        return body
    return [line.replace(",", ".") if _commas_are_decimal(line, delimiter) else line for line in body]


def _commas_are_decimal(line: str, delimiter: str) -> bool:
    """Test for a line without decimal points, beside which commas separate thousands."""
    fields = (field.strip() for field in line.split(delimiter))
    return "." not in line and all("," not in field or DECIMAL_COMMA.fullmatch(field) for field in fields)
