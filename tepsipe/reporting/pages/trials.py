"""Table of all trials on the page of the report: quoted estimates beside their truth, VAF and flags."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Annotated
from urllib.parse import quote

from tepsipe.io.estimates import FLAGS, Estimate, Recovery
from tepsipe.reporting.figures.names import unit_symbol
from tepsipe.reporting.format import by_uncertainty, number
from tepsipe.reporting.pages.html import text

# VAF of a trial: the first of these that an estimator has
VAFS = ("VAF_held_out", "VAF_trial", "VAF_response", "VAF_perturbation")
QUANTITIES = ("K", "B", "I", "mass")


@dataclass(frozen=True)
class TrialRow:
    """What the table shows of a trial."""

    experiment: str
    condition: str
    quoted: Mapping[str, Estimate]
    """Quantity -> the estimate to quote."""
    truth: Mapping[str, float]
    """Quantity -> its true value (unit of the estimate), of simulated trials."""
    vaf: Annotated[float, "%"] | None
    """VAF of the same estimator."""
    flags: Sequence[str]
    """Checks that some quoted estimate failed."""


def trial_rows(
    trials: Mapping[str, Sequence[str]], estimates: Iterable[Estimate], recoveries: Iterable[Recovery]
) -> list[TrialRow]:
    """Rows of all trials (experiment -> conditions), from the tables of estimates and of their truth."""
    own: dict[tuple[str, str], list[Estimate]] = {}
    for e in estimates:
        own.setdefault((e.experiment, e.condition), []).append(e)
    true = {(r.experiment, r.condition, r.pathway, r.estimator, r.quantity): r.truth for r in recoveries}
    rows = []
    for experiment, conditions in trials.items():
        for condition in conditions:
            found = own.get((experiment, condition), [])
            quoted = {e.quantity: e for e in found if e.recommended and e.quantity in QUANTITIES}
            keys = {q: (experiment, condition, e.pathway, e.estimator, q) for q, e in quoted.items()}
            flags = dict.fromkeys(flag for e in quoted.values() for flag in e.flags.split(";") if flag)
            truth = {q: true[key] for q, key in keys.items() if key in true}
            rows.append(TrialRow(experiment, condition, quoted, truth, _vaf(found, quoted), list(flags)))
    return rows


def _vaf(found: Sequence[Estimate], quoted: Mapping[str, Estimate]) -> float | None:
    ways = {(e.pathway, e.estimator) for e in quoted.values()}
    for name in VAFS:
        for e in found:
            if e.quantity == name and (e.pathway, e.estimator) in ways and math.isfinite(e.value):
                return e.value
    return None


def trials_table(rows: Sequence[TrialRow]) -> str:
    """Table of trials (units in its header) that the page's script sorts and filters."""
    shown = [q for q in QUANTITIES if any(q in row.quoted for row in rows)]
    units = {q: next(row.quoted[q].unit for row in rows if q in row.quoted) for q in shown}
    known = any(row.truth for row in rows)
    head = ["Experiment", "Trial", "Signals"]
    for q in shown:
        name = f"<i>{q}</i>" if len(q) == 1 else q
        head.append(f"{name} ({text(unit_symbol(units[q]))})")
    head += ["VAF (%)", "Flags"]
    buttons = "".join(f'<th scope="col"><button type="button">{cell}</button></th>' for cell in head)
    body = "".join(_row(row, shown) for row in rows)
    beside = " The true value, unknown to the analysis, is below each estimate." if known else ""
    experiments = "".join(
        f'<option value="{text(e)}">{text(_called(e))}</option>'
        for e in dict.fromkeys(r.experiment for r in rows)
    )
    return (
        "<p>Each trial has a page with its signals, which can be zoomed, and all its estimates. The table "
        f"lists the recommended estimates with their standard uncertainties.{beside}</p>\n"
        '<form class="filters"><label>Experiment <select id="trials-of"><option value="">all</option>'
        f"{experiments}</select></label> "
        '<label>Search <input type="search" id="trials-with" autocomplete="off"></label> '
        '<label><input type="checkbox" id="trials-flagged"> flagged only</label> '
        f'<output id="trials-count">{len(rows)} trials</output></form>\n'
        '<div class="wide" tabindex="0"><table class="trials" id="trials-table"><thead><tr>'
        f"{buttons}</tr></thead>\n<tbody>\n{body}</tbody></table></div>\n{_meanings(rows)}"
    )


def _meanings(rows: Sequence[TrialRow]) -> str:
    """A sentence for every flag in the table."""
    found = dict.fromkeys(flag for row in rows for flag in row.flags)
    items = "".join(f"<dt><code>{text(f)}</code></dt><dd>{text(FLAGS.get(f, f))}.</dd>\n" for f in found)
    return f'<dl class="flags">\n{items}</dl>\n' if found else ""


def _called(experiment: str) -> str:
    return experiment.replace("_", " ").capitalize()


def trial_page(experiment: str, condition: str) -> str:
    """Path of the page of a trial, relative to the report's page."""
    return "./" + quote(f"trials/{experiment}/{condition}.html")


def _row(row: TrialRow, shown: Sequence[str]) -> str:
    path = trial_page(row.experiment, row.condition)
    picture = text(path.removesuffix(".html") + ".svg")
    cells = [
        f"<td>{text(_called(row.experiment))}</td>",
        f'<th scope="row"><a href="{text(path)}">{text(row.condition)}</a></th>',
        f'<td><a href="{text(path)}" tabindex="-1" aria-hidden="true">'
        f'<img src="{picture}" alt="" loading="lazy" width="120" height="32"></a></td>',
    ]
    for q in shown:
        estimate = row.quoted.get(q)
        truth = row.truth.get(q)
        true = "" if truth is None else f"true {_as(truth, estimate)}"
        cells.append(_number(None if estimate is None else estimate.value, _with_uncertainty(estimate), true))
    cells.append(_number(row.vaf, "" if row.vaf is None else f"{row.vaf:.1f}".replace("-", "\N{MINUS SIGN}")))
    flags = (f'<span title="{text(FLAGS.get(flag, flag))}">{text(flag)}</span>' for flag in row.flags)
    cells.append(f"<td>{', '.join(flags)}</td>")
    flagged = ' data-flagged="yes"' if row.flags else ""
    return f'<tr data-experiment="{text(row.experiment)}"{flagged}>{"".join(cells)}</tr>\n'


def _number(value: float | None, shown: str, below: str = "") -> str:
    """A cell with the number by which it is sorted, and words below it."""
    sorted_by = "" if value is None or not math.isfinite(value) else f' data-value="{value:.6g}"'
    small = f"<small>{text(below)}</small>" if below else ""
    return f'<td class="n"{sorted_by}>{text(shown)}{small}</td>'


def _with_uncertainty(estimate: Estimate | None) -> str:
    if estimate is None:
        return ""
    u = estimate.standard_error
    if u is None or not u > 0.0 or not math.isfinite(u):
        return number(estimate.value)
    value, _ = by_uncertainty(estimate.value, estimate.value - u, estimate.value + u)
    decimals = len(value.partition(".")[2])
    return f"{value} ± {number(u, 2) if '·' in value else f'{u:.{decimals}f}'}"


def _as(truth: float, estimate: Estimate | None) -> str:
    """A true value with the digits of its estimate."""
    u = estimate.standard_error if estimate else None
    if u is None or not u > 0.0 or not math.isfinite(u):
        return number(truth)
    return by_uncertainty(truth, truth - u, truth + u)[0]
