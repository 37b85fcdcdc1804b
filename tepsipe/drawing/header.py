"""Header and footer of a trial's page: facts, estimates, omissions, source files, processing."""

import json
from collections.abc import Iterable, Mapping, Sequence
from pathlib import PurePath
from types import MappingProxyType

from tepsipe.drawing.names import below_100, by_uncertainty, number, words
from tepsipe.drawing.trial_page import table, text
from tepsipe.flags import COMPARED
from tepsipe.io.estimates import QUOTED, RECOVERIES, SMALL, Estimate, meaning_of
from tepsipe.io.trial import Trial
from tepsipe.quantities import unit_symbol

# quantities in the first table; all others are in the second, which opens on demand
FIRST = (
    "I",
    "B",
    "K",
    "mass",
    "added_force_peak",
    "VAF_perturbation",
    "VAF_response",
    "VAF_trial",
    "VAF_held_out",
)
LABELS = {
    "mass": "mass",
    "added_force_peak": "peak belt-induced force",
    "VAF_perturbation": "VAF, perturbation",
    "VAF_response": "VAF, response",
    "VAF_trial": "VAF, trial",
    "VAF_held_out": "VAF, held out",
    "VAF_cross_validated": "VAF, cross-validated",
    "VAF_theta_trial": "VAF of the angle, trial",
    "I_small": "I, small movements",
    "B_small": "B, small movements",
    "K_small": "K, small movements",
    "B_softened": "B gained by full softening",
    "K_softened": "K lost by full softening",
    "softening_angle": "bending at half softening",
    "K_over_mgh": "K / (m g h)",
    "rotation": "rotation of the ankle",
    "active_torque_share": "peak active torque / peak intrinsic torque",
    "twitch_time": "time constant of the twitch",
    "reflex_lag": "delay of the modelled reflex",
    "balance_delay": "delay of the balance response",
    "reflex_peak": "peak of the reflex torque",
    "reflex_impulse": "impulse of the reflex torque",
    "reflex_gain": "gain of the reflex",
    "reflex_delay": "delay of the reflex",
    "mass_sd": "standard deviation of the mass",
}
# attributes of a trial that the page shows elsewhere
NAMED = ("experiment", "condition", "participant", "belt", "rate_hz", "sources", "options")
NO_TRUTH: Mapping[tuple, float] = MappingProxyType({})
UNFLAGGED = "All checks passed."
# ends of the names of pathways and estimators that reproduce the thesis
PRINTED = ("-thesis", "as-printed")


def facts_list(facts: Iterable[tuple[str, str]]) -> str:
    """Pairs of a name and a text (units in it) as a list of HTML; pairs without a text are left out."""
    rows = "".join(f"<dt>{text(name)}</dt><dd>{text(value)}</dd>\n" for name, value in facts if value)
    return f'<dl class="facts">\n{rows}</dl>\n'


def sentences_list(heading: str, sentences: Sequence[str], otherwise: str) -> str:
    """Sentences (units in them) below a heading, or one that says that there is none."""
    if not sentences:
        return f"<p>{text(otherwise)}</p>\n"
    items = "".join(f"<li>{text(sentence)}</li>\n" for sentence in sentences)
    return f'<h2>{text(heading)}</h2>\n<ul class="left-out">\n{items}</ul>\n'


