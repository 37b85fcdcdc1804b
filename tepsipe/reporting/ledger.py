"""A verdict for every printed cell of Tables 4-1 to 4-4: one row of ``cells.csv`` each."""

import math
from dataclasses import dataclass, field, replace
from itertools import product
from typing import Annotated

import numpy as np

from tepsipe.errors import InputError, quoted
from tepsipe.io.tables import Table
from tepsipe.mechanics.impedance_model import PARAMETERS
from tepsipe.reporting.thesis_tables import TABLE_COLUMNS, TableRow, printed_row
from tepsipe.statistics.least_squares import SEM_READINGS

IMPLIED, FITTED, PREDICTED, PATTERN = "implied", "fitted", "predicted", "pattern"
INTERPRETATION, EXPLAINED, NOT_REPRODUCED = "interpretation", "explained", "not reproduced"
UNKNOWN, NOT_COMPUTED, CONTRADICTED = "unknown", "not computed", "contradicted by itself"
WITHIN = (IMPLIED, FITTED, PREDICTED, PATTERN, INTERPRETATION)  # verdicts of a value within its tolerance
VERDICTS = (*WITHIN, EXPLAINED, CONTRADICTED, NOT_REPRODUCED, UNKNOWN, NOT_COMPUTED)
NOISE_TABLE, WITHOUT_NOISE = "table_4_4", "none"
# readings of Table 4-4: of its columns with noise, and of the torque that returns the column without
TABULATED, CONSISTENT = "as-tabulated", "recommended-regression"
MISPLACED_POINT = 10.0  # a decimal point one place too far to the right
ROW_MEAN = "mean of the printed row"  # the null of a table; otherwise that of another table's column
ALL_TABLES = "all"
RECORDED = "recorded trials, to which no constant was fitted"
MISPRINT = "misprint, a misplaced decimal point: compared with a tenth of the printed number"

Cells = dict[tuple[str, str, str], float]  # (table, row, column) -> value, in the unit of the row


@dataclass(frozen=True)
class Tolerance:
    """How close a number of the run must come to a printed one.

    Exactly one of ``absolute``, ``share``, ``factor`` and ``unexplained_factor`` is given.
    """

    tables: tuple[str, ...]
    rows: tuple[str, ...]
    """Where it holds."""
    reason: str
    """Why it is as wide as it is."""
    verdict: str = PREDICTED
    """Of a number within it, if its trial was simulated: one of `WITHIN`; of a recorded trial it is
    ``predicted``. ``unknown`` if no rule returns the printed numbers: then no number is judged."""
    used: str = ""
    """What was used to get the run's numbers."""
    null_model: str = ROW_MEAN
    """Null model: `ROW_MEAN`, or the table with the same condition by the other profile."""
    absolute: float | None = None
    """Largest distance (unit of the row)."""
    share: float | None = None
    """Largest distance relative to the printed number."""
    factor: float | None = None
    """Largest ratio, either way."""
    unexplained_factor: float | None = None
    """Largest ratio of 100 % - VAF, either way."""
    digit: Annotated[float, "%"] = 0.01
    """Last printed digit of a VAF."""
    zero: float | None = None
    """Largest absolute value where 0 is printed (unit of the row)."""
    outside: str = ""
    """What is known of numbers outside it."""

    def limits(self, reported: float) -> tuple[float, float]:
        """Lowest and highest number that agrees with the printed one (unit of the row)."""
        if self.factor is not None and reported == 0.0:
            return -(self.zero or 0.0), self.zero or 0.0
        if self.factor is not None:
            return tuple(sorted((reported / self.factor, reported * self.factor)))
        if self.unexplained_factor is not None:
            missing, half = 100.0 - reported, 0.5 * self.digit
            return (
                100.0 - self.unexplained_factor * (missing + half),
                100.0 - max(0.0, missing - half) / self.unexplained_factor,
            )
        tolerance = self.absolute if self.absolute is not None else self.share * abs(reported)
        return reported - tolerance, reported + tolerance

    def holds(self, reported: float, value: float) -> bool:
        """Whether a number agrees with the printed one (unit of the row)."""
        low, high = self.limits(reported)
        return low <= value <= high

    def text(self, reported: float) -> str:
        """The tolerance of a printed number in words, for the column ``tolerance`` (unit of the row)."""
        if self.absolute is not None:
            return f"{self.absolute:g}"
        if self.share is not None:
            return f"{100.0 * self.share:g} %"
        if self.factor is not None:
            return f"{self.zero or 0.0:g}" if reported == 0.0 else f"factor {self.factor:g}"
        return (
            f"factor {self.unexplained_factor:g} in 100 - VAF, beyond half a unit of the last printed digit"
        )


