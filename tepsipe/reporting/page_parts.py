"""Parts that only the page of the report has.

The table of all trials: quoted estimates beside their truth, VAF and flags. The ledger: every statement and
every printed number of the thesis with its verdict, and the printed cells in their places. Numbers of the run
for its figures to try (explore.js), in SI units.
"""

import math
import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import TYPE_CHECKING, Annotated
from urllib.parse import quote

from tepsipe.drawing.names import PARAMETER_SETS, below_100, by_uncertainty, number, short_name, words
from tepsipe.drawing.trial_page import pack, text
from tepsipe.experiments.dummy.specification_curve import CHOICES, SPECIFICATIONS
from tepsipe.io.estimates import FLAGS, Estimate, Recovery
from tepsipe.io.result import Result
from tepsipe.quantities import unit_symbol
from tepsipe.reporting.ledger import IMPLIED, VERDICTS, WITHIN, CellVerdict

if TYPE_CHECKING:  # its module reaches all analyses
    from tepsipe.reporting.claims import ClaimVerdict

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
    true = {row.key: row.truth for row in recoveries}
    rows = []
    for experiment, conditions in trials.items():
        for condition in conditions:
            found = own.get((experiment, condition), [])
            quoted = {e.quantity: e for e in found if e.recommended and e.quantity in QUANTITIES}
            flags = dict.fromkeys(flag for e in quoted.values() for flag in e.flags.split(";") if flag)
            truth = {q: true[e.key] for q, e in quoted.items() if e.key in true}
            rows.append(TrialRow(experiment, condition, quoted, truth, _vaf(found, quoted), list(flags)))
    return rows


def _vaf(found: Sequence[Estimate], quoted: Mapping[str, Estimate]) -> float | None:
    ways = {(e.pathway, e.estimator) for e in quoted.values()}
    for name in VAFS:
        for e in found:
            if e.quantity == name and (e.pathway, e.estimator) in ways and math.isfinite(e.value):
                return e.value
    return None


def sortable(
    name: str,
    head: Sequence[str],
    rows: Sequence[str],
    filters: Mapping[str, tuple[str, Mapping[str, str]]],
    counted: str,
) -> str:
    """Table that the page's script sorts and filters; without the script it is a plain table.

    name: identifier of the table.
    head: HTML of its columns (with units).
    rows: HTML of its rows; a filter compares their attribute ``data-<key>``.
    filters: key -> words of the filter, and value of the attribute -> words of the choice; without choices it
        is a box that keeps rows with the attribute.
    counted: one row, in a word.
    """
    controls = ""
    for key, (label, choices) in filters.items():
        options = "".join(f'<option value="{text(v)}">{text(w)}</option>' for v, w in choices.items())
        select = f'{text(label)} <select name="{key}"><option value="">all</option>{options}</select>'
        box = f'<input type="checkbox" name="{key}"> {text(label)}'
        controls += f"<label>{select if choices else box}</label> "
    buttons = "".join(f'<th scope="col"><button type="button">{cell}</button></th>' for cell in head)
    return (
        f'<form class="filters" data-of="{name}" hidden>{controls}'
        '<label>Search <input type="search" autocomplete="off"></label> '
        f'<output data-counted="{text(counted)}"></output></form>\n'
        f'<div class="wide" tabindex="0"><table class="sortable" id="{name}">'
        f"<thead><tr>{buttons}</tr></thead>\n<tbody>\n{''.join(rows)}</tbody></table></div>\n"
    )


