"""Numbers and sentences of the report on the coverage; what a sentence says is chosen by the numbers."""

import math
import re

import pandas as pd

from tepsipe.reporting.budgets import source_words
from tepsipe.reporting.coverage import SHIFTED
from tepsipe.reporting.coverage_flags import ANY
from tepsipe.reporting.figures.names import words
from tepsipe.reporting.numbers.format import number, percent
from tepsipe.reporting.numbers.laboratory import DIRECTIONS
from tepsipe.reporting.numbers.laboratory_words import unit_of, words_of

NOMINAL = 0.95  # what an interval promises
WIDEST = 1.3  # width over the narrowest interval of the same coverage
MOST_FLAGGED_PERCENT = 5.0
LEAST_HELD_PERCENT = 90.0
SHOWN_SHARE_PERCENT = 1.0  # of a source in the variance, to be shown in the report
EXPERIMENTS = {
    "weight": "weight",
    "wristalyzer": "Wristalyzer",
    "dummy": "dummy",
    "standing": "standing person",
}
# to separate a coverage of 0.95 from one of 0.90 takes a lower end of this
INFORMATIVE_LOW = 0.85


def coverage_data(
    coverage: pd.DataFrame,
    dropped: pd.DataFrame,
    flags: pd.DataFrame,
    laboratories: pd.DataFrame,
    about: dict,
) -> dict:
    """Everything that the report on the coverage shows.

    Parameters
    ----------
    coverage, dropped, flags, laboratories : DataFrame
        The tables of the same names (units in their columns).
    about : dict
        title, sets (name -> what it changes), drawn (path -> distribution), experiments (name -> conditions),
        code (commit, modified), seed; no unit.

    Returns
    -------
    dict
        Texts for Typst.
    """
    first = next(iter(about["sets"]))
    failed = laboratories[laboratories.failed.fillna("") != ""]
    quoted = coverage[coverage.recommended.astype(bool)]
    nominal, shifted = (quoted[quoted.mechanism == name] for name in (first, SHIFTED))
    sets = [
        {
            "name": name,
            "count": str(int((laboratories["set"] == name).sum())),
            "changes": _changes(chosen, name == first),
        }
        for name, chosen in about["sets"].items()
    ]
    return {
        "title": about["title"],
        "trials": 0,
        "count": str(len(laboratories)),
        "done": str(len(laboratories) - len(failed)),
        "sets": sets,
        "drawn": [
            [_constant(path), unit_of(re.sub(r"(\.\d+)+$", "", path)), _distribution(entry)]
            for path, entry in about["drawn"].items()
        ],
        "experiments": [
            [EXPERIMENTS.get(e, e), ", ".join(names)] for e, names in about["experiments"].items()
        ],
        "failed": [[str(row.number), row.set, row.failed] for row in failed.itertuples()],
        "first": first,
        "sentences": [
            *sentences(nominal, shifted, dropped[dropped.mechanism == first], len(failed)),
            *_on_flags(flags[(flags.mechanism == first) & (flags.flag == ANY)]),
        ],
        "flags": [_flag(row) for row in flags[flags.mechanism.isin([first, SHIFTED])].itertuples()],
        "nominal": [_cells(row) for row in nominal.itertuples()],
        "shifted": [_cells(row) for row in shifted.itertuples()],
        "by_set": _by_set(quoted, [name for name in about["sets"] if name != first]),
        "others": [_cells(row) for row in _others(coverage, first).itertuples()],
        "dropped": [
            _dropped(row)
            for row in dropped[dropped.mechanism == first].itertuples()
            if row.share_percent >= SHOWN_SHARE_PERCENT
        ],
        "code": about["code"],
        "seed": about["seed"],
    }


