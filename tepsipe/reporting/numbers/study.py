"""Numbers of the report that several chapters share: tables, claims, recovery, provenance."""

import hashlib
import math
from collections.abc import Iterable

import numpy as np
import pandas as pd

from tepsipe.io.estimates import FLAGS
from tepsipe.reporting.figures.names import unit_symbol, words
from tepsipe.reporting.ledger import VERDICTS
from tepsipe.reporting.numbers.format import MINUS, _cell, number, percent, span
from tepsipe.reporting.recovery import AT_WORK
from tepsipe.treadmill.registry import MODEL_MEANINGS

EXPERIMENT_WORDS = {
    "wristalyzer": "the Wristalyzer",
    "dummy": "the dummy",
    "weight": "the weight",
    "standing": "the standing person",
    "position_manipulator": "the position-controlled manipulator",
    "platform": "the moving platform",
}


def names_data(estimates: pd.DataFrame, choices: dict) -> dict[str, str]:
    """How the report calls every pathway, estimator and model of a run (no unit): identifier -> words."""
    found = {*estimates.pathway, *estimates.estimator, *MODEL_MEANINGS}
    for section in choices.values():
        found |= {name for key in ("estimators", "table_estimators") for name in section.get(key) or ()}
    return {name: words(name) for name in sorted(map(str, found))}


def flags_data(estimates: pd.DataFrame) -> dict:
    """Flags of the estimates (values in their units) as text, for the first page.

    Returns
    -------
    dict
        ``count`` of flagged estimates, ``total``, and ``kinds``: name, count and meaning of each flag;
        ``recommended``: the same of the recommended estimates, with ``where`` in place of the count.
    """
    named = estimates["flags"].fillna("").astype(str).str.split(";")
    kinds = [(name, int(named.map(lambda own, n=name: n in own).sum()), FLAGS[name]) for name in FLAGS]
    quoted = estimates["recommended"].astype(str).str.lower() == "true"
    failed = []
    for name, meaning in FLAGS.items():
        rows = estimates[quoted & named.map(lambda own, n=name: n in own)]
        if len(rows):
            failed.append({"name": name, "where": _where(rows), "meaning": meaning})
    return {
        "count": int((estimates["flags"].fillna("") != "").sum()),
        "total": len(estimates),
        "kinds": [{"name": n, "count": str(count), "meaning": m} for n, count, m in kinds if count],
        "recommended": {
            "count": str(int((estimates["flags"].fillna("") != "")[quoted].sum())),
            "total": str(int(quoted.sum())),
            "kinds": failed,
        },
    }


def _where(rows: pd.DataFrame, most: int = 4) -> str:
    """Quantities and trials of some estimates, at most ``most`` trials of an experiment by name."""
    parts = []
    for experiment, own in rows.groupby("experiment", sort=False):
        quantities = " and ".join(sorted(dict.fromkeys(own.quantity), reverse=True))
        trials = list(dict.fromkeys(own.condition))
        named = ", ".join(trials[:most]) + (f" and {len(trials) - most} more" if len(trials) > most else "")
        parts.append(f"{quantities} of {EXPERIMENT_WORDS.get(experiment, experiment)} ({named})")
    return "; ".join(parts)


def reported_data(reported: dict, start_stiffness: float) -> dict:
    """Values of the thesis that the report quotes, as text.

    Parameters
    ----------
    reported : dict
        The file of reported values (units in its keys, and as in the tables).
    start_stiffness : float
        Printed starting value of K (N·m/rad).

    Returns
    -------
    dict
        Text.
    """
    wristalyzer = reported["tables"]["table_4_1"]
    stiffness = list(wristalyzer["K"].values())
    inertia = list(wristalyzer["I"].values())
    ratio = float(np.mean(stiffness) / np.mean(inertia))
    meant = {(s["table"], s["quantity"], s["condition"]): s["meant"] for s in reported["slips"]}

    def _on_belt(quantity: str) -> list[float]:
        return [
            meant.get((name, quantity, condition), value)
            for name in ("table_4_2", "table_4_3")
            for condition, value in reported["tables"][name][quantity].items()
        ]

    vaf_trial = _on_belt("VAF_trial")
    return {
        **{key: f"{value:g}" for key, value in reported["values"].items()},
        "natural_frequency_hz": number(math.sqrt(ratio) / 2.0 / math.pi, 2),
        "start_stiffness": f"{start_stiffness:g}",
        "stiffness_at_start": str(sum(abs(k - start_stiffness) < 5e-4 for k in stiffness)),
        "stiffness_count": str(len(stiffness)),
        "inertia": span(_on_belt("I"), 2),
        "stiffness": span(_on_belt("K"), 2),
        "sem_stiffness": span(_on_belt("SEM_K"), 2),
        "vaf": span(wristalyzer["VAF_trial"].values(), 2),
        "vaf_end": float(list(wristalyzer["VAF_trial"].values())[-1]),
        "coherence_low": float(reported["values"]["coherence_minimum"]),
        "vaf_trial": f"{percent(min(vaf_trial), 2)} to {percent(max(vaf_trial), 2)}",
    }


def slips_data(slips: list[dict], table: str, conditions: list[str], names: list[str]) -> str:
    """One sentence per evident slip in a table of the thesis (no unit: values as printed).

    ``slips`` have the keys table, quantity, condition, printed, meant; ``names`` are how the table calls
    its ``conditions``.
    """
    called = dict(zip(conditions, names, strict=True))
    return " ".join(
        f"The thesis prints {slip['printed']:g} for {slip['quantity']} in {called[slip['condition']]}, "
        f"evidently a slip for {slip['meant']:g}."
        for slip in slips
        if slip["table"] == table and slip["condition"] in called
    )


