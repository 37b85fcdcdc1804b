"""Scores of the answers to a benchmark, beside its truth.

The counting is that of the coverage study (`tepsipe.reporting.coverage`): an answer is an `Outcome`, its
fault is the set of its laboratory, and I, B and K of one problem are one cluster. Bias, RMS error, coverage
and interval score are those of the nominal problems, in percent of the truth. Where a recording is spoiled,
an answer should be covered or flagged.

The interval score of a central interval [l, u] of level 1 - a is

    S = (u - l) + 2/a (l - x) [x < l] + 2/a (x - u) [x > u]

for the true value x: its width, and a penalty if it misses (Gneiting & Raftery 2007, Journal of the American
Statistical Association 102, 359-378, eq 43). The smaller the better; no interval can gain by being stated
wider or narrower than its author believes.
"""

import csv
import io
import json
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tepsipe.arguments import LARGEST
from tepsipe.errors import InputError, listed, nearest, quoted
from tepsipe.experiments.benchmark.problems import ANSWERS, QUANTITIES, UNITS
from tepsipe.io.estimates import Estimate
from tepsipe.io.readers.plain_file import read_text
from tepsipe.io.tables import Table
from tepsipe.reporting.coverage import Laboratory, Outcome, covered
from tepsipe.statistics.coverage import CONFIDENCE, share_of

NOMINAL = "nominal"
FAULTS = ("late torque", "filtered torque", "soft plate", "camera noise")
ALL = "all"
# name of a problem, which ends in the four hexadecimal digits of its round
OF_ROUND = re.compile(r"[a-z]+-\d\d-([0-9a-f]{4})")
# names that a note lists
MOST_NAMED = 3
NO_REASON = "stated"  # flag of an answer: a benchmark does not ask for the reason


@dataclass(frozen=True)
class TrueProblem:
    """Hidden values of one problem."""

    kind: str
    fault: str
    """Kind, and what spoils its recording: one of `FAULTS`, or `NOMINAL`."""
    values: dict[str, float]
    """Quantity -> true value, in `UNITS`."""


@dataclass(frozen=True)
class ScoreRow:
    """One row of the table of scores."""

    method: str
    kind: str
    quantity: str
    """Method, and kind and quantity, or `ALL`."""
    n: int
    answered: int
    """Quantities of nominal problems, and those with a value."""
    bias_percent: float | None
    rms_percent: float | None
    median_percent: float | None
    """Mean error, root mean square error, and median of the error's size (% of the truth)."""
    coverage: float | None
    coverage_low: float | None
    coverage_high: float | None
    """Share of intervals that contain the truth, and its 95 % interval, with problems as clusters."""
    interval_score_percent: float | None
    """Mean interval score (% of the truth); None if any answer has no interval."""
    spoiled: int
    """Answers to spoiled problems, with those withdrawn."""
    flagged_percent: float | None
    """Those that are flagged (%)."""
    held_percent: float | None
    """Those that are covered or flagged (%)."""
    false_alarm_percent: float | None
    """Answers to nominal problems that are flagged (%)."""


SCORES = Table(ScoreRow, "scores of a benchmark")


def read_truth(path: Path) -> dict[str, TrueProblem]:
    """Read the hidden values of all problems (`UNITS`)."""
    try:
        content = json.loads(read_text(path, "the truth of a benchmark"))
        truth = {
            name: TrueProblem(
                hidden["kind"],
                hidden["fault"] or NOMINAL,
                {quantity: float(hidden["truth"][quantity]) for quantity in QUANTITIES[hidden["kind"]]},
            )
            for name, hidden in content["problems"].items()
        }
    except (ValueError, KeyError, TypeError, AttributeError, OverflowError, RecursionError) as error:
        if isinstance(error, InputError):
            raise
        raise InputError(
            f"{path}: expected the truth that tepsipe benchmark make wrote, found another file: name the "
            "organiser's file last, after the answers"
        ) from error
    for name, hidden in truth.items():
        for quantity, x in hidden.values.items():
            if not 1.0 / LARGEST <= x <= LARGEST:
                raise InputError(
                    f"{path}: expected a true {quantity} of {quoted(name)} above 0 and at most {LARGEST:g}, "
                    f"found {x:g}: the file was changed, name the organiser's file"
                )
    return truth


