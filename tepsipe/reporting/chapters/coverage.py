"""Report on coverage: names in words, rows that its sentences list, and conditions of these sentences."""

import pandas as pd

from tepsipe.drawing.names import words
from tepsipe.reporting.budgets import source_words
from tepsipe.reporting.coverage import ANY, SHIFTED
from tepsipe.reporting.run import Run

PROMISED = 0.95  # what an interval promises
WIDEST = 1.3  # width over the narrowest interval of the same coverage
MOST_FLAGGED_PERCENT = 5.0
LEAST_HELD_PERCENT = 90.0
# an interval may miss the truth as often; smaller differences are one or two of 60 estimates
LEAST_LOST_PERCENT = 5.0
# to separate a coverage of 0.95 from one of 0.90 takes a lower end of this
INFORMATIVE_LOW = 0.85


def numbers(run: Run) -> dict:
    """Limits, rows that sentences list (units in their keys), and names in words."""
    return {
        "limits": {
            "width_ratio": WIDEST,
            "flagged_percent": MOST_FLAGGED_PERCENT,
            "held_percent": LEAST_HELD_PERCENT,
            "lost_percent": LEAST_LOST_PERCENT,
            "low_percent": 100.0 * INFORMATIVE_LOW,
        },
        "listed": {rows.__name__: rows(run) for rows in LISTED},
        "words": _names(run),
        "sources": {name: source_words(name) for name in run.rows("dropped").source.unique()},
    }


def _names(run: Run) -> dict[str, str]:
    rows = run.tables["coverage"]
    return {name: words(name) for name in rows.pathway} | {name: estimator(name) for name in rows.estimator}


def estimator(name: str) -> str:
    """An estimator in words, for example "free reflex torque (GLS), 50 ms" for free-reflex-gls-50."""
    base, _, window = name.rpartition("-")
    return f"{words(base)}, {window} ms" if window.isdigit() else words(name)


def _first(run: Run) -> str:
    """Set of the nominal laboratories."""
    return next(iter(run.study["sets"]))


def _recommended(run: Run, mechanism: str) -> pd.DataFrame:
    return run.rows("coverage", recommended=True, mechanism=mechanism)


def _nominal(run: Run) -> pd.DataFrame:
    return _recommended(run, _first(run))


def _checks(run: Run) -> pd.DataFrame:
    """Shares of nominal trials that any check flags."""
    return run.rows("flags", mechanism=_first(run), flag=ANY)


def _records(rows: pd.DataFrame) -> list[dict]:
    return rows.to_dict("records")


# ---- conditions of sentences, and the rows (units in the keys) that fulfil them


def below(run: Run) -> list[dict]:
    """Nominal estimates of which the coverage is below 95 %."""
    rows = _nominal(run)
    return _records(rows[rows.coverage_high < PROMISED])


def above(run: Run) -> list[dict]:
    """Nominal estimates of which the coverage is above 95 %."""
    rows = _nominal(run)
    return _records(rows[rows.coverage_low > PROMISED])


def undecided(run: Run) -> list[dict]:
    """Nominal estimates of which the coverage may be 95 %, and may be far below."""
    rows = _nominal(run)
    return _records(rows[(rows.coverage_high >= PROMISED) & (rows.coverage_low < INFORMATIVE_LOW)])


def wide(run: Run) -> list[dict]:
    """Nominal estimates with intervals much wider than those that hold 95 % of the errors."""
    rows = _nominal(run)
    return _records(rows[rows.width_ratio > WIDEST])


def often_flagged(run: Run) -> list[dict]:
    """Nominal estimates that are flagged too often."""
    rows = _nominal(run)
    return _records(rows[rows.flagged_percent > MOST_FLAGGED_PERCENT])


def seldom_held(run: Run) -> list[dict]:
    """Estimates of shifted laboratories that are too seldom covered or flagged."""
    rows = _recommended(run, SHIFTED)
    return _records(rows[rows.held_percent < LEAST_HELD_PERCENT])


def needing_a_source(run: Run) -> list[dict]:
    """Nominal estimates too seldom covered or flagged without a source, and clearly less than with it."""
    key = ["experiment", "pathway", "estimator", "quantity"]
    full = _nominal(run)[[*key, "held_percent"]].rename(columns={"held_percent": "full_held_percent"})
    rows = run.rows("dropped", mechanism=_first(run)).merge(full, on=key)
    lost = (rows.full_held_percent - rows.held_percent).round(6)  # differences of ratios
    return _records(rows[(rows.held_percent < LEAST_HELD_PERCENT) & (lost >= LEAST_LOST_PERCENT)])


def often_flagged_trials(run: Run) -> list[dict]:
    """Experiments of which too many nominal trials are flagged."""
    rows = _checks(run)
    return _records(rows[rows.low > MOST_FLAGGED_PERCENT])


LISTED = (
    *(below, above, undecided, wide),
    *(often_flagged, seldom_held, needing_a_source, often_flagged_trials),
)


def nominal(run: Run) -> bool:
    """Recommended estimates have intervals in nominal laboratories."""
    return not _nominal(run).empty


def widths_unknown(run: Run) -> bool:
    """There are too few nominal laboratories to compare widths with errors."""
    return not _nominal(run).width_ratio.notna().any()


def none_wide(run: Run) -> bool:
    """Widths are known, and no interval is much wider than the one that holds 95 % of the errors."""
    return not widths_unknown(run) and not wide(run)


def seldom_flagged(run: Run) -> bool:
    """No nominal estimate is flagged too often."""
    return not often_flagged(run)


def held_when_shifted(run: Run) -> bool:
    """There are shifted laboratories, and enough of their estimates are covered or flagged."""
    return not _recommended(run, SHIFTED).empty and not seldom_held(run)


def no_source_needed(run: Run) -> bool:
    """No one source of a budget is needed for enough nominal estimates to be covered or flagged."""
    return not run.rows("dropped", mechanism=_first(run)).empty and not needing_a_source(run)


def failures(run: Run) -> bool:
    """Some laboratories have no results."""
    return bool(run.rows("laboratories").failed.notna().any())


def seldom_flagged_trials(run: Run) -> bool:
    """Nominal trials were checked, and in no experiment are too many flagged."""
    return not _checks(run).empty and not often_flagged_trials(run)


PREDICATES = (
    *(*LISTED, nominal, widths_unknown, none_wide, seldom_flagged),
    *(held_when_shifted, no_source_needed, failures, seldom_flagged_trials),
)