def claims_data(claims: pd.DataFrame) -> dict:
    """Claims of the thesis with the findings of this run, as text (each in its unit)."""
    rows = [
        {
            "claim": row.claim,
            "where": row.where,
            "unit": "" if row.unit == "1" else unit_symbol(row.unit),
            "reported": {"below": "< ", "above": "> "}.get(row.tolerance, "")
            + f"{row.reported:g}".replace("-", MINUS),
            "tolerance": "" if row.tolerance in ("below", "above") else f"{float(row.tolerance):g}",
            "reproduced": _found(row.reported, row.reproduced),
            "verdict": row.verdict,
            "section": row.section,
        }
        for row in claims.itertuples()
    ]
    counts = claims.verdict.value_counts()
    return {
        "rows": rows,
        "total": str(len(rows)),
        **{key.replace(" ", "_"): str(int(counts.get(key, 0))) for key in VERDICTS},
    }


def _found(reported: float, value: float) -> str:
    """A value (any unit) with three significant digits, or one more than the reported one has."""
    if pd.isna(value):
        return number(None)
    digits = max(3, 1 + len(f"{reported:g}".lstrip("-0.").replace(".", "")))
    text = number(float(value), digits)
    whole, _, decimals = text.partition(".")
    return whole if decimals and not decimals.strip("0") and float(reported).is_integer() else text


JOINT = ("I", "B", "K")


def recovery_data(recovery: pd.DataFrame) -> dict:
    """Estimates beside the true values (in their units), as text.

    Returns
    -------
    dict
        ``joint``: one row for each experiment, pathway and estimator with I, B and K, each a truth, a median
        error (%) and a coverage; truths that differ from trial to trial, because they hold for the fitted
        windows, share a row, those for small movements have their own. ``other``: one row for each other
        quantity. ``windows``: whether any truth is one of fitted windows.
    """
    small = recovery.quantity.str.endswith("_small")
    own = recovery.assign(
        quantity=recovery.quantity.str.removesuffix("_small"),
        small=small | (recovery.truth_of != AT_WORK),
        shared=recovery.truth.where(recovery.truth_of != AT_WORK, math.nan),
    )
    joint, other = [], []
    for (experiment, pathway, estimator, is_small), group in own[own.quantity.isin(JOINT)].groupby(
        ["experiment", "pathway", "estimator", "small"], sort=False
    ):
        cells = {q: _recovered(q, group[group.quantity == q]) for q in JOINT}
        joint.append(
            {"experiment": experiment, "pathway": pathway, "estimator": estimator, "small": bool(is_small)}
            | cells
        )
    rest = own[~own.quantity.isin(JOINT)]
    for (experiment, _, estimator, quantity, _), group in rest.groupby(
        ["experiment", "pathway", "estimator", "quantity", "shared"], sort=False, dropna=False
    ):
        row = {"experiment": experiment, "quantity": quantity, "estimator": estimator}
        other.append(row | {"unit": unit_symbol(group.unit.iloc[0])} | _recovered(quantity, group))
    return {"joint": joint, "other": other, "windows": bool((recovery.truth_of == AT_WORK).any())}


def _recovered(quantity: str, group: pd.DataFrame) -> dict:
    """Truth, estimates (in their unit), median error (%) and coverage of some estimates, as text."""
    if not len(group):
        return dict.fromkeys(("truth", "estimates", "error", "covered"), "")
    errors = 100.0 * group.relative_error.dropna()
    median = errors.median() if len(errors) else math.nan
    covered = (group.covered.astype(str).str.lower() == "true").sum()
    low, high = _cell(quantity, group.value.min()), _cell(quantity, group.value.max())
    return {
        "truth": span(group.truth),
        "estimates": low if low == high else f"{low} to {high}",
        "error": _error(median),
        "covered": f"{covered} of {len(group)}",
    }


def _error(value: float) -> str:
    """A relative error (%) as text; beyond 1000 % only that."""
    if abs(value) < 1000.0 or not math.isfinite(value):
        return percent(value, 0 if abs(value) >= 100.0 else 1)
    return f"< {MINUS}1000" if value < 0.0 else "> 1000"


def provenance_data(provenance: dict) -> dict:
    """The provenance page as text: facts, packages, and one checksum for each kind of file (no units)."""
    commit = provenance["commit"] or "not a git checkout"
    if provenance["modified"]:
        commit += ", with uncommitted changes"
    engine = provenance["engine"]
    raw = [entry for kinds in provenance["raw_files"].values() for entry in kinds.values()]
    return {
        "facts": [
            ["Commit", commit],
            ["Python", provenance["python"]],
            *([["Engine of the simulations", f"{engine['name']} {engine['version']}"]] if engine else []),
            ["Configuration, SHA-256", provenance["config_sha256"]],
            ["Seed of the analysis", str(provenance["seed"])],
        ],
        "packages": [[name, text] for name, text in sorted(provenance["packages"].items())],
        "files": [[kind, entry["file"]] for kind, entry in provenance["files"].items()],
        "digests": [
            ["Files of the study", str(len(provenance["files"])), digest_of(provenance["files"].values())],
            ["Raw files", str(len(raw)), digest_of(raw)],
        ],
    }


def digest_of(entries: Iterable[dict]) -> str:
    """SHA-256 over the lines ``<sha256>  <file>`` (no unit) of some files, sorted.

    The same as ``sha256sum FILES | sort | sha256sum`` in the folder of the study.
    """
    lines = sorted(f"{entry['sha256']}  {entry['file']}\n" for entry in entries)
    return hashlib.sha256("".join(lines).encode()).hexdigest()