def read_answers(path: Path, truth: dict[str, TrueProblem]) -> list[Outcome]:
    """Read answers, each beside its true value (`UNITS`)."""
    reader = csv.reader(io.StringIO(read_text(path, "answers to a benchmark").removeprefix("\ufeff")))
    try:
        rows = [[cell.strip() for cell in row] for row in reader]
    except csv.Error as error:
        raise InputError(f"{path}: expected answers as CSV, found {error}: export the table again") from error
    if not rows or tuple(rows[0]) != ANSWERS.columns:
        found = quoted(",".join(rows[0])) if rows else "an empty file"
        raise InputError(
            f"{path}: expected the columns {','.join(ANSWERS.columns)}, found {found}: begin with "
            "answers-template.csv of the benchmark"
        )
    known = {name: k for k, name in enumerate(truth, start=1)}
    outcomes: dict[tuple[str, str], Outcome] = {}
    for line, row in enumerate(rows[1:], start=2):
        if not any(row):
            continue
        fault = _fault_of(row, truth, outcomes)
        if fault:
            raise InputError(f"{path}, line {line}: {fault}")
        problem, quantity, *numbers, flagged = row
        value, low, high = (float(x) if x else None for x in numbers)
        hidden = truth[problem]
        estimate = Estimate(
            hidden.kind,
            problem,
            pathway="",
            estimator=path.stem,
            quantity=quantity,
            unit=UNITS[quantity],
            value=math.nan if value is None else value,
            ci_low=low,
            ci_high=high,
            flags=NO_REASON if flagged.lower() == "true" else "",
        )
        laboratory = Laboratory(known[problem], hidden.fault, 0)
        outcomes[problem, quantity] = Outcome(laboratory, estimate, hidden.values[quantity])
    answered = [o for o in outcomes.values() if math.isfinite(o.estimate.value) or o.flagged]
    if not answered:
        raise InputError(f"{path}: expected at least one answer, found none: fill in values")
    return answered


def _fault_of(row: list[str], truth: dict[str, TrueProblem], before: dict) -> str:
    """What is wrong with a row of answers, as the rest of a sentence; empty for nothing."""
    if len(row) != len(ANSWERS.columns):
        return f"expected {len(ANSWERS.columns)} cells, found {len(row)}: write numbers with a decimal point"
    problem, quantity, *numbers, flagged = row
    if problem not in truth:
        round_, known = _round_of(problem), _round_of(next(iter(truth), ""))
        if round_ and known and round_ != known:
            return (
                f"expected a problem of the round {known}, found {quoted(problem)} of another: name the "
                "truth of its round"
            )
        return f"expected a problem of this benchmark, found {quoted(problem)}: {nearest(problem, truth)}"
    asked = truth[problem].values
    if quantity not in asked:
        return f"expected {listed(asked)} for {problem}, found {quoted(quantity)}: correct or delete the row"
    if (problem, quantity) in before:
        return f"expected one answer to {quantity} of {problem}, found a second: delete one of the rows"
    for name, cell in zip(ANSWERS.columns[2:5], numbers, strict=True):
        if cell and not _is_number(cell):
            return (
                f"expected a number of at most {LARGEST:g} or nothing for {name}, found {quoted(cell)}: "
                "correct it"
            )
    value, low, high = numbers
    if bool(low) != bool(high) or (low and not value):
        found = listed(name for name, cell in zip(ANSWERS.columns[2:5], numbers, strict=True) if cell)
        return (
            f"expected a value with both ends of its interval or with none, found {found}: complete the row"
        )
    if low and not float(low) <= float(high):
        return f"expected low up to high, found {low} and {high}: exchange them"
    if flagged.lower() not in ("true", "false"):
        return f"expected true or false for flagged, found {quoted(flagged)}: write one of them"
    return ""


def _round_of(problem: str) -> str:
    match = OF_ROUND.fullmatch(problem)
    return match[1] if match else ""


