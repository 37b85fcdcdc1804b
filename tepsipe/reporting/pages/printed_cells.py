"""The printed cells of the thesis's tables in their places, each with its verdict."""

from collections.abc import Sequence

from tepsipe.reporting.figures.names import short_name
from tepsipe.reporting.format import number
from tepsipe.reporting.ledger import IMPLIED, VERDICTS, CellVerdict
from tepsipe.reporting.pages.html import text

# a sign for each verdict beside its colour
SIGNS = dict(zip(VERDICTS, ("=", "f", "p", "~", "i", "e", "×", "?", "–"), strict=True))
ROWS = {
    "error": "fit error",
    "VAF_trial": "VAF, full dataset",
    "VAF_perturbation": "VAF, perturbation",
    "VAF_cross_validated": "VAF, cross-validated",
    "VAF_theta_perturbation": "VAF of the angle, perturbation",
    "VAF_theta_trial": "VAF of the angle, full dataset",
}
COLUMNS = {"none": "no noise", "tau": "noise on τ", "theta": "noise on θ", "both": "noise on both"}


def printed_cells(cells: Sequence[CellVerdict]) -> str:
    """Tables of the printed numbers (units of the thesis's tables), coloured by verdict.

    Every cell shows the printed number, the number of this run and the sign of its verdict. Its title has
    what the page's script shows where a cell is pointed at: tolerance, verdict, null model and reason.
    """
    used = [verdict for verdict in VERDICTS if any(cell.verdict == verdict for cell in cells)]
    key = "".join(
        f'<span class="verdict {_kind(verdict)}"><b>{SIGNS[verdict]}</b> {text(verdict)} '
        f"({sum(cell.verdict == verdict for cell in cells)})</span> "
        for verdict in used
    )
    names = dict.fromkeys(cell.table for cell in cells)
    return (
        '<div class="printed-cells">\n<p>Each cell shows the printed number, with the number of this run '
        "below it. An asterisk (∗) means that the null model is within the tolerance as well. Point at a "
        "cell, or use the arrow keys, to see its tolerance and the reason for its verdict.</p>\n"
        f'<p class="verdicts">{key}</p>\n'
        + "".join(_table(name, [cell for cell in cells if cell.table == name]) for name in names)
        + '<dl class="cell-about" aria-live="polite" hidden></dl>\n</div>\n'
    )


def _kind(verdict: str) -> str:
    return "v-" + verdict.replace(" ", "-")


def _table(name: str, cells: Sequence[CellVerdict]) -> str:
    """One table of the thesis."""
    columns = list(dict.fromkeys(cell.column for cell in cells))
    head = "".join(f'<th scope="col">{text(_column(c))}</th>' for c in columns)
    body = ""
    for row in dict.fromkeys(cell.row for cell in cells):
        own = {cell.column: cell for cell in cells if cell.row == row}
        shown = "".join(_cell(own[c]) if c in own else "<td></td>" for c in columns)
        body += f'<tr><th scope="row">{_row(row)}</th>{shown}</tr>\n'
    title = f"Table {name.removeprefix('table_').replace('_', '-')}"
    return (
        f'<div class="wide" tabindex="0"><table class="cells"><caption>{text(title)} of the thesis</caption>'
        f"<thead><tr><td></td>{head}</tr></thead>\n<tbody>\n{body}</tbody></table></div>\n"
    )


def _row(row: str) -> str:
    start, _, quantity = row.rpartition("_")
    if start == "SEM":
        return f"SEM of <i>{text(quantity)}</i>"
    return f"<i>{row}</i>" if len(row) == 1 else text(ROWS.get(row, row))


def _column(column: str) -> str:
    return COLUMNS.get(column, short_name(column))


def _cell(cell: CellVerdict) -> str:
    within = "within" if cell.null_verdict == IMPLIED else "not within"
    printed = f"{cell.reported:.8f}".rstrip("0").rstrip(".").replace("-", "\N{MINUS SIGN}")
    about = {
        "printed": printed,
        "this run": "not computed" if cell.value is None else number(cell.value, 5),
        "tolerance": cell.tolerance,
        "verdict": cell.verdict,
        "null model": "none" if cell.null_value is None else f"{number(cell.null_value, 4)}, {within}",
        "reason": cell.reason,
    }
    words = "\n".join(f"{name}: {value}" for name, value in about.items())
    mark = "∗" if cell.null_verdict == IMPLIED else ""
    run = "" if cell.value is None else f"<small>{text(_beside(printed, cell.value))}</small>"
    return (
        f'<td class="{_kind(cell.verdict)}" title="{text(words)}">{printed} '
        f"<b>{SIGNS[cell.verdict]}{mark}</b>{run}</td>"
    )


def _beside(printed: str, value: float) -> str:
    """A number of the run with one decimal more than the printed one."""
    rounded = f"{value:.{len(printed.partition('.')[2]) + 1}f}"
    return rounded.replace("-", "\N{MINUS SIGN}") if float(rounded) else number(value, 1)