def estimates_table(estimates: Sequence[Estimate], choices: Mapping) -> str:
    """Estimates (in their units) with 95 % intervals, one row per pathway and estimator, then all of them.

    The rows to quote come first. The others are folded, each with the reason why it is not recommended.

    choices: of the page; ``truth`` has the true values by experiment, condition, pathway, estimator and
        quantity, ``small`` the keys of those for small movements, ``neutral`` keeps the thesis out of the
        names, and ``instead`` is what the study recommends if it quotes no single trial.
    """
    if not estimates:
        return "<p>This trial has no estimates of its own.</p>\n"
    truth, neutral = choices.get("truth", NO_TRUTH), choices.get("neutral", False)
    quantities = [q for q in FIRST if any(e.quantity == q for e in estimates)]
    units = {e.quantity: e.unit for e in estimates}
    groups: dict[tuple[str, str], dict[str, Estimate]] = {}
    for e in estimates:
        groups.setdefault((e.pathway, e.estimator), {})[e.quantity] = e
    header = ["Pathway", "Estimator", *(_heading(q, units[q]) for q in quantities)]
    told = {(e.pathway, e.estimator) for e in estimates if e.recommended}
    instead = choices.get("instead", "")
    better = " or ".join(dict.fromkeys(_way(names, neutral) for names in groups if names in told)) or instead
    asked = bool(told) or any(q in QUOTED for q in quantities)  # others have nothing to recommend
    shared = _failed(e for names in told for e in groups[names].values())
    quoted, others = [], []
    for names, found in groups.items():
        called = [text(words(name, neutral)) for name in names]
        cells = [_cell(found[q], truth) if q in found else "" for q in quantities]
        if names in told:
            quoted.append([f"{called[0]} <b>(recommended)</b>", called[1], *cells])
        else:
            why = [text(_why_not(names, found, shared, better, neutral))] if asked else []
            others.append([*called, *cells, *why])
    every = [
        [
            text(words(e.pathway, neutral)),
            text(words(e.estimator, neutral)),
            text(LABELS.get(e.quantity, e.quantity.replace("_", " "))),
            _cell(e, truth) + (" <b>(recommended)</b>" if e.recommended else ""),
            *(_part(u) for u in (e.u_type_a, e.u_type_b)),
            text(_unit(e.unit)),
            "" if e.n_perturbations is None else text(e.n_perturbations),
            text(e.flags.replace(";", "; ")),
        ]
        for e in estimates
    ]
    columns = ("Pathway", "Estimator", "Quantity", "Value (95 % interval)", "Type A", "Type B")
    columns += ("Unit", "Perturbations", "Flags")
    caption = (
        "Estimates with 95 % intervals."
        + _uncertainty_words(estimates)
        + _truth_words(estimates, truth, choices.get("small", ()))
        + (" † marks estimates that failed a check (see Flags)." if any(e.flags for e in estimates) else "")
    )
    reasons = ["Not recommended because"] if asked else []
    compared = table([*header, *reasons], others, "" if quoted else caption)
    shown = ""
    if quoted:
        shown = table(header, quoted, caption)
        compared = f"<details><summary>Other pathways and estimators ({len(others)})</summary>\n{compared}"
        compared = f"{compared}</details>\n" if others else ""
    elif asked:
        recommends = f"; the study recommends {text(instead)}" if instead else ""
        shown = (
            f"<p>No estimate of this trial is recommended{recommends}. The last column gives the reasons."
            "</p>\n"
        )
    return (
        f"{shown}{compared}"
        f"<details><summary>All estimates ({len(every)})</summary>\n{table(columns, every)}</details>\n"
    )


def _why_not(
    names: tuple[str, str], found: Mapping[str, Estimate], shared: Iterable[str], better: str, neutral: bool
) -> str:
    """Reasons why the estimates by a pathway and an estimator are not to be quoted.

    shared: checks that the recommended estimates failed, too.
    better: words of what is recommended, empty if nothing is.
    """
    if names[0] in COMPARED:
        reasons = [COMPARED[names[0]]]
    elif not neutral and any(name.endswith(PRINTED) or "-thesis-" in name for name in names):
        reasons = ["equation or method of the thesis, shown for comparison"]
    else:
        reasons = [f"the study recommends {better}"] if better else []
    reasons += [
        meaning_of(flag, found.values()).partition(". ")[0]
        for flag in _failed(found.values())
        if flag not in shared
    ]
    return "; ".join(reasons) or "the study does not quote it"


def _way(names: tuple[str, str], neutral: bool) -> str:
    """A pathway and an estimator in words; a pathway that is named after its estimator says both."""
    pathway, estimator = (words(name, neutral) for name in names)
    return pathway if estimator in pathway else f"{pathway}, {estimator}"


def _failed(estimates: Iterable[Estimate]) -> dict[str, None]:
    """Names of the checks that some estimate, other than a VAF, failed."""
    own = (e for e in estimates if not e.quantity.startswith("VAF"))
    return dict.fromkeys(flag for e in own for flag in e.flags.split(";") if flag)


def _uncertainty_words(estimates: Sequence[Estimate]) -> str:
    """Types of uncertainty in the intervals, if there is more than the scatter of the trial."""
    if all(e.u_type_b is None for e in estimates):
        return ""
    return (
        " Intervals combine statistical (Type A) and systematic (Type B) uncertainty. Where “All "
        "estimates” lists no Type B, they are statistical only."
    )


def _truth_words(estimates: Sequence[Estimate], truth: Mapping[tuple, float], small: Sequence[tuple]) -> str:
    """Sentences on the true values below the estimates, if there are any; ``small`` as in the choices."""
    known = [e for e in estimates if _key(e) in truth]
    if not known:
        return ""
    stiffness = [truth[_key(e)] for e in known if e.quantity == "K"]
    said = " The true value of the simulation, which the analysis does not use, is below each estimate."
    if stiffness and max(stiffness) - min(stiffness) > 1e-3 * abs(max(stiffness)):
        said += (
            " It belongs to the linear joint nearest to the simulated one in the movements that the "
            "estimator uses, so it differs between rows, and I can be slightly negative."
        )
        others = dict.fromkeys(words(e.estimator) for e in known if e.quantity == "K" and _key(e) in small)
        if others:
            said += f" For {' and '.join(others)} it is the constant for small movements."
    return said


def _part(u: float | None) -> str:
    """A standard uncertainty of one type, in the unit of the estimate."""
    return "" if u is None else text(number(u, 2))