def sentences(nominal: pd.DataFrame, shifted: pd.DataFrame, dropped: pd.DataFrame, failed: int) -> list[str]:
    """What the numbers say, one sentence each (percentages in %).

    ``nominal`` and ``shifted`` are the recommended rows of the table of coverage, ``dropped`` those of the
    nominal laboratories without a source, ``failed`` the number of laboratories without results (-).
    """
    if nominal.empty:
        return ["No recommended estimate has an interval: nothing can be said about its coverage."]
    found = _on_coverage(nominal) + _on_width(nominal)
    flagged = nominal[nominal.flagged_percent > MOST_FLAGGED_PERCENT]
    if flagged.empty:
        most = _percent(nominal.flagged_percent.max())
        found.append(f"At most {most} % of the estimates of any of them are flagged in nominal laboratories.")
    else:
        found.append(
            f"More than {MOST_FLAGGED_PERCENT:g} % are flagged in nominal laboratories: "
            + _list(flagged, lambda row: f"{percent(row.flagged_percent)} %")
        )
    if not shifted.empty:
        found.append(_on_held(shifted, "in shifted laboratories"))
    if not dropped.empty:
        lacking = dropped[dropped.held_percent < LEAST_HELD_PERCENT]
        if lacking.empty:
            least = _percent(dropped.held_percent.min())
            found.append(
                f"Without any one source of the budget, at least {least} % of each recommended estimate are "
                "covered or flagged."
            )
        else:
            found.append(
                f"Without one source, fewer than {LEAST_HELD_PERCENT:g} % are covered or flagged: "
                + _list(
                    lacking,
                    lambda row: f"{percent(row.held_percent)} % without the {source_words(row.source)}",
                )
            )
    if failed:
        found.append(f"{failed} of the laboratories failed; they count in no share.")
    return found


def _on_coverage(nominal: pd.DataFrame) -> list[str]:
    below, above = nominal[nominal.coverage_high < NOMINAL], nominal[nominal.coverage_low > NOMINAL]
    held = len(nominal) - len(below)
    found = [
        f"In nominal laboratories, the coverage of {held} of {len(nominal)} recommended estimates is "
        "compatible with 95 % or higher."
    ]
    if len(below):
        found.append("It is below 95 %: " + _list(below, _share))
    if len(above):
        found.append("It is above 95 %, so that intervals are wider than needed: " + _list(above, _share))
    open_ = nominal[(nominal.coverage_high >= NOMINAL) & (nominal.coverage_low < INFORMATIVE_LOW)]
    if len(open_):
        found.append(
            f"Of {len(open_)} of them the coverage may still be below {100 * INFORMATIVE_LOW:g} %: more "
            "laboratories are needed to decide."
        )
    return found


def _on_width(nominal: pd.DataFrame) -> list[str]:
    known = nominal[nominal.width_ratio.notna()]
    if known.empty:
        return ["There are too few laboratories to compare widths with the errors that occur."]
    wide = known[known.width_ratio > WIDEST]
    if wide.empty:
        widest = number(known.width_ratio.max(), 2)
        return [f"No interval is wider than {widest} times the one that holds 95 % of the errors that occur."]
    return [
        f"Wider than {WIDEST:g} times the interval that holds 95 % of the errors that occur: "
        + _list(wide, lambda row: f"{number(row.width_ratio, 2)} times")
    ]


def _on_flags(nominal: pd.DataFrame) -> list[str]:
    """On the trials of nominal laboratories that any check flags."""
    above = nominal[nominal.low > MOST_FLAGGED_PERCENT]
    if nominal.empty:
        return []
    if above.empty:
        return [
            "The share of flagged trials in nominal laboratories is compatible with "
            f"{MOST_FLAGGED_PERCENT:g} % in every experiment."
        ]
    told = (f"{_experiment(row.experiment)} ({_percent(row.percent)} %)" for row in above.itertuples())
    return [
        f"More than {MOST_FLAGGED_PERCENT:g} % of the trials of nominal laboratories are flagged: "
        + "; ".join(told)
        + "."
    ]


def _on_held(rows: pd.DataFrame, where: str) -> str:
    lacking = rows[rows.held_percent < LEAST_HELD_PERCENT]
    if lacking.empty:
        least = _percent(rows.held_percent.min())
        return f"At least {least} % of each recommended estimate are covered or flagged {where}."
    return f"Fewer than {LEAST_HELD_PERCENT:g} % are covered or flagged {where}: " + _list(
        lacking, lambda row: f"{percent(row.held_percent)} %"
    )


def _list(rows: pd.DataFrame, say) -> str:
    """Estimates with what is said of each, those of one experiment and way together."""
    told: dict[str, list[str]] = {}
    for row in rows.itertuples():
        way = f"{_experiment(row.experiment)}, {_way(row)}"
        told.setdefault(way, []).append(f"{row.quantity} {say(row)}")
    return "; ".join(f"{way}: {', '.join(said)}" for way, said in told.items()) + "."


def _name(row) -> str:
    return f"{row.quantity} of the {_experiment(row.experiment)} by {_way(row)}"