@dataclass(frozen=True)
class CellVerdict:
    """One row of ``cells.csv``."""

    table: str
    row: str
    column: str
    """The printed cell: a quantity (row) of a condition (column)."""
    reported: float
    """Printed (unit of the row)."""
    value: float | None
    """Of this run (unit of the row)."""
    tolerance: str
    """As `Tolerance.text`."""
    verdict: str
    """One of `VERDICTS`."""
    reason: str
    """Why the tolerance is as it is, how the number is explained, or what is known of one that is not; what
    was used to get it; and whether the cell can discriminate."""
    null_value: float | None
    """Of the null model (unit of the row)."""
    null_verdict: str
    """``implied`` if the null model, which uses the thesis's own numbers only, lies within the tolerance;
    otherwise ``not reproduced``."""


def _check(row: CellVerdict) -> None:
    for verdict in (row.verdict, row.null_verdict):
        if verdict not in VERDICTS:
            raise ValueError(f"no verdict {quoted(verdict)}")


CELL_VERDICTS = Table(CellVerdict, "verdicts of printed cells", check=_check)


@dataclass(frozen=True)
class Explanations:
    """Numbers that an explanation predicts for cells, and the explanation."""

    values: Cells = field(default_factory=dict)
    """(table, row, column) -> predicted number (unit of the row)."""
    texts: dict[tuple[str, str, str], str] = field(default_factory=dict)
    """(table, row, column) -> the explanation, in words."""
    misprints: dict[tuple[str, str, str], float] = field(default_factory=dict)
    """(table, row, column) -> by what a misprint multiplied the number. Numbers of run and null model are
    compared without it."""


def basis_of(entry: dict, bases: dict[str, str]) -> str:
    """What was used to get the numbers of an entry of the reported values, in words."""
    if entry["used"] not in bases:
        raise InputError(
            f"used: expected one of {', '.join(bases)}, found {quoted(entry['used'])}: add it to bases"
        )
    return bases[entry["used"]]


def tolerances_of(entries: list[dict], bases: dict[str, str]) -> dict[tuple[str, str], Tolerance]:
    """(table, row) -> tolerance (unit of the row), from the section ``cells`` of the reported values.

    ``bases`` has what was used, in words, by the name that the entries give it.
    """
    found = {}
    for entry in entries:
        lists = {key: tuple(entry[key]) for key in ("tables", "rows")}
        tolerance = Tolerance(**(entry | lists | {"used": basis_of(entry, bases)}))
        kinds = ("absolute", "share", "factor", "unexplained_factor")
        given = [kind for kind in kinds if getattr(tolerance, kind) is not None]
        if len(given) != 1:
            raise InputError(
                f"cells: expected one of {', '.join(kinds)} for the rows {', '.join(tolerance.rows)}, found "
                f"{len(given)}: give one"
            )
        for key in ((table, row) for table in tolerance.tables for row in tolerance.rows):
            if key in found:
                raise InputError(
                    f"cells: expected one tolerance for {key[1]} of {key[0]}, found two: remove one"
                )
            found[key] = tolerance
    return found


def cells_of_table(table: str, rows: list[TableRow], columns: list[str]) -> Cells:
    """Numbers of a table's first block, which is the one as printed (unit of each row)."""
    first = [row for row in rows if (row.pathway, row.estimator) == (rows[0].pathway, rows[0].estimator)]
    return {
        (table, row.quantity, column): float(value)
        for row in first
        for column, value in zip(columns, row.values, strict=True)
        if value is not None and math.isfinite(value)
    }


def noise_cells(rows: list[TableRow], reading: str) -> Cells:
    """Table 4-4 by one reading, for the first simulated stiffness (unit of each row)."""
    return cells_of_table(NOISE_TABLE, [row for row in rows if row.pathway == reading], list(TABLE_COLUMNS))