def flagged(estimates: Sequence[Estimate], choices: Mapping) -> list[str]:
    """One sentence per failed check: the estimates that failed it (no unit), and what it says."""
    neutral = choices.get("neutral", False)
    found: dict[str, dict[str, dict[str, None]]] = {}
    for e in estimates:
        own = [other for other in estimates if other.estimator == e.estimator and other.pathway == e.pathway]
        for flag in filter(None, e.flags.split(";")):
            way = f"{words(e.pathway, neutral)}, {words(e.estimator, neutral)}"
            said = meaning_of(flag, own)
            found.setdefault(said, {}).setdefault(way, {})[LABELS.get(e.quantity, e.quantity)] = None
    named = {
        said: "; ".join(f"{way} ({', '.join(own)})" for way, own in ways.items())
        for said, ways in found.items()
    }
    return [f"{ways}: {said}." for said, ways in named.items()]


def _heading(quantity: str, unit: str) -> str:
    name = f"<i>{quantity}</i>" if len(quantity) == 1 else text(LABELS[quantity])
    return f"{name} ({text(_unit(unit))})"


def _unit(unit: str) -> str:
    return "" if unit == "1" else unit_symbol(unit)


def _key(e: Estimate) -> tuple[str, ...]:
    return e.experiment, e.condition, e.pathway, e.estimator, e.quantity


def _cell(estimate: Estimate, truth: Mapping[tuple, float]) -> str:
    value, interval = by_uncertainty(estimate.value, estimate.ci_low, estimate.ci_high)
    value = below_100(value, estimate.value) if estimate.quantity.startswith("VAF") else value
    mark = ' <b title="flagged, see below">\N{DAGGER}</b>' if estimate.flags else ""
    between = f' <span class="interval">({text(interval)})</span>' if interval else ""
    true = truth.get(_key(estimate))
    beside = "" if true is None else f'<br><span class="truth">true {text(number(true))}</span>'
    return f'<span class="nowrap">{text(value)}{mark}</span>{between}{beside}'


def _sources(trial: Trial) -> list[tuple[str, str, str]]:
    """Kind, path and SHA-256 of every source file."""
    sources = json.loads(trial.attributes.get("sources", "{}"))
    return [(kind, source["file"], source["sha256"]) for kind, source in sources.items()]


def sources_table(trial: Trial) -> str:
    """Source files of a trial with their SHA-256 (hexadecimal digits)."""
    rows = [
        [text(kind), f"<code>{text(file)}</code>", f"<code>{text(digits)}</code>"]
        for kind, file, digits in _sources(trial)
    ]
    return "<h2>Source files</h2>\n" + table(("Source", "File", "SHA-256"), rows) if rows else ""


def processing(trial: Trial) -> str:
    """What was done to every signal before the analysis; options and facts of that (units in their names)."""
    rows = [
        [
            f"<code>{text(name)}</code>",
            text("" if s.unit == "1" else unit_symbol(s.unit)),
            text(s.meaning),
            text("; ".join(s.processing)),
        ]
        for name, s in trial.signals.items()
    ]
    found = {name: value for name, value in trial.attributes.items() if name not in NAMED}
    found |= json.loads(trial.attributes.get("options", "{}"))
    written = ((name, json.dumps(value, ensure_ascii=False)) for name, value in found.items() if value != "")
    listed = f"<h3>Stored attributes of the trial</h3>\n{facts_list(written)}"
    shown = table(("Signal", "Unit", "Meaning", "Processing"), rows)
    return f"<details><summary>Signals and their processing</summary>\n{shown}{listed}</details>\n"


def trial_facts(trial: Trial, experiment: str, choices: dict) -> list[tuple[str, str]]:
    """Experiment, condition, participant, belt, origin, rate (Hz) and length (s), for `facts_list`."""
    length = float(trial.time[-1] - trial.time[0]) if trial.time.size else 0.0
    return [
        ("Experiment", experiment),
        ("Condition", choices["condition"]),
        ("Participant", choices.get("participant") or ""),
        ("Perturbed belt", choices.get("belt") or ""),
        ("Raw files", "simulated by the virtual laboratory" if choices["made"] else "recorded"),
        ("Rate and length", f"{trial.rate_hz:g} Hz, {length:.4g} s"),
        (
            "Source files, SHA-256",
            ", ".join(f"{PurePath(f).name} {digits[:12]}" for _, f, digits in _sources(trial)),
        ),
    ]


def choices_of_trial(files, chosen) -> dict:
    """Choices of a trial's page: study, the trial's row of the sheet, ``truth``, and ``neutral`` names."""
    rows = RECOVERIES.read(*files.truth) if files.truth else []
    truth = {(r.experiment, r.condition, r.pathway, r.estimator, r.quantity): r for r in rows}
    return {
        "study": chosen.title,
        "truth": {key: r.truth for key, r in truth.items()},
        "small": [key for key, r in truth.items() if r.truth_of == SMALL],
        "neutral": chosen.neutral,
        **chosen.trial,
    }


def facts_and_checks(facts: list, estimates: Sequence[Estimate], flags: list[str], choices: dict) -> str:
    """Header of a page without omissions: facts, estimates (units in them), failed checks."""
    found = [*flagged(estimates, choices), *flags]
    shown = estimates_table(estimates, choices)
    return facts_list(facts) + shown + sentences_list("Flags", found, UNFLAGGED)