def trials_table(rows: Sequence[TrialRow]) -> str:
    """Table of trials (units in its header) that the page's script sorts and filters."""
    shown = [q for q in QUANTITIES if any(q in row.quoted for row in rows)]
    units = {q: next(row.quoted[q].unit for row in rows if q in row.quoted) for q in shown}
    head = ["Trial", "Signals"]
    for q in shown:
        name = f"<i>{q}</i>" if len(q) == 1 else q
        head.append(f"{name} ({text(unit_symbol(units[q]))})")
    head += ["VAF, trial (%)" if any(q in shown for q in "BIK") else "VAF (%)", "Flags"]
    known = any(row.truth for row in rows)
    beside = " The true value, unknown to the analysis, is below each estimate." if known else ""
    if any(not row.quoted for row in rows):
        beside += (
            " A row is empty if no estimate of this trial alone is recommended, for example because the "
            "trial calibrates the rig or because all trials of a task are fitted together."
        )
    experiments = {e: _called(e) for e in dict.fromkeys(r.experiment for r in rows)}
    filters = {"experiment": ("Experiment", experiments), "flagged": ("flagged only", {})}
    return (
        "<p>Each trial has its own page with zoomable signals, all estimates, the files, and the command "
        "that repeats the trial. The table lists the recommended estimates with their standard "
        f"uncertainties and flags.{beside}</p>\n"
        + sortable("trials-table", head, [_row(row, shown) for row in rows], filters, "trial")
        + _meanings(rows)
        + '<h3 id="raw-data">Raw data</h3>\n<p>The page of a trial links to its raw files, to the trial file '
        "made from them (HDF5), to its fit and to its estimates.</p>\n"
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
        f'<th scope="row"><a href="{text(path)}">{text(row.condition)}</a>'
        f"<small>{text(_called(row.experiment))}</small></th>",
        f'<td><a href="{text(path)}" tabindex="-1" aria-hidden="true">'
        f'<img src="{picture}" alt="" loading="lazy" width="120" height="32"></a></td>',
    ]
    for q in shown:
        estimate = row.quoted.get(q)
        truth = row.truth.get(q)
        true = "" if truth is None else f"true {number(truth)}"
        cells.append(_number(None if estimate is None else estimate.value, _with_uncertainty(estimate), true))
    vaf = "" if row.vaf is None else below_100(f"{row.vaf:.1f}", row.vaf).replace("-", "\N{MINUS SIGN}")
    cells.append(_number(row.vaf, vaf))
    flags = (f'<span title="{text(FLAGS.get(flag, flag))}">{text(flag)}</span>' for flag in row.flags)
    cells.append(f"<td>{', '.join(flags)}</td>")
    flagged = ' data-flagged="yes"' if row.flags else ""
    return f'<tr data-experiment="{text(row.experiment)}"{flagged}>{"".join(cells)}</tr>\n'


def _number(value: float | None, shown: str, below: str = "") -> str:
    """A cell with the number by which it is sorted, and words below it."""
    sorted_by = "" if value is None or not math.isfinite(value) else f' data-value="{value:.6g}"'
    small = f" <small>{text(below)}</small>" if below else ""
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


BY_CELLS, UNTESTED = "tested by cells", "not tested"
# a sign for each verdict beside its colour, and its meaning
SIGNS = dict(zip(VERDICTS, ("=", "f", "p", "~", "i", "e", "≠", "×", "?", "–"), strict=True))
MEANINGS = {
    "implied": "within the tolerance; follows from algebra or from the thesis's own numbers, without any "
    "laboratory",
    "fitted": "within the tolerance; constants of the virtual laboratory were fitted, now or earlier, to "
    "this number or to numbers from which it is computed",
    "predicted": "within the tolerance; constants were fitted to other numbers only",
    "pattern": "the claim is an inequality, and it holds. (An inequality between fitted numbers is "
    "fitted, one for which a processing was chosen an interpretation, one of printed numbers implied.)",
    "interpretation": "within the tolerance; the processing was chosen because it fits",
    "explained": "outside the tolerance, but our explanation predicts a number within it",
    "contradicted by itself": "the numbers that the thesis itself prints do not satisfy the claim",
    "not reproduced": "outside the tolerance, or the inequality does not hold",
    "unknown": "we know no rule that yields the printed number",
    "not computed": "not part of this study",
    BY_CELLS: "printed cells test the statement; it has no number of its own",
    UNTESTED: "the thesis prints no number to compare with, or the statement is not a result",
}
ROWS = {
    "error": "fit error",
    "VAF_trial": "VAF, full dataset",
    "VAF_perturbation": "VAF, perturbation",
    "VAF_cross_validated": "VAF, cross-validated",
    "VAF_theta_perturbation": "VAF of the angle, perturbation",
    "VAF_theta_trial": "VAF of the angle, full dataset",
}
COLUMNS = {"none": "no noise", "tau": "noise on τ", "theta": "noise on θ", "both": "noise on both"}
LEDGER = "ledger-table"


