"""A verdict for every printed cell of Tables 4-1 to 4-4: one row of ``cells.csv`` each."""

import math
from dataclasses import dataclass, field

import numpy as np

from tepsipe.errors import InputError, quoted
from tepsipe.io.result import Result
from tepsipe.io.tables import Table
from tepsipe.mechanics.impedance_model import PARAMETERS
from tepsipe.reporting.noise_table import TABLE_COLUMNS
from tepsipe.reporting.thesis_tables import TableRow

REPRODUCED, FITTED, PREDICTED = "reproduced", "fitted", "predicted"
EXPLAINED, NOT_REPRODUCED, NOT_COMPUTED = "explained", "not reproduced", "not computed"
VERDICTS = (REPRODUCED, FITTED, PREDICTED, EXPLAINED, NOT_REPRODUCED, NOT_COMPUTED)
MANIPULATOR_TABLE, NOISE_TABLE = "table_4_1", "table_4_4"
# readings of Table 4-4: of its columns with noise, and of the torque that returns the column without
TABULATED, CONSISTENT = "as-tabulated", "recommended-regression"
MISPLACED_POINT = 10.0  # a decimal point one place too far to the right

Cells = dict[tuple[str, str, str], float]  # (table, row, column) -> value, in the unit of the row


@dataclass(frozen=True)
class Tolerance:
    """How close a number of the run must come to a printed one.

    Exactly one of ``absolute``, ``share``, ``factor`` and ``unexplained_factor`` is given.

    Attributes
    ----------
    tables, rows : tuple of str
        Where it holds.
    reason : str
        Why it is as wide as it is.
    verdict : {"reproduced", "fitted", "predicted"}
        Of a number within it, if its trial was simulated; of a recorded trial it is ``reproduced``.
    absolute : float or None
        Largest distance (unit of the row).
    share : float or None
        Largest distance relative to the printed number (-).
    factor : float or None
        Largest ratio, either way (-).
    unexplained_factor : float or None
        Largest ratio of 100 % - VAF, either way (-).
    digit : float
        Last printed digit of a VAF (%).
    zero : float or None
        Largest absolute value where 0 is printed (unit of the row).
    outside : str
        What is known of numbers outside it.
    """

    tables: tuple[str, ...]
    rows: tuple[str, ...]
    reason: str
    verdict: str = REPRODUCED
    absolute: float | None = None
    share: float | None = None
    factor: float | None = None
    unexplained_factor: float | None = None
    digit: float = 0.01
    zero: float | None = None
    outside: str = ""

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
        reach = self.absolute if self.absolute is not None else self.share * abs(reported)
        return reported - reach, reported + reach

    def holds(self, reported: float, value: float) -> bool:
        """Whether a number agrees with the printed one (unit of the row)."""
        low, high = self.limits(reported)
        return low <= value <= high

    @property
    def text(self) -> str:
        """The tolerance in words, for the column ``tolerance`` (unit of the row)."""
        if self.absolute is not None:
            return f"{self.absolute:g}"
        if self.share is not None:
            return f"{100.0 * self.share:g} %"
        if self.factor is not None:
            return f"factor {self.factor:g}" + ("" if self.zero is None else f", {self.zero:g} of 0")
        return f"factor {self.unexplained_factor:g} of 100 - VAF"


@dataclass(frozen=True)
class CellVerdict:
    """One row of ``cells.csv``.

    Attributes
    ----------
    table, row, column : str
        The printed cell: a quantity (row) of a condition (column).
    reported : float
        Printed (unit of the row).
    value : float or None
        Of this run (unit of the row).
    tolerance : str
        As `Tolerance.text`.
    verdict : str
        One of `VERDICTS`.
    reason : str
        Why the tolerance is as it is, how the number is explained, or what is known of one that is not.
    """

    table: str
    row: str
    column: str
    reported: float
    value: float | None
    tolerance: str
    verdict: str
    reason: str


def _check(row: CellVerdict) -> None:
    if row.verdict not in VERDICTS:
        raise ValueError(f"no verdict {quoted(row.verdict)}")


CELL_VERDICTS = Table(CellVerdict, "verdicts of printed cells", check=_check)


@dataclass(frozen=True)
class Explanations:
    """Numbers that an explanation predicts for cells, and the explanation.

    Attributes
    ----------
    values : dict
        (table, row, column) -> predicted number (unit of the row).
    texts : dict
        (table, row, column) -> the explanation, in words.
    """

    values: Cells = field(default_factory=dict)
    texts: dict[tuple[str, str, str], str] = field(default_factory=dict)


def tolerances_of(entries: list[dict]) -> dict[tuple[str, str], Tolerance]:
    """(table, row) -> tolerance (unit of the row), from the section ``cells`` of the reported values.

    Raises
    ------
    InputError
        If an entry has not exactly one tolerance, or a row has two.
    """
    found = {}
    for entry in entries:
        lists = {key: tuple(entry[key]) for key in ("tables", "rows")}
        tolerance = Tolerance(**(entry | lists))
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
    """Numbers of a table's first block, which is the one as printed (unit of each row).

    SEMs by eq (3-2) are those of Table 4-1 only: for the others see `ordinary_errors`.
    """
    first = [row for row in rows if (row.pathway, row.estimator) == (rows[0].pathway, rows[0].estimator)]
    first = [row for row in first if table == MANIPULATOR_TABLE or not row.quantity.startswith("SEM_")]
    return {
        (table, row.quantity, column): float(value)
        for row in first
        for column, value in zip(columns, row.values, strict=True)
        if value is not None and math.isfinite(value)
    }


