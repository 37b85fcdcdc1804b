"""A text table of any columns: their names and contents, and what such a table may hold."""

import re
from collections import Counter
from pathlib import Path

import numpy as np

from tepsipe.arguments import unit_in
from tepsipe.errors import InputError, listed, quoted
from tepsipe.io.file_format import Channel, Contents, Format
from tepsipe.io.readers.plain_file import read_text, without_comments
from tepsipe.io.readers.plain_table import DELIMITERS, column_names
from tepsipe.io.readers.recording import Markers
from tepsipe.io.readers.signal_table import read_table_recording
from tepsipe.io.readers.text_table import read_text_table


def commonest_delimiter(header: str) -> str:
    """Character between the columns of a table with this header: tab, semicolon or comma."""
    return max("\t;,", key=header.count)


def table_columns(path: Path) -> tuple[list[str], str]:
    """Names of a text table's columns, and the character between them."""
    text, _ = without_comments(read_text(path, "a table of samples"))
    header = text.partition("\n")[0].rstrip("\r")
    delimiter = commonest_delimiter(header)
    names = column_names(header, delimiter)
    numbers = sum(bool(re.fullmatch(r"[-+]?[\d.]+(e[-+]?\d+)?", name, re.IGNORECASE)) for name in names)
    if len(names) < 2 or numbers > len(names) // 2:
        raise InputError(
            f"{path}: expected a header that names at least two columns, found {quoted(header)}: add a "
            "first line with a name for every column"
        )
    return names, delimiter


def table_contents(path: Path) -> Contents:
    """Contents of a text table (units by the names of its columns); columns of text are named only."""
    names, delimiter = table_columns(path)
    unique = {name: name for name, count in Counter(names).items() if name and count == 1}
    texts: list[str] = []
    columns = read_text_table(path, dict(unique), delimiter, texts=texts)
    time = next((name for name in columns if re.match(r"time|zeit|t\b|t_|t \(", name, re.IGNORECASE)), None)
    rate, facts = None, {"delimiter": next(name for name, d in DELIMITERS.items() if d == delimiter)}
    if time is not None:
        seconds = columns[time] * {"ms": 1e-3, "us": 1e-6}.get(unit_in(time), 1.0)
        steps = np.diff(seconds[np.isfinite(seconds)])
        if steps.size and np.median(steps) > 0.0:
            rate = float(1.0 / np.median(steps))
            facts["duration"] = f"{steps.sum():.6g} s"
            facts["steps of time"] = (
                f"{steps.min():.4g} to {steps.max():.4g} s, median {np.median(steps):.4g} s"
            )
    if texts:
        facts["columns of text"] = ", ".join(name for name in unique if name not in columns)
    return Contents(
        "text table", facts, [Channel.of(name, unit_in(name), rate, x) for name, x in columns.items()]
    )


def table_markers(path: str | Path) -> Markers:
    """Markers of a text table (m)."""
    recording = read_table_recording(path)
    if recording.markers is None:
        raise InputError(
            f"{path}: expected columns of markers, such as HEEL_x, HEEL_y and HEEL_z, found "
            f"{listed(recording.channels)}: name the coordinates of every marker in the header"
        )
    return recording.markers


FORMAT = Format(
    name="a text table",
    fits=lambda head: bool(re.search(r"[\t;,]", head.first_line)),
    contents=table_contents,
    endings=(".csv", ".tsv", ".txt"),
    text=True,
    needs_ending=True,
    purpose="table",
    lacks=("markers",),
    page="tables.md",
    read_recording=read_table_recording,
    read_markers=table_markers,
)
