"""Header and rows of the tab-separated sheets that people write."""

import difflib
from collections.abc import Sequence
from pathlib import Path

from tepsipe.errors import InputError, quoted
from workflow.support.placeholders import refuse_placeholder_cells


def refuse_columns(header: list[str], known: Sequence[str], path: str | Path) -> None:
    """Refuse unknown and repeated columns."""
    for name in header:
        if name not in known:
            close = difflib.get_close_matches(name, known, n=1, cutoff=0.5)
            hint = f"did you mean {close[0]!r}?" if close else f"known: {', '.join(known)}"
            raise InputError(f"{path}: unknown column {quoted(name)}: {hint}")
        if header.count(name) > 1:
            raise InputError(f"{path}: expected the column {quoted(name)} once, found it twice: remove one")


def named_cells(cells: list[str], header: list[str], number: int, path: str | Path) -> dict[str, str]:
    """Cells of a line by the names of their columns; one without a value, or too many, is refused."""
    if len(cells) != len(header):
        raise InputError(
            f"{path}: expected {len(header)} cells, found {len(cells)} on line {number}: separate them by "
            "one tab each"
        )
    named = dict(zip(header, map(str.strip, cells), strict=True))
    refuse_placeholder_cells(named, f"{path}: line {number}")
    return named