def notes_of(name: str, outcomes: Sequence[Outcome], truth: dict[str, TrueProblem]) -> tuple[str, ...]:
    """Answers that are scored, but that their author may have meant otherwise.

    name: name of the table, for the sentences.
    Returns: a sentence on problems without an answer to a quantity that the method answers for others of
    their kind, and a sentence on values outside their own intervals; none if there are none.
    """
    given = {(o.estimate.condition, o.estimate.quantity) for o in outcomes}
    tried = {(o.estimate.experiment, o.estimate.quantity) for o in outcomes}
    kinds = {kind for kind, _ in tried}
    missing = {
        problem: [x for x in hidden.values if (hidden.kind, x) in tried and (problem, x) not in given]
        for problem, hidden in truth.items()
    }
    lacking = [f"{problem} ({', '.join(left)})" for problem, left in missing.items() if left]
    outside = [
        f"{o.estimate.quantity} of {o.estimate.condition}"
        for o in outcomes
        if o.interval and not o.interval[0] <= o.estimate.value <= o.interval[1]
    ]
    notes = []
    if lacking:
        asked = sum(hidden.kind in kinds for hidden in truth.values())
        notes.append(
            f"{name}: no answer in {len(lacking)} of {asked} problems: {_first(lacking)}. A row without a "
            "value is an answer only if it is flagged."
        )
    if outside:
        notes.append(
            f"{name}: value outside its own interval in {len(outside)} of {len(outcomes)} answers: "
            f"{_first(outside)}. Check the columns value, low and high."
        )
    return tuple(notes)


def _first(names: Sequence[str]) -> str:
    return ", ".join(names[:MOST_NAMED]) + (", ..." if len(names) > MOST_NAMED else "")


def _is_number(cell: str) -> bool:
    try:
        return "_" not in cell and abs(float(cell)) <= LARGEST
    except ValueError:
        return False


def interval_score(low: float, high: float, truth: float) -> float:
    """Interval score of a 95 % interval (unit of its ends)."""
    missed = max(low - truth, truth - high, 0.0)
    return high - low + 2.0 / (1.0 - CONFIDENCE) * missed


def scores_of(method: str, outcomes: Sequence[Outcome], truth: dict[str, TrueProblem]) -> list[ScoreRow]:
    """Scores of one method: over all, per kind, and per kind and quantity."""
    asked = [(h.kind, name, h.fault) for h in truth.values() for name in h.values]
    rows = [_score(method, ALL, ALL, outcomes, asked)]
    for kind in dict.fromkeys(h.kind for h in truth.values()):
        own = [o for o in outcomes if o.estimate.experiment == kind]
        of_kind = [row for row in asked if row[0] == kind]
        rows.append(_score(method, kind, ALL, own, of_kind))
        for quantity in QUANTITIES[kind]:
            chosen = [o for o in own if o.estimate.quantity == quantity]
            rows.append(_score(method, kind, quantity, chosen, [r for r in of_kind if r[1] == quantity]))
    return rows


def _score(
    method: str, kind: str, quantity: str, outcomes: Sequence[Outcome], asked: list[tuple]
) -> ScoreRow:
    nominal = [o for o in outcomes if o.laboratory.set == NOMINAL]
    spoiled = [o for o in outcomes if o.laboratory.set != NOMINAL]
    valued = [o for o in nominal if math.isfinite(o.estimate.value)]
    told = [o for o in valued if o.interval]
    errors = np.array([o.relative(o.estimate.value - o.truth) for o in valued])
    share = share_of([covered(o) for o in told], [o.laboratory.number for o in told])
    scores = [o.relative(interval_score(*o.interval, o.truth)) for o in told if o.interval]
    return ScoreRow(
        method,
        kind,
        quantity,
        n=sum(fault == NOMINAL for *_, fault in asked),
        answered=len(valued),
        bias_percent=float(errors.mean()) if valued else None,
        rms_percent=float(np.sqrt(np.mean(errors**2))) if valued else None,
        median_percent=float(np.median(np.abs(errors))) if valued else None,
        coverage=share.value if told else None,
        coverage_low=share.low if told else None,
        coverage_high=share.high if told else None,
        interval_score_percent=float(np.mean(scores)) if told and len(told) == len(valued) else None,
        spoiled=len(spoiled),
        flagged_percent=_percent([o.flagged for o in spoiled]),
        held_percent=_percent([o.flagged or covered(o) for o in spoiled]),
        false_alarm_percent=_percent([o.flagged for o in nominal]),
    )


def _percent(held: list[bool]) -> float | None:
    return 100.0 * sum(held) / len(held) if held else None


