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
from tepsipe.reporting.numbers.format import LABELS, _printed, fixed, number

# noisy signals, columns of Table 4-4
NOISY = {"tau": "τ", "theta": "θ"}
COUNTED = (REPRODUCED, FITTED, PREDICTED, EXPLAINED)


def cells_data(rows: list[CellVerdict]) -> dict:
    """Counts of verdicts by table, and the cells that are not reproduced, as text (each in its unit)."""
    tables = list(dict.fromkeys(row.table for row in rows))
    # table and reason -> row -> cells: one reason for all cells that it explains
    outside: dict[tuple[str, str], dict[str, list[str]]] = {}
    for row in rows:
        if row.verdict == NOT_REPRODUCED:
            value = fixed(row.value, 2) if row.row.startswith("VAF") else number(row.value, 3)
            values = f"{NOISY.get(row.column, short_name(row.column))} ({_printed(row.reported)}, {value})"
            own = outside.setdefault((row.table, row.reason), {})
            own.setdefault(LABELS.get(row.row, row.row), []).append(values)
    return {
        "total": str(len(rows)),
        "within": str(sum(row.verdict in COUNTED for row in rows)),
        **{v.replace(" ", "_"): str(sum(row.verdict == v for row in rows)) for v in VERDICTS},
        "noisy": _noisy(rows),
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
                "count": str(sum(map(len, cells.values()))),
                "cells": "; ".join(f"{row}: {', '.join(values)}" for row, values in cells.items()),
                "reason": reason,
            }
            for (table, reason), cells in outside.items()
        ],
    }


def name_of(table: str) -> str:
    """Number of a table as the thesis prints it (no unit), for example 4-2 for table_4_2."""
    return table.removeprefix("table_").replace("_", "-")


def _noisy(rows: list[CellVerdict]) -> dict[str, str] | None:
    """Rows of Table 4-4 (no unit) of which all, some or no cells with noise lie within; None without them."""
    held: dict[str, list[bool]] = {}
    for row in rows:
        if row.table == "table_4_4" and row.column != "none":
            held.setdefault(LABELS.get(row.row, row.row), []).append(row.verdict in COUNTED)
    if not held:
        return None
    kinds = {"all": all, "none": lambda found: not any(found)}
    named = {kind: [label for label, found in held.items() if rule(found)] for kind, rule in kinds.items()}
    named["some"] = [label for label in held if label not in named["all"] + named["none"]]
    return {kind: "; ".join(labels) for kind, labels in named.items()}
