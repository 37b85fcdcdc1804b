"""Parts that only the page of the report has.

The table of all trials: quoted estimates beside their truth, VAF and flags. The printed cells of the thesis's
tables in their places, each with its verdict. Numbers of the run for its figures to try (explore.js), in SI
units.
"""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Annotated
from urllib.parse import quote

from tepsipe.drawing.names import PARAMETER_SETS, by_uncertainty, number, short_name, words
from tepsipe.drawing.trial_page import pack, text
from tepsipe.experiments.dummy.specification_curve import CHOICES, SPECIFICATIONS
from tepsipe.io.estimates import FLAGS, Estimate, Recovery
from tepsipe.io.result import Result
from tepsipe.quantities import unit_symbol
from tepsipe.reporting.ledger import IMPLIED, VERDICTS, CellVerdict

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


# a sign for each verdict beside its colour
SIGNS = dict(zip(VERDICTS, ("=", "f", "p", "~", "i", "e", "≠", "×", "?", "–"), strict=True))
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
    head = "".join(f'<th scope="col">{text(_column_name(c))}</th>' for c in columns)
    body = ""
    for row in dict.fromkeys(cell.row for cell in cells):
        own = {cell.column: cell for cell in cells if cell.row == row}
        shown = "".join(_cell(own[c]) if c in own else "<td></td>" for c in columns)
        body += f'<tr><th scope="row">{_row_name(row)}</th>{shown}</tr>\n'
    title = f"Table {name.removeprefix('table_').replace('_', '-')}"
    return (
        f'<div class="wide" tabindex="0"><table class="cells"><caption>{text(title)} of the thesis</caption>'
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


def explored(
    geometry: Mapping[str, float],
    specifications: str,
    truth: Sequence[Recovery],
    simulated: Mapping[str, Result],
) -> dict[str, tuple[str, object]]:
    """Return what there is to try below the figures of the dummy.

    specifications: table of the specification curve.
    truth: known constants, empty for recordings.
    simulated: condition -> fit of `simulation_result`, of one trial or none.
    Returns: anchor of a figure -> function of explore.js, and its data.
    """
    found = {
        "figure_torque": ("apparent", apparent(geometry, truth)),
        "figure_specification": ("specification", specification(specifications, truth)),
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


def specification(path: str, truth: Sequence[Recovery]) -> dict | None:
    """Combinations of the specification curve (table) sorted by K (N·m/rad), and the true K of its trial."""
    rows = [row for row in SPECIFICATIONS.read(path) if math.isfinite(row.K_Nm_per_rad)]
    if not rows:
        return None
    rows.sort(key=lambda row: row.K_Nm_per_rad)
    recommended = [row.K_Nm_per_rad for row in rows if row.role == "recommended"]
    true = [
        r.truth
        for r in truth
        if (r.experiment, r.condition, r.quantity) == ("dummy", rows[0].condition, "K") and r.recommended
    ]
    middle = recommended[0] if recommended else rows[len(rows) // 2].K_Nm_per_rad
    return {
        "steps": list(CHOICES),
        "rows": [
            {
                "K": row.K_Nm_per_rad,
                "B": _finite_or_none(row.B_Nms_per_rad),
                "VAF": _finite_or_none(row.VAF_percent),
                "role": row.role or "",
                "options": [words(getattr(row, step)) for step in CHOICES],
            }
            for row in rows
        ],
        "truth": true[0] if true else None,
        "limits": [middle - 12.0, middle + 12.0],
    }


def _finite_or_none(value: float | None) -> float | None:
    return value if value is not None and math.isfinite(value) else None