@dataclass(frozen=True)
class SemReading:
    """Distance of the run's SEMs from the printed ones by one reading of eq (3-2)."""

    reading: str
    """One of `SEM_READINGS`."""
    table: str
    """A table of the thesis, or `ALL_TABLES`."""
    cells: int
    """Number of printed SEMs above 0 that the run has, too."""
    rms_log_ratio: float
    """Root mean square of the natural logarithm of the ratio of the run's to the printed SEM."""
    median_ratio: float
    """Median of this ratio."""


def sem_distances(values: Cells, reported: dict[str, dict[str, dict[str, float]]]) -> list[SemReading]:
    """Distance by every reading of eq (3-2), by table and over all tables.

    values: (table, row, column) -> number of this run, with rows SEM_<reading>_<quantity>.
    reported: table -> row -> column -> printed number.
    """
    found = []
    for reading in SEM_READINGS:
        logs: dict[str, list[float]] = {}
        for table, quantity in product(reported, PARAMETERS):
            for column, printed in reported[table].get(f"SEM_{quantity}", {}).items():
                value = values.get((table, f"SEM_{reading}_{quantity}", column), math.nan)
                if printed > 0.0 and 0.0 < value < math.inf:
                    for name in (table, ALL_TABLES):
                        logs.setdefault(name, []).append(math.log(value / printed))
        found += [
            SemReading(
                reading, name, len(own), float(np.sqrt(np.mean(np.square(own)))), math.exp(np.median(own))
            )
            for name, own in logs.items()
        ]
    return found


def best_sem_reading(distances: list[SemReading]) -> str:
    """Reading of eq (3-2) that is nearest to the printed SEMs over all tables; without any, the number N."""
    over_all = [one for one in distances if one.table == ALL_TABLES]
    return min(over_all, key=lambda one: one.rms_log_ratio).reading if over_all else "count"


def with_sem_reading(values: Cells, reading: str) -> Cells:
    """Cells whose rows SEM_<quantity> are by one reading of eq (3-2), without those by other readings."""
    return {
        (table, printed_row(row), column): number
        for (table, row, column), number in values.items()
        if printed_row(row) == row or row.startswith(f"SEM_{reading}_")
    }


def printed_cells(reported: dict[str, dict[str, dict[str, float]]], slips: list[dict]) -> Cells:
    """Printed numbers (unit of each row), evident misprints corrected.

    ``reported`` maps table, row and column to a number; ``slips`` have table, quantity, condition and meant.
    """
    meant = {(slip["table"], slip["quantity"], slip["condition"]): slip["meant"] for slip in slips}
    found = {
        (table, row, column): float(number)
        for table, rows in reported.items()
        for row, columns in rows.items()
        for column, number in columns.items()
    }
    return found | {key: float(number) for key, number in meant.items() if key in found}


def null_cells(
    reported: dict[str, dict[str, dict[str, float]]],
    tolerances: dict[tuple[str, str], Tolerance],
    slips: list[dict],
) -> Cells:
    """Numbers of the null models, which use the thesis's own printed numbers only (unit of each row).

    A row is the mean of the printed row, or a copy of the same row of another table, column by column. The
    column of Table 4-4 without noise is the simulated joint itself: noise-free data of an equation return its
    parameters.

    reported: table -> row -> column -> printed number (unit of the row).
    tolerances: (table, row) -> tolerance, with the name of the null model.
    slips: misprints (table, quantity, condition, meant), which are corrected.
    """
    printed, found = printed_cells(reported, slips), {}
    for table, row in ((table, row) for table, rows in reported.items() for row in rows):
        columns = [column for column in reported[table][row] if column != WITHOUT_NOISE]
        null = tolerances[table, row].null_model
        if null == ROW_MEAN:
            mean = float(np.mean([printed[table, row, column] for column in columns]))
            found |= {(table, row, column): mean for column in columns}
        else:
            copied = zip(columns, reported.get(null, {}).get(row, ()), strict=False)
            found |= {(table, row, column): printed[null, row, other] for column, other in copied}
    without = {key: number for key, number in printed.items() if key[2] == WITHOUT_NOISE}
    return found | without


def explanations_of(values: Cells, slips: list[dict], consistent: Cells) -> Explanations:
    """Misprints, and numbers that explanations predict (unit of each row).

    A misprint: the decimal point is misplaced, so the printed number is ten times what was meant. The column
    of Table 4-4 without noise: it holds what the consistent torque returns, not the printed one.

    slips: Misprints: table, quantity, condition, printed, meant.
    consistent: Table 4-4 by the consistent torque.
    Returns: for cells to which one applies.
    """
    found = Explanations()
    for slip in slips:
        key = slip["table"], slip["quantity"], slip["condition"]
        if key in values:
            found.misprints[key] = MISPLACED_POINT
    for key, value in consistent.items():
        if key[2] == "none":
            found.values[key] = value
            found.texts[key] = "without noise the table shows what the consistent torque returns"
    return found