# columns of the printed table: heading, field, digits
SHOWN = (
    ("bias (%)", "bias_percent", 1),
    ("RMS error (%)", "rms_percent", 1),
    ("median error (%)", "median_percent", 1),
    ("coverage (%)", "coverage", 0),  # with its interval
    ("interval score (%)", "interval_score_percent", 1),
    ("spoiled: flagged (%)", "flagged_percent", 0),
    ("spoiled: covered or flagged (%)", "held_percent", 0),
    ("false alarms (%)", "false_alarm_percent", 0),
)


def table_of(rows: Sequence[ScoreRow], by_quantity: bool = False) -> str:
    """Scores as a table in Markdown, kind by kind: over all quantities, or one by one.

    Methods without any answer to a kind are left out.
    """
    chosen = [row for row in rows if (row.quantity == ALL) != by_quantity]
    chosen = [row for row in chosen if row.answered or row.spoiled or row.false_alarm_percent is not None]
    kinds = [ALL, *QUANTITIES]
    head = ("Kind", *(("Quantity",) if by_quantity else ()), "Method", "answered")
    names = [*head, *(name for name, *_ in SHOWN)]
    lines = [f"| {' | '.join(names)} |", "|" + "---|" * len(names)]
    for row in sorted(chosen, key=lambda row: (kinds.index(row.kind), [ALL, *UNITS].index(row.quantity))):
        cells = [row.kind, *([row.quantity] if by_quantity else []), row.method, f"{row.answered} of {row.n}"]
        for _, name, digits in SHOWN:
            value = getattr(row, name)
            if value is not None and name == "coverage":
                shown = (f"{100.0 * x:.0f}" for x in (row.coverage, row.coverage_low, row.coverage_high))
                cells.append("{} ({} to {})".format(*shown))
            else:
                cells.append("–" if value is None else f"{value:.{digits}f}")
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def draw_scores(rows: Sequence[ScoreRow]):
    """Figure of the scores: a row per method, a colour per kind, one panel per score (%)."""
    from matplotlib.ticker import SymmetricalLogLocator

    from tepsipe.drawing.style import CYCLE, in_style, legend_above, new_figure

    panels = (
        "RMS error (%)",
        "interval score (%)",
        "coverage (%)",
        "spoiled: covered or flagged (%)",
        "false alarms (%)",
    )
    shown = {name: field for name, field, _ in SHOWN}

    @in_style
    def draw():
        methods = list(dict.fromkeys(row.method for row in rows))[::-1]
        kinds = list(dict.fromkeys(row.kind for row in rows))
        figure, axes = new_figure(1, len(panels), 1.4 + 0.32 * len(methods), sharey=True)
        for axis, panel in zip(axes, panels, strict=True):
            for k, kind in enumerate(kinds):
                own = {
                    row.method: getattr(row, shown[panel])
                    for row in rows
                    if (row.kind, row.quantity) == (kind, ALL)
                }
                scale = 100.0 if panel.startswith("coverage") else 1.0
                points = [
                    (scale * x, methods.index(m) + 0.12 * (2 - k)) for m, x in own.items() if x is not None
                ]
                colour = "black" if kind == ALL else CYCLE[k - 1]
                axis.plot(
                    *np.reshape(points, (-1, 2)).T, "o", color=colour, ms=6 if kind == ALL else 4, label=kind
                )
            if panel in panels[:2]:
                axis.set_xscale("symlog", linthresh=1.0)
                largest = [x for row in rows if (x := getattr(row, shown[panel])) is not None]
                axis.set_xlim(-0.3, 2.0 * max([10.0, *largest]))
                axis.xaxis.set_major_locator(SymmetricalLogLocator(base=10.0, linthresh=1.0))
                axis.xaxis.get_major_locator().set_params(numticks=3)
                axis.xaxis.set_major_formatter("{x:g}")
            else:
                axis.set_xlim(-8.0, 108.0)
            axis.set_xlabel(panel.replace(": ", ":\n").replace(" (%)", "\n(%)"))
        axes[2].axvline(100.0 * CONFIDENCE, color="0.6", lw=0.8)
        axes[0].set_yticks(range(len(methods)), methods)
        axes[0].set_ylim(-0.5, len(methods) - 0.5)
        legend_above(figure, axes[0], len(kinds))
        return figure

    return draw()