def _way(row) -> str:
    """Pathway and estimator in words; the estimator only where the pathway does not name it."""
    pathway, estimator = words(row.pathway), _estimator(row.estimator)
    return pathway if pathway.endswith(estimator) else f"{pathway}, {estimator}"


def _estimator(name: str) -> str:
    """An estimator in words, for example "free reflex torque (GLS), 50 ms" for free-reflex-gls-50."""
    base, _, window = name.rpartition("-")
    return f"{words(base)}, {window} ms" if window.isdigit() else words(name)


def _constant(path: str) -> str:
    """A constant of the laboratory in words, with its direction where it has one."""
    index = path.rpartition(".")[2]
    if not index.isdigit():
        return words_of(path)
    return words_of(re.sub(r"(\.\d+)+$", "", path)) + DIRECTIONS.get(index, "")


def _experiment(name: str) -> str:
    return EXPERIMENTS.get(name, name)


def _share(row) -> str:
    share, *ends = (percent(100 * x) for x in (row.coverage, row.coverage_low, row.coverage_high))
    return f"{share} % ({ends[0]} to {ends[1]} %)"


def _others(coverage: pd.DataFrame, first: str) -> pd.DataFrame:
    return coverage[~coverage.recommended.astype(bool) & (coverage.mechanism == first)]


def _cells(row) -> list[str]:
    interval = (
        ""
        if math.isnan(row.coverage_low)
        else f"{100 * row.coverage_low:.0f} to {100 * row.coverage_high:.0f}"
    )
    return [
        _experiment(row.experiment),
        _way(row),
        row.quantity,
        "" if math.isnan(row.window_s) else f"{1e3 * row.window_s:.0f}",
        str(row.n),
        _percent(100 * row.coverage),
        interval,
        _signed(row.bias_percent),
        _percent(row.median_width_percent),
        number(row.width_ratio, 2),
        _percent(row.flagged_percent),
        _percent(row.false_alarm_percent),
        _percent(row.held_percent),
    ]


def _by_set(quoted: pd.DataFrame, names: list[str]) -> dict:
    """Share that is covered or flagged, by estimate and set."""
    rows: dict[str, dict[str, str]] = {}
    for row in quoted[quoted.mechanism.isin(names)].itertuples():
        text = f"{_percent(100 * row.coverage)} / {_percent(row.held_percent)}"
        rows.setdefault(_name(row), {})[row.mechanism] = text
    return {
        "names": names,
        "rows": [[name, *(cells.get(n, number(None)) for n in names)] for name, cells in rows.items()],
    }


def _dropped(row) -> list[str]:
    return [
        _name(row),
        source_words(row.source),
        _percent(row.share_percent),
        _percent(100 * row.coverage),
        f"{100 * row.coverage_low:.0f} to {100 * row.coverage_high:.0f}",
        _percent(row.held_percent),
    ]


def _flag(row) -> list[str]:
    names = [_experiment(row.experiment), row.flag, row.mechanism, str(row.trials)]
    return [*names, _percent(row.percent), f"{row.low:.0f} to {row.high:.0f}"]


def _percent(value: float) -> str:
    return number(None) if math.isnan(value) else percent(value, 0 if abs(value) >= 9.95 else 1)


def _signed(value: float) -> str:
    return _percent(value) if math.isnan(value) or value < 0.0 else f"+{_percent(value)}"


def _changes(chosen: dict, first: bool) -> str:
    """What a set changes, in words."""
    parts = ["as the analysis assumes"] if first else []
    if chosen.get("shift"):
        parts.append(f"every mean {chosen['shift']:g} standard deviations up or down")
    if chosen.get("student_freedom"):
        parts.append(f"Student's t with {chosen['student_freedom']:g} degrees of freedom")
    parts += [f"{_constant(path)} times {factor:g}" for path, factor in chosen.get("factors", {}).items()]
    parts += [f"{_constant(path)} = {value}" for path, value in chosen.get("constants", {}).items()]
    return "; ".join(parts) or "nothing"


def _distribution(entry: dict) -> str:
    unit = " of the number" if entry.get("relative") else ""
    if "normal" in entry:
        return f"normal, standard deviation {entry['normal']:g}{unit}"
    if "rectangular" in entry:
        return f"rectangular, half width {entry['rectangular']:g}{unit}"
    deviation, freedom = entry["student"]
    return f"Student, standard deviation {deviation:g}{unit}, {freedom:g} degrees of freedom"
