"""Delimited text with a header line: D-Flow logs, torque commands, plain tables of signals."""

import difflib
import re
from pathlib import Path

import numpy as np

from tepsipe.arguments import IN_NAMES
from tepsipe.errors import InputError, listed, quoted
from tepsipe.io.readers.plain_file import read_text
from tepsipe.io.readers.plain_table import number_in, refuse_short_header, with_points

# unit -> its spellings in headers; small letters, without spaces, dots, stars, carets, hyphens, underscores
SPELLINGS = {
    "s": "s sec secs second seconds",
    "N": "n newton newtons",
    "Nm": "nm newtonmetre newtonmetres newtonmeter newtonmeters",
    "rad": "rad radian radians",
    "deg": "deg ° degree degrees grad",
    "m/s": "m/s m/sec ms1 mps metres/second meters/second metrespersecond meterspersecond",
}
KNOWN_UNITS = " ".join(
    (
        *SPELLINGS.values(),
        "ns us µs μs ms msec millisecond milliseconds min minutes h hr hrs hours",
        "mn dan kn kilonewton kgf kp lb lbs lbf pound pounds n/kg",
        "nmm ncm mnm knm kgm kgfm kpm ftlb ftlbf lbft lbfft inlb inlbf lbin lbfin nm/kg",
        "mm/s cm/s km/s mm/sec cm/sec m/min m/h km/h kmh kph km/hr mph mi/h miles/h ft/s ft/min fpm fps in/s",
        "rpm rad/s deg/s °/s hz khz mrad mm cm m km in ft m/s2 m/s² g kg mv μv v volt volts",
        "count counts bit bits %",
    )
).split()


def read_text_table(
    path: str | Path,
    columns: dict[str, str | None],
    delimiter: str,
    named_by: dict[str, str] | None = None,
    units: dict[str, str] | None = None,
) -> dict[str, np.ndarray]:
    """Read named columns of a text file whose first line names them.

    A last line without a line break may have been cut within its last number, so it is omitted. Commas are
    decimal signs where they do not separate columns.

    path: text file; a name that ends in ``.gz`` is decompressed.
    columns: key under which a column is returned -> its name in the file's header; None where the file has
    none.
    delimiter: character between columns.
    named_by: key -> where its column's name was given, for messages; by default the configuration.
    units: key -> unit in which its samples are read: a name that ends in another one is refused.
    Returns: one array per key of ``columns`` with a name, in the file's units.
    """
    path = Path(path)
    columns = {key: name for key, name in columns.items() if name is not None}
    _refuse_one_column_twice(path, columns, named_by or {})
    text = read_text(path, "a table of samples")
    if not text.strip():
        raise InputError(f"{path}: expected a header and samples, found an empty file: record again")
    header, _, body = text.partition("\n")
    names = [name.strip() for name in header.split(delimiter)]
    for key, name in columns.items():
        _refuse_other_names(path, name, (named_by or {}).get(key, "the configuration"), names)
        if units and key in units:
            refuse_other_unit(name, units[key], str(path), key.replace("_", " "))
    lines = body.split("\n")
    ended = not lines[-1].strip()
    while lines and not lines[-1].strip():
        lines.pop()
    if not lines:
        raise InputError(f"{path}: expected samples under the header, found none: record again")
    refuse_short_header(path, len(names), lines, delimiter)
    for number in (len(lines) - 1, *range(len(lines))):
        if lines[number].count(delimiter) != len(names) - 1:
            fields = lines[number].count(delimiter) + 1
            if fields > len(names):
                hint = (
                    f"export the file with a name for every column, and without {quoted(delimiter)} in its "
                    "numbers or at the ends of its lines"
                )
            else:
                state = "the file is truncated" if number == len(lines) - 1 else "the line is damaged"
                hint = f"{state}, copy it again from the instrument"
            raise InputError(
                f"{path}: expected {len(names)} fields on every line, found {fields} on line {number + 2}: "
                f"{hint}"
            )
    if not ended:
        lines.pop()
    if not lines:
        raise InputError(
            f"{path}: expected samples that end with a line break, found one line without: the file is "
            "truncated, copy it again from the instrument"
        )
    wanted = [names.index(name) for name in columns.values()]
    lines = with_points(lines, delimiter)
    try:
        values = np.loadtxt(lines, delimiter=delimiter, usecols=wanted, ndmin=2, comments=None)
    except ValueError as error:
        values = _numbers_one_by_one(path, lines, delimiter, wanted, names, error)
    return {key: values[:, i] for i, key in enumerate(columns)}


def refuse_other_unit(column: str, unit: str, name: str, what: str = "") -> None:
    """Compare the unit in a column's name with the one expected (s, N, Nm, rad, deg or m/s).

    The unit stands in brackets, or at the end after an underscore. A name without one is accepted, and so is
    a single letter after an underscore, which may be an index. ``N.m``, ``N*m``, ``N m`` and ``Nm`` are one
    unit; so are ``m/s`` and ``m s^-1``.

    unit: unit in which its samples are read; any other text, such as that of an unknown unit, is not
    compared.
    name: names the file in messages.
    what: quantity in the column, for messages.
    """
    ending = re.search(IN_NAMES, column)
    bracketed = re.findall(r"[(\[]([^()\[\]]*)[)\]]", column)
    for written in bracketed or ([ending[1].replace("_per_", "/")] if ending and len(ending[1]) > 1 else []):
        plain = re.sub(r"[\s.·⋅*^_-]", "", written).casefold()
        if unit in SPELLINGS and plain in KNOWN_UNITS and plain not in SPELLINGS[unit].split():
            what = what or {"s": "time", "m/s": "belt velocity"}.get(unit, "load")
            raise InputError(
                f"{name}: expected the {what} in {unit}, found {quoted(written)} in the header "
                f"{quoted(column)}: convert the column, or name another one or its unit"
            )


def _refuse_one_column_twice(path, columns, named_by) -> None:
    """Refuse one column that is named for two signals."""
    seen: dict[str, str] = {}
    for key, name in columns.items():
        other = seen.setdefault(name, key)
        if other != key:
            both, where = f"{other} and {key}".replace("_", " "), named_by.get(key, "the configuration")
            raise InputError(
                f"{path}: expected a column for each signal, found {name!r} for {both}: correct one of the "
                f"two in {where}"
            )


def _refuse_other_names(path, name, where, names) -> None:
    """Refuse a header that lacks the name given for a column, or contains it twice."""
    if names.count(name) > 1:
        raise InputError(
            f"{path}: expected one column named {name!r}, found {names.count(name)}: rename one in the header"
        )
    if name not in names:
        close = difflib.get_close_matches(name, names, n=1, cutoff=0.5)
        if len(names) == 1:
            hint = "the delimiter of the file is not the configured one, correct one of the two"
        elif close:
            hint = f"did you mean {close[0]!r}, to be corrected in {where}?"
        else:
            hint = f"name the file's columns in {where}"
        raise InputError(f"{path}: expected a column named {name!r}, found {listed(names)}: {hint}")


def _numbers_one_by_one(path, lines, delimiter, wanted, names, error) -> np.ndarray:
    """Find the field that is not a number; an empty field is a missing sample (NaN)."""
    values = np.empty((len(lines), len(wanted)))
    for row, line in enumerate(lines):
        fields = line.split(delimiter)
        for column, index in enumerate(wanted):
            field = fields[index].strip()
            try:
                values[row, column] = number_in(field) if field else np.nan
            except ValueError:
                raise InputError(
                    f"{path}: expected a number, found {quoted(field)} in column {names[index]!r} on line "
                    f"{row + 2}: repair the file or export it again"
                ) from error
    return values