def ledger_table(
    statements: Sequence[Mapping], claims: Sequence["ClaimVerdict"], cells: Sequence[CellVerdict]
) -> str:
    """All that the thesis states, with the verdicts of this run: one table, then the cells in their places.

    statements: ``where`` and ``says`` of every statement in its order, and ``tables`` whose cells test it or
        ``unchecked``, the reason why nothing does.
    claims: numbers of statements that this run tests (units in them).
    cells: printed cells of the thesis's tables (units of the tables).
    """
    numbered = {str(k): one for k, one in enumerate(statements, start=1)}
    of_claims: dict[str, list[ClaimVerdict]] = {}
    for claim in claims:
        of_claims.setdefault(claim.statements.partition(";")[0], []).append(claim)
    used = [claim.used for claim in claims] + [cell.reason.partition("; used: ")[2] for cell in cells]
    bases = list(dict.fromkeys(filter(None, map(_basis, used))))
    rows = []
    for k, statement in numbered.items():
        rows += [_claim(claim, numbered, bases) for claim in of_claims.pop(k, [])]
        tables = ", ".join(_of_thesis(name) for name in statement.get("tables", ()))
        if "unchecked" in statement:
            rows.append(_untested(statement, UNTESTED, statement["unchecked"]))
        elif tables and not any(k in claim.statements.split(";") for claim in claims):
            rows.append(_untested(statement, BY_CELLS, f"The cells of {tables} test it."))
    rows += [_claim(claim, numbered, bases) for own in of_claims.values() for claim in own]
    rows += [_ledger_cell(cell, bases) for cell in cells]
    judged = (*claims, *cells)
    verdicts = [v for v in VERDICTS if any(v == one.verdict for one in judged)]
    kinds = {"claim": "claims", "cell": "printed cells", "untested": "statements without a number"}
    chosen = {v: v for v in (*verdicts, BY_CELLS, UNTESTED)}
    filters = {"kind": ("Kind", kinds), "verdict": ("Verdict", chosen)}
    head = ("Statement", "Where", "Reported ± tolerance", "This run", "Null model", "Verdict")
    head += ("Explanation", "Source")
    within = sum(one.verdict in WITHIN for one in judged)
    null = sum(one.null_verdict == IMPLIED for one in judged)
    shown = [v for v in (*verdicts, BY_CELLS, UNTESTED) if any(f'data-verdict="{v}"' in row for row in rows)]
    meanings = "".join(f"<dt>{_verdict(v)}</dt><dd>{text(MEANINGS[v])}</dd>\n" for v in shown)
    listed = "".join(
        f'<li id="basis-{k}">{text(_sentence(basis))}</li>\n' for k, basis in enumerate(bases, start=1)
    )
    places = f'<h3 id="printed-cells">Printed cells in their places</h3>\n{printed_cells(cells)}'
    return (
        f"<p>We test {len(claims)} numbers of the thesis's statements and {len(cells)} printed cells. This "
        f"run is within tolerance for {within} of these {len(judged)} numbers. The null model, which needs "
        "no laboratory (it is, for example, the mean of the printed row), is within tolerance for "
        f"{null}. An asterisk (∗) marks those {null}: if this run agrees there, too, it is no evidence for "
        "the laboratory. "
        "The last column links to the source of this run's value.</p>\n"
        f"{sortable(LEDGER, head, rows, filters, 'row')}"
        f'<h3 id="verdicts">Verdicts</h3>\n<dl class="flags">\n{meanings}</dl>\n'
        f'<h3 id="bases">Sources of the values</h3>\n<ol class="bases">\n{listed}</ol>\n'
        f"{places if cells else ''}"
    )


def _basis(used: str) -> str:
    """What a number was obtained from, without remarks on its threshold and null model."""
    return used.partition("; cannot discriminate")[0].partition("; our threshold")[0]


def _based(basis: str, bases: Sequence[str]) -> str:
    """Number of a basis, with a link to it."""
    k = bases.index(basis) + 1 if basis in bases else 0
    return f'<a class="basis" href="#basis-{k}" aria-label="source {k}">{k}</a>' if k else ""