def ledger(
    reported: dict[str, dict[str, dict[str, float]]],
    tolerances: dict[tuple[str, str], Tolerance],
    values: Cells,
    explanations: Explanations,
    nulls: Cells | None = None,
    recorded: set[str] | frozenset[str] = frozenset(),
) -> list[CellVerdict]:
    """Verdict of every printed cell.

    reported: table -> row -> column -> printed number (unit of the row).
    tolerances: (table, row) -> tolerance.
    values: (table, row, column) -> number of this run (unit of the row); a missing one is ``not computed``.
    nulls: (table, row, column) -> number of the null model (unit of the row).
    recorded: columns whose trials were not simulated: no constant was fitted to them.
    Returns: one per printed cell, in the order of ``reported``.
    """
    found = []
    for table, rows in reported.items():
        for row, columns in rows.items():
            if (table, row) not in tolerances:
                raise InputError(
                    f"cells: expected a tolerance for {row} of {table}, found none: add it to cells"
                )
            for column, printed in columns.items():
                key = table, row, column
                tolerance = tolerances[table, row]
                if column in recorded:
                    own = UNKNOWN if tolerance.verdict == UNKNOWN else PREDICTED
                    tolerance = replace(tolerance, verdict=own, used=RECORDED)
                null, meant = (nulls or {}).get(key), float(printed)
                if key in explanations.misprints:
                    meant /= explanations.misprints[key]
                    tolerance = replace(tolerance, reason=MISPRINT)
                outcome = judged(tolerance, meant, values.get(key), null)
                if outcome.verdict == NOT_REPRODUCED and key in explanations.values:
                    outcome = _explained(outcome, tolerance, float(printed), key, explanations)
                found.append(
                    CellVerdict(
                        *(*key, float(printed), values.get(key), tolerance.text(float(printed))),
                        *(outcome.verdict, outcome.reason, null, outcome.null_verdict),
                    )
                )
    return found


@dataclass(frozen=True)
class Outcome:
    """Verdict on a number, its reason in words, and whether the null model is within the tolerance."""

    verdict: str
    """Two of `VERDICTS`."""
    reason: str
    """As `CellVerdict.reason`."""
    null_verdict: str


def null_verdict_of(within: bool | None) -> str:
    """Verdict on a null model: ``implied`` within the tolerance; None if there is no null model."""
    return NOT_COMPUTED if within is None else IMPLIED if within else NOT_REPRODUCED


def judged(tolerance: Tolerance, printed: float, value: float | None, null: float | None) -> Outcome:
    """Judge a number of the run against the printed one, beside a null model (all in the unit of the row)."""
    null_verdict = null_verdict_of(None if null is None else tolerance.holds(printed, null))
    if value is None or not math.isfinite(value):
        return Outcome(NOT_COMPUTED, "this run does not have the result", null_verdict)
    if tolerance.verdict == UNKNOWN:
        verdict, reason = UNKNOWN, tolerance.outside
    elif tolerance.holds(printed, value):
        verdict, reason = tolerance.verdict, tolerance.reason
    else:
        verdict, reason = NOT_REPRODUCED, tolerance.outside or "no reason is known"
    return Outcome(verdict, f"{reason}; used: {tolerance.used}{_discriminates(null_verdict)}", null_verdict)


def _discriminates(null_verdict: str) -> str:
    return "; cannot discriminate: the null model is within" if null_verdict == IMPLIED else ""


def _explained(
    outcome: Outcome, tolerance: Tolerance, printed: float, key: tuple[str, str, str], found: Explanations
) -> Outcome:
    """Outcome of a number outside its tolerance, if an explanation predicts another (unit of the row)."""
    exact = round(found.values[key], 12)  # an error that is only that of rounding is 0
    text = f"{found.texts[key]}, {exact:.4g}; used: {tolerance.used}"
    text += _discriminates(outcome.null_verdict)
    if tolerance.holds(printed, found.values[key]):
        return replace(outcome, verdict=EXPLAINED, reason=text)
    return replace(outcome, reason=f"nor explained: {text}")
