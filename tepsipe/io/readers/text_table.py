"""Delimited text with a header line: D-Flow logs, torque commands, plain tables of signals."""

import difflib
import re
from collections import Counter
from pathlib import Path

import numpy as np

from tepsipe.arguments import IN_NAMES
from tepsipe.errors import InputError, listed, quoted
from tepsipe.io.readers.plain_file import read_text, without_comments
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
    texts: list[str] | None = None,
) -> dict[str, np.ndarray]:
    """Read named columns of a text file whose first line, after any that begin with ``#``, names them.

    A last line without a line break may have been cut within its last number, so it is omitted. Commas are
    decimal signs where they do not separate columns.

    path: text file; a name that ends in ``.gz`` is decompressed.
    columns: key under which a column is returned -> its name in the file's header; None where the file has
    none.
    delimiter: character between columns.
    named_by: key -> where its column's name was given, for messages; by default the configuration.
    units: key -> unit in which its samples are read: a name that ends in another one is refused.
    texts: receives the keys of columns that contain text, which are not returned; None to refuse them.
    Returns: one array per key of ``columns`` with a name, in the file's units.
    """
    path = Path(path)
    columns = {key: name for key, name in columns.items() if name is not None}
    _refuse_one_column_twice(path, columns, named_by or {})
    text, comments = without_comments(read_text(path, "a table of samples"))
    if not text.strip():
        raise InputError(f"{path}: expected a header and samples, found an empty file: record again")
    header, _, body = text.partition("\n")
    names = [name.strip() for name in header.split(delimiter)]
    counts, places = Counter(names), {name: place for place, name in enumerate(names)}
    for key, name in columns.items():
        if counts[name] != 1:
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
                f"{path}: expected {len(names)} fields on every line, found {fields} on line "
                f"{comments + number + 2}: "
                f"{hint}"
            )
    if not ended:
        lines.pop()
    if not lines:
        raise InputError(
            f"{path}: expected samples that end with a line break, found one line without: the file is "
            "truncated, copy it again from the instrument"
        )
    lines = with_points(lines, delimiter)
    wanted = {key: places[name] for key, name in columns.items()}
    if texts is not None:  # most columns of text have one in their first line
        first = lines[0].split(delimiter)
        texts += [key for key, place in wanted.items() if _is_text(first[place])]
        wanted = {key: place for key, place in wanted.items() if not _is_text(first[place])}
    if not wanted:
        return {}
    try:
        values = np.loadtxt(lines, delimiter=delimiter, usecols=list(wanted.values()), ndmin=2, comments=None)
    except ValueError as error:
        values, later = _numbers_one_by_one(
            path, lines, comments, delimiter, wanted, names, error, texts is not None
        )
        if texts is not None:
            texts += later
            wanted = {key: place for key, place in wanted.items() if key not in later}
    return dict(zip(wanted, values.T, strict=True))


def _is_text(field: str) -> bool:
    """Test for a field that is neither empty nor a number."""
    try:
        number_in(field.strip() or "nan")
    except ValueError:
        return True
    return False


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


def _numbers_one_by_one(
    path, lines, comments, delimiter, wanted, names, error, keep_text
) -> tuple[np.ndarray, dict[str, int]]:
    """Numbers of all columns but those of text, and the keys of these; an empty field is NaN.

    wanted: key -> place of its column.
    keep_text: False to refuse a field that is not a number.
    """
    values = np.empty((len(lines), len(wanted)))
    texts: dict[str, int] = {}
    for row, line in enumerate(lines):
        fields = line.split(delimiter)
        for column, (key, index) in enumerate(wanted.items()):
            field = fields[index].strip()
            try:
                values[row, column] = number_in(field) if field else np.nan
            except ValueError:
                if keep_text:
                    texts[key] = column
                    continue
                raise InputError(
                    f"{path}: expected a number, found {quoted(field)} in column {names[index]!r} on line "
                    f"{comments + row + 2}: repair the file or export it again"
                ) from error
    return np.delete(values, list(texts.values()), axis=1), texts