def _claim(claim: "ClaimVerdict", statements: Mapping[str, Mapping], bases: Sequence[str]) -> str:
    """Row of a claim."""
    unit = "" if claim.unit == "1" else f" ({unit_symbol(claim.unit)})"
    tested = " ".join(statements[k]["says"] for k in claim.statements.split(";") if k in statements)
    sign = {"below": "< ", "above": "> "}.get(claim.tolerance)
    exact = sign or not claim.tolerance or float(claim.tolerance) == 0.0
    margin = "" if exact else f"± {_printed(float(claim.tolerance))}"
    if "our threshold" in claim.used:
        margin += " our threshold"
    why = claim.reason or f'See Section "{claim.section}"'
    ours = text(claim.claim.replace(" - ", ": ") + unit)
    statement = f"{text(tested)} <small>We test: {ours}</small>" if tested else ours
    return _ledger_row(
        *("claim", statement, claim.where),
        *((sign or "") + _printed(claim.reported), margin, claim.reported),
        *(claim.reproduced, claim.null_value, claim.null_verdict, claim.verdict),
        *("" if claim.verdict in WITHIN else _linked(why), _based(_basis(claim.used), bases)),
    )


def _ledger_cell(cell: CellVerdict, bases: Sequence[str]) -> str:
    """Row of a printed cell."""
    why, _, used = cell.reason.partition("; used: ")
    return _ledger_row(
        *("cell", f"{_row_name(cell.row)}, {text(_column_name(cell.column))}", _of_thesis(cell.table)),
        *(_printed(cell.reported), f"tolerance {_tolerance(cell)}", cell.reported),
        *(cell.value, cell.null_value, cell.null_verdict, cell.verdict),
        *(text(_sentence(why)), _based(_basis(used), bases)),
    )


def _linked(words: str) -> str:
    """A sentence as HTML; sections that it names by their titles in quotation marks are links."""
    return re.sub("Section &quot;(.*?)&quot;", r'<a href="#section:\1">\1</a>', text(_sentence(words)))


def _tolerance(cell: CellVerdict) -> str:
    """Tolerance of a cell with a minus sign, and without powers of ten."""
    number_found = re.fullmatch(r"[\d.]+(e-\d+)?", cell.tolerance)
    return _printed(float(cell.tolerance)) if number_found else cell.tolerance.replace(" - ", " − ")


def _sentence(words: str) -> str:
    """Words that begin with a capital letter and end with a full stop."""
    return words[:1].upper() + words[1:].rstrip(".") + "." * bool(words)


def _untested(statement: Mapping, verdict: str, why: str) -> str:
    """Row of a statement that no number tests by itself."""
    return _ledger_row(
        *("untested", text(statement["says"]), statement["where"], "", "", None, None, None, ""),
        *(verdict, _linked(why), ""),
    )


def _ledger_row(
    kind: str,
    statement: str,
    where: str,
    reported: str,
    margin: str,
    compared: float | None,
    value: float | None,
    null: float | None,
    null_verdict: str,
    verdict: str,
    why: str,
    source: str,
) -> str:
    """Row of the ledger: numbers (unit of the statement), and HTML of ``statement``, ``why``, ``source``."""
    mark = "∗" if null_verdict == IMPLIED else ""
    shown = ("" if x is None or compared is None else _near(compared, x) for x in (value, null))
    run, other = shown
    return (
        f'<tr data-kind="{kind}" data-verdict="{text(verdict)}"><th scope="row">{statement}</th>'
        f"<td>{text(where)}</td>{_number(compared, reported, margin)}{_number(value, run)}"
        f"{_number(null, other + mark)}<td>{_verdict(verdict)}</td><td>{why}</td>"
        f"<td>{source}</td></tr>\n"
    )


def _verdict(verdict: str) -> str:
    """A verdict with its sign and colour."""
    sign = SIGNS.get(verdict, "–")
    return f'<span class="verdict {_kind(verdict)}"><b>{sign}</b> {text(verdict)}</span>'


def _printed(value: float) -> str:
    """A printed number with all of its digits."""
    return f"{value:.8f}".rstrip("0").rstrip(".").replace("-", "\N{MINUS SIGN}")


def _near(printed: float, value: float) -> str:
    """A number to be compared with a printed one: one digit more than that has, and at least three."""
    digits = len(_printed(printed).lstrip("\N{MINUS SIGN}0.").replace(".", ""))
    if value.is_integer() and printed.is_integer():
        return _printed(value)
    return number(value, max(3, digits + 1))


def _of_thesis(table: str) -> str:
    return f"Table {table.removeprefix('table_').replace('_', '-')}"