def ordinary_errors(table: str, fits: dict[str, Result], pathway: str) -> Cells:
    """SEM of I, B, K of the dummy as Tables 4-2 and 4-3 must have it (units of I, B, K).

    It is the ordinary standard error of one perturbation, the mean over perturbations. ``fits`` are those of
    the table's conditions.
    """
    return {
        (table, f"SEM_{quantity}", condition): float(error)
        for condition, fit in fits.items()
        if f"{pathway}/standard_errors" in fit.arrays
        for quantity, error in zip(
            PARAMETERS, np.mean(fit.arrays[f"{pathway}/standard_errors"], axis=0), strict=True
        )
    }


def noise_cells(rows: list[TableRow], reading: str) -> Cells:
    """Table 4-4 by one reading, for the first simulated stiffness, with ordinary SEMs (unit of each row)."""
    own = [row for row in rows if row.pathway == reading]
    own = [row for row in own if row.estimator == own[0].estimator]
    found = {}
    for row in own:
        name = row.quantity.replace("SE_", "SEM_") if row.quantity.startswith("SE_") else row.quantity
        if row.quantity.startswith("SEM_"):
            continue  # eq (3-2) as printed: tens of times larger
        for column, value in zip(TABLE_COLUMNS, row.values, strict=True):
            if value is not None:
                found[NOISE_TABLE, name, column] = float(value)
    return found


def explanations_of(values: Cells, slips: list[dict], noise: list[TableRow]) -> Explanations:
    """Numbers that explanations predict (unit of each row).

    A misprint: the decimal point is misplaced, so the printed number is ten times that of the run. The column
    of Table 4-4 without noise: it holds what the consistent torque returns, not the printed one.

    Parameters
    ----------
    values : dict
        Numbers of the run.
    slips : list of dict
        Misprints: table, quantity, condition, printed, meant.
    noise : list of TableRow
        Rows of Table 4-4.

    Returns
    -------
    Explanations
        For cells to which one applies.
    """
    found = Explanations()
    for slip in slips:
        key = slip["table"], slip["quantity"], slip["condition"]
        if key in values:
            found.values[key] = MISPLACED_POINT * values[key]
            found.texts[key] = "misprint, a misplaced decimal point: ten times this run's number"
    for key, value in noise_cells(noise, CONSISTENT).items():
        if key[2] == "none":
            found.values[key] = value
            found.texts[key] = "without noise the table shows what the consistent torque returns"
    return found


def ledger(
    reported: dict[str, dict[str, dict[str, float]]],
    tolerances: dict[tuple[str, str], Tolerance],
    values: Cells,
    explanations: Explanations,
    recorded: set[str] | frozenset[str] = frozenset(),
) -> list[CellVerdict]:
    """Verdict of every printed cell.

    Parameters
    ----------
    reported : dict
        Table -> row -> column -> printed number (unit of the row).
    tolerances : dict
        (table, row) -> tolerance.
    values : dict
        (table, row, column) -> number of this run (unit of the row); a missing one is ``not computed``.
    explanations : Explanations
        Numbers that explanations predict.
    recorded : set of str
        Columns whose trials were not simulated: nothing was fitted or predicted there.

    Returns
    -------
    list of CellVerdict
        One per printed cell, in the order of ``reported``.

    Raises
    ------
    InputError
        If a row has no tolerance.
    """
    found = []
    for table, rows in reported.items():
        for row, columns in rows.items():
            if (table, row) not in tolerances:
                raise InputError(
                    f"cells: expected a tolerance for {row} of {table}, found none: add it to cells"
                )
            tolerance = tolerances[table, row]
            for column, printed in columns.items():
                key = table, row, column
                value = values.get(key)
                own = tolerance.verdict if column not in recorded else REPRODUCED
                verdict, reason = _verdict(key, float(printed), value, tolerance, explanations, own)
                found.append(CellVerdict(*key, float(printed), value, tolerance.text, verdict, reason))
    return found


def _verdict(
    key: tuple[str, str, str],
    printed: float,
    value: float | None,
    tolerance: Tolerance,
    explanations: Explanations,
    within: str,
) -> tuple[str, str]:
    if value is None or not math.isfinite(value):
        return NOT_COMPUTED, "this run does not have the result"
    if tolerance.holds(printed, value):
        return within, tolerance.reason
    if key in explanations.values:
        predicted = explanations.values[key]
        text = f"{explanations.texts[key]}, {predicted:.4g}"
        if tolerance.holds(printed, predicted):
            return EXPLAINED, text
        return NOT_REPRODUCED, f"nor explained: {text}"
    return NOT_REPRODUCED, tolerance.outside or "no reason is known"
