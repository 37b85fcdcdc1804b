"""Numbers of the ledger: how many printed cells have which verdict, and which are not reproduced."""

from tepsipe.reporting.figures.names import short_name
from tepsipe.reporting.ledger import (
    EXPLAINED,
    FITTED,
    NOT_REPRODUCED,
    PREDICTED,
    REPRODUCED,
    VERDICTS,
    CellVerdict,
)
from tepsipe.reporting.numbers.format import number
from tepsipe.reporting.numbers.study import LABELS

COUNTED = (REPRODUCED, FITTED, PREDICTED, EXPLAINED)


def cells_data(rows: list[CellVerdict]) -> dict:
    """Counts of verdicts by table, and the cells that are not reproduced, as text (each in its unit)."""
    tables = list(dict.fromkeys(row.table for row in rows))
    outside: dict[tuple[str, str, str], list[str]] = {}
    for row in rows:
        if row.verdict == NOT_REPRODUCED:
            values = f"{short_name(row.column)} ({number(row.reported, 4)}, {number(row.value, 4)})"
            outside.setdefault((row.table, row.row, row.reason), []).append(values)
    return {
        "total": str(len(rows)),
        "within": str(sum(row.verdict in COUNTED for row in rows)),
        **{v.replace(" ", "_"): str(sum(row.verdict == v for row in rows)) for v in VERDICTS},
        "verdicts": list(VERDICTS),
        "tables": [
            {
                "table": name_of(table),
                "counts": [str(sum((r.table, r.verdict) == (table, v) for r in rows)) for v in VERDICTS],
            }
            for table in tables
        ],
        "outside": [
            {
                "table": name_of(table),
                "row": LABELS.get(row, row),
                "cells": ", ".join(cells),
                "reason": reason,
            }
            for (table, row, reason), cells in outside.items()
        ],
    }


def name_of(table: str) -> str:
    """Number of a table as the thesis prints it (no unit), for example 4-2 for table_4_2."""
    return table.removeprefix("table_").replace("_", "-")
