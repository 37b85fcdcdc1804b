"""Tables of the thesis: estimates beside the reported values (4-1 to 4-3), and the noise study (4-4)."""

import csv
import io
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tepsipe.errors import InputError, quoted
from tepsipe.io.estimates import Estimate
from tepsipe.io.readers.plain_file import read_text
from tepsipe.io.result import Result
from tepsipe.io.tables import write_cells
from tepsipe.mechanics.impedance_model import PARAMETERS
from tepsipe.statistics.least_squares import SEM_READINGS

# SEM_<reading>_x is the SEM of one perturbation by a reading of eq (3-2), SE_x the standard error of the mean
# over all perturbations
SEM_ROWS = [f"SEM_{reading}_{quantity}" for reading in SEM_READINGS for quantity in PARAMETERS]
PARAMETER_ROWS = [*PARAMETERS, *SEM_ROWS]
MEANS = [*PARAMETER_ROWS, *(f"SE_{quantity}" for quantity in PARAMETERS), "VAF_perturbation", "VAF_trial"]
ROWS = {
    "table_4_1": [*PARAMETER_ROWS, "error", "VAF_trial", "VAF_cross_validated"],
    "table_4_2": MEANS,
    "table_4_3": MEANS,
}
TABLE_COLUMNS = ("none", "tau", "theta", "both")
AS_SEM = "as printed"  # unit of an SEM by the Euclidean norm
EXPERIMENT = {"table_4_1": "wristalyzer", "table_4_2": "dummy", "table_4_3": "dummy"}


@dataclass(frozen=True)
class TableRow:
    """One row of a thesis table."""

    pathway: str
    estimator: str
    quantity: str
    unit: str
    """Content of the row."""
    values: list[float | None]
    """One value per condition (``unit``)."""
    reported: list[float | None]
    """Values in the thesis (``unit``); None where there is none."""


def lay_out_table(
    table: str,
    estimates: list[Estimate],
    reported: dict[str, dict[str, float]],
    conditions: list[str],
    blocks: list[tuple[str, str | None]],
    fits: dict[str, Result] | None = None,
) -> list[TableRow]:
    """Arrange estimates as in the thesis, in one block per pathway.

    table: {"table_4_1", "table_4_2", "table_4_3"}: Which table.
    reported: quantity -> condition -> value in the thesis (unit of the quantity); may be empty.
    conditions: Columns.
    blocks: one block of rows each; None selects the estimator of the pathway.
    fits: condition -> fit, with SEMs for each perturbation, or of Table 4-1 by each estimator.
    Returns: rows in the thesis's order, block by block.
    """
    rows = []
    for pathway, wanted in dict.fromkeys(blocks):
        found = {
            (e.quantity, e.condition): e
            for e in estimates
            if e.experiment == EXPERIMENT[table] and e.pathway == pathway and wanted in (None, e.estimator)
        }
        if not found:
            continue
        estimator = next(iter(found.values())).estimator
        for name in ROWS[table]:
            prefix, _, quantity = name.rpartition("_") if name.startswith("SE") else ("", "", name)
            unit = next((e.unit for (q, _), e in found.items() if q == quantity), None)
            if unit is None:
                continue
            reading, values = prefix.removeprefix("SEM_"), []
            for condition in conditions:
                estimate = found.get((quantity, condition))
                if estimate is None:
                    raise InputError(
                        f"expected an estimate of {quantity} for {condition} by {pathway}, found none: "
                        "make the estimates again"
                    )
                if reading in SEM_READINGS:
                    fitted = pathway if EXPERIMENT[table] == "dummy" else estimator
                    values.append(_sem((fits or {}).get(condition), fitted, reading, quantity))
                elif prefix == "SE":
                    type_a = estimate.u_type_a
                    values.append(estimate.standard_error if type_a is None else type_a)
                else:
                    values.append(estimate.value)
            printed = [reported.get(printed_row(name), {}).get(condition) for condition in conditions]
            unit = AS_SEM if reading == "norm" else unit
            rows.append(TableRow(pathway, estimator, name, unit, values, printed))
    return rows


def printed_row(quantity: str) -> str:
    """Row of the thesis beside which a row is shown: SEM_K for SEM_count_K."""
    return f"SEM_{quantity.rpartition('_')[2]}" if quantity in SEM_ROWS else quantity


def _sem(fit: Result | None, fitted: str, reading: str, quantity: str) -> float | None:
    """SEM of I, B or K of one perturbation by a reading of eq (3-2), the mean over perturbations."""
    found = None if fit is None else fit.arrays.get(f"{fitted}/sem")
    if found is None:
        return None
    return float(np.mean(found[:, list(SEM_READINGS).index(reading), PARAMETERS.index(quantity)]))


def write_table(path: str | Path, rows: list[TableRow], conditions: list[str]) -> None:
    """Write as CSV: for each condition a column of values and one named ``<condition>_reported``.

    Units stand in the column ``unit``.
    """
    names = ["pathway", "estimator", "quantity", "unit"]
    names += [name for c in conditions for name in (c, f"{c}_reported")]
    cells = []
    for row in rows:
        numbers = [x for pair in zip(row.values, row.reported, strict=True) for x in pair]
        finite = [x if x is not None and math.isfinite(x) else None for x in numbers]
        cells.append([row.pathway, row.estimator, row.quantity, row.unit, *finite])
    write_cells(path, names, cells)


def read_table(path: str | Path) -> tuple[list[str], list[TableRow]]:
    """Conditions and rows of a table written by `write_table` (units in the rows)."""
    text = read_text(path, "a table of the thesis", ended=True)
    try:
        header, *lines = list(csv.reader(io.StringIO(text), strict=True))
        rows = []
        for line in lines:
            numbers = [float(x) if x else None for x in line[4:]]
            if len(line) != len(header):
                raise ValueError(f"{len(line)} cells below {len(header)} names")
            rows.append(TableRow(*line[:4], numbers[::2], numbers[1::2]))
    except (ValueError, csv.Error) as error:
        raise InputError(
            f"{path}: expected a table of the thesis, found a damaged row ({quoted(error)}): make it again"
        ) from error
    return header[4::2], rows