def printed_cells(cells: Sequence[CellVerdict]) -> str:
    """Tables of the printed numbers (units of the thesis's tables), coloured by verdict.

    Every cell shows the printed number, the number of this run and the sign of its verdict. Its title has
    what the page's script shows where a cell is pointed at: tolerance, verdict, null model and reason.
    """
    used = [verdict for verdict in VERDICTS if any(cell.verdict == verdict for cell in cells)]
    key = "".join(f"{_verdict(v)} ({sum(cell.verdict == v for cell in cells)}) " for v in used)
    names = dict.fromkeys(cell.table for cell in cells)
    return (
        '<div class="printed-cells">\n<p>Each cell shows the printed number, with the number of this run '
        "below it. An asterisk (∗) means that the null model is within the tolerance. Point at a "
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
    head = "".join(f'<th scope="col">{text(_column_name(c))}</th>' for c in columns)
    body = ""
    for row in dict.fromkeys(cell.row for cell in cells):
        own = {cell.column: cell for cell in cells if cell.row == row}
        shown = "".join(_cell(own[c]) if c in own else "<td></td>" for c in columns)
        body += f'<tr><th scope="row">{_row_name(row)}</th>{shown}</tr>\n'
    return (
        '<div class="wide" tabindex="0"><table class="cells">'
        f"<caption>{_of_thesis(name)} of the thesis</caption>"
        f"<thead><tr><td></td>{head}</tr></thead>\n<tbody>\n{body}</tbody></table></div>\n"
    )


def _row_name(row: str) -> str:
    start, _, quantity = row.rpartition("_")
    if start == "SEM":
        return f"SEM of <i>{text(quantity)}</i>"
    return f"<i>{row}</i>" if len(row) == 1 else text(ROWS.get(row, row))


def _column_name(column: str) -> str:
    return COLUMNS.get(column, short_name(column))


def _cell(cell: CellVerdict) -> str:
    value = math.nan if cell.value is None else cell.value
    within, known = "within" if cell.null_verdict == IMPLIED else "not within", math.isfinite(value)
    printed = _printed(cell.reported)
    about = {
        "printed": printed,
        "this run": number(value, 5) if known else "not computed",
        "tolerance": _tolerance(cell),
        "verdict": cell.verdict,
        "null model": "none" if cell.null_value is None else f"{number(cell.null_value, 4)}, {within}",
        "reason": cell.reason,
    }
    words = "\n".join(f"{name}: {value}" for name, value in about.items())
    mark = "∗" if cell.null_verdict == IMPLIED else ""
    run = f"<small>{text(_beside(printed, value))}</small>" if known else ""
    return (
        f'<td class="{_kind(cell.verdict)}" title="{text(words)}">{printed} '
        f"<b>{SIGNS[cell.verdict]}{mark}</b>{run}</td>"
    )


def _beside(printed: str, value: float) -> str:
    """A number of the run with one decimal more than the printed one."""
    rounded = f"{value:.{len(printed.partition('.')[2]) + 1}f}"
    return rounded.replace("-", "\N{MINUS SIGN}") if float(rounded) else number(value, 1)


def explored(
    geometry: Mapping[str, float],
    specifications: str,
    estimates: Iterable[Estimate],
    truth: Sequence[Recovery],
    simulated: Mapping[str, Result],
) -> dict[str, tuple[str, object]]:
    """Return what there is to try below the figures of the dummy.

    specifications: table of the specification curve.
    estimates: of the study, of which the recommended K is shown.
    truth: known constants, empty for recordings.
    simulated: condition -> fit of `simulation_result`, of one trial or none.
    Returns: anchor of a figure -> function of explore.js, and its data.
    """
    found = {
        "figure_torque": ("apparent", apparent(geometry, truth)),
        "figure_specification": ("specification", specification(specifications, estimates, truth)),
    }
    for condition, fit in simulated.items():
        found["figure_4_7"] = ("forward", forward(fit, condition, geometry, truth))
    return {figure: content for figure, content in found.items() if content[1]}


def leg_of(geometry: Mapping[str, float]) -> dict[str, float]:
    """Leg of the dummy by its settings: mass (kg), com (m), inertia (kg·m²), gravity (m/s²)."""
    return {
        "mass": geometry["leg_mass_kg"],
        "com": geometry["leg_com_m"],
        "inertia": geometry["leg_inertia_kgm2"],
        "gravity": geometry["gravity_m_per_s2"],
    }


def apparent(geometry: Mapping[str, float], truth: Sequence[Recovery]) -> dict | None:
    """The leg and the true joint of the dummy for small movements (I, B, K); None where no truth is known."""
    joint = _true_joint(truth)
    return {"leg": leg_of(geometry), "joint": joint} if joint else None


def _true_joint(truth: Sequence[Recovery]) -> dict[str, float] | None:
    """True I, B, K of the dummy for small movements (N·m·s²/rad, N·m·s/rad, N·m/rad)."""
    known = {r.quantity: r.truth for r in truth if r.experiment == "dummy"}
    joint = {q: known.get(f"{q}_small", known.get(q)) for q in "IBK"}
    return None if None in joint.values() else joint


def forward(
    simulated: Result, condition: str, geometry: Mapping[str, float], truth: Sequence[Recovery]
) -> dict:
    """A trial of the dummy for the forward simulation in the browser.

    simulated: fit of `simulation_result`: recorded foot and leg, and the joints that were simulated.
    geometry: the leg by its settings (kg, m, kg·m²).
    truth: known constants, empty for recordings.
    Returns: leg, clock (Hz), packed signals, windows (samples), joints (recommended first), true joint or
    None.
    """
    arrays, facts = simulated.arrays, simulated.facts
    time = arrays["time"]
    names = sorted(facts["joints"], key=lambda name: name not in facts["softens"])
    return {
        "leg": leg_of(geometry),
        "rate": (time.size - 1) / float(time[-1] - time[0]),
        "standing": facts["standing_rad"],
        "velocity": asdict(pack(arrays["foot_velocity"])),
        "angle": asdict(pack(arrays["theta"])),
        "windows": arrays["windows"].astype(int).tolist(),
        "sets": [_joint(PARAMETER_SETS.get(name, name), facts["joints"][name]) for name in names],
        "truth": _true_joint(truth),
        "condition": short_name(condition),
    }


def _joint(name: str, constants: Mapping[str, float]) -> dict:
    """A joint by the symbols of swing.js."""
    symbols = {
        "inertia_Nms2_per_rad": "I",
        "damping_Nms_per_rad": "B",
        "stiffness_Nm_per_rad": "K",
        "softening_Nm_per_rad": "C",
        "softened_damping_Nms_per_rad": "D",
        "half_softening_rad": "half",
    }
    return {"name": name} | {symbols[key]: value for key, value in constants.items() if key in symbols}


# roles of combinations, neither of which is the estimate to quote
ROLES = {"recommended": "the consistent torque in the tables", "as printed": "the thesis as printed"}


def specification(path: str, estimates: Iterable[Estimate], truth: Sequence[Recovery]) -> dict | None:
    """Combinations of the specification curve (table) by K, and the recommended and true K of its trial.

    K in N·m/rad; None without combinations.
    """
    rows = [row for row in SPECIFICATIONS.read(path) if math.isfinite(row.K_Nm_per_rad)]
    if not rows:
        return None
    rows.sort(key=lambda row: row.K_Nm_per_rad)
    wanted = ("dummy", rows[0].condition, "K", True)

    def of_trial(row: Estimate | Recovery) -> bool:
        return (row.experiment, row.condition, row.quantity, row.recommended) == wanted

    quoted = next((e for e in estimates if of_trial(e)), None)
    marked = [row.K_Nm_per_rad for row in rows if row.role == "recommended"]
    middle = marked[0] if marked else rows[len(rows) // 2].K_Nm_per_rad
    return {
        "steps": list(CHOICES),
        "rows": [
            {
                "K": row.K_Nm_per_rad,
                "B": _finite_or_none(row.B_Nms_per_rad),
                "VAF": _finite_or_none(row.VAF_percent),
                "role": ROLES.get(row.role or "", row.role or ""),
                "options": [words(getattr(row, step)) for step in CHOICES],
            }
            for row in rows
        ],
        "quoted": {"K": quoted.value, "by": words(quoted.estimator)} if quoted else None,
        "truth": next((r.truth for r in truth if of_trial(r)), None),
        "limits": [middle - 12.0, middle + 12.0],
    }


def _finite_or_none(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None
