"""Numbers of the report that several chapters share: tables, claims, recovery, provenance."""

import math

import numpy as np
import pandas as pd

from tepsipe.io.estimates import FLAGS
from tepsipe.reporting.figures.names import unit_symbol
from tepsipe.reporting.ledger import VERDICTS
from tepsipe.reporting.numbers.format import MINUS, _cell, _printed, number, percent, span
from tepsipe.reporting.recovery import AT_WORK
from tepsipe.reporting.thesis_tables import TableRow

LABELS = {
    "SEM_I": "SEM of I",
    "SEM_B": "SEM of B",
    "SEM_K": "SEM of K",
    "SE_I": "standard error of I",
    "SE_B": "standard error of B",
    "SE_K": "standard error of K",
    "error": "error",
    "VAF_trial": "VAF of the full dataset",
    "VAF_perturbation": "VAF of a perturbation",
    "VAF_cross_validated": "VAF, cross-validated",
    "VAF_theta_perturbation": "VAF of the angle, perturbation",
    "VAF_theta_trial": "VAF of the angle, full dataset",
}


DAGGER = "\N{DAGGER}"


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
        quantities = ", ".join(dict.fromkeys(own.quantity))
        trials = list(dict.fromkeys(own.condition))
        named = ", ".join(trials[:most]) + (f" and {len(trials) - most} more" if len(trials) > most else "")
        parts.append(f"{quantities} of {experiment} {named}")
    return "; ".join(parts)


def flagged_cells(estimates: pd.DataFrame) -> set[tuple[str, str, str, str]]:
    """Pathway, estimator, quantity and condition (no units) of every flagged estimate."""
    own = estimates[estimates["flags"].fillna("") != ""]
    return set(zip(own.pathway, own.estimator, own.quantity, own.condition, strict=True))


def table_data(
    rows: list[TableRow], conditions: list[str], names: list[str], flagged: set | frozenset = frozenset()
) -> list[dict]:
    """Blocks of a thesis table as text.

    Parameters
    ----------
    rows : list of TableRow
        From `lay_out_table` (units in them).
    conditions, names : list of str
        Columns, and their headings.
    flagged : set
        From `flagged_cells` (no units): these values are marked by a dagger.

    Returns
    -------
    list of dict
        One per pathway: ``pathway``, ``estimator``, ``columns``, and ``rows`` with ``label``, ``unit``,
        ``values`` and ``reported``.
    """
    if len(names) != len(conditions):
        raise ValueError("as many names as conditions are needed")
    blocks: dict[tuple, dict] = {}
    for row in rows:
        block = blocks.setdefault(
            (row.pathway, row.estimator),
            {"pathway": row.pathway, "estimator": row.estimator, "columns": names, "rows": []},
        )
        quantity = row.quantity.rpartition("_")[2] if row.quantity.startswith("SE") else row.quantity
        of = (row.pathway, row.estimator, quantity)
        block["rows"].append(
            {
                "label": LABELS.get(row.quantity, row.quantity),
                "unit": unit_symbol(row.unit) if row.unit not in ("1", "as printed") else "",
                "values": [
                    _cell(row.quantity, value) + (f" {DAGGER}" if (*of, c) in flagged else "")
                    for value, c in zip(row.values, conditions, strict=True)
                ],
                "reported": [_printed(value) for value in row.reported],
            }
        )
    return list(blocks.values())


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
            "reproduced": number(None if pd.isna(row.reproduced) else float(row.reproduced), 4),
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


def recovery_data(recovery: pd.DataFrame) -> list[dict]:
    """Estimates and true values (in their units) as text.

    One row for each pathway, estimator, quantity and truth; truths that differ from trial to trial, because
    they hold for the fitted windows, share a row.
    """
    rows = []
    keys = ["experiment", "pathway", "estimator", "quantity", "shared"]
    shared = recovery.truth.where(recovery.truth_of != AT_WORK, math.nan)
    own = recovery.assign(shared=shared)
    for (experiment, pathway, estimator, quantity, _), group in own.groupby(keys, sort=False, dropna=False):
        covered = (group.covered.astype(str).str.lower() == "true").sum()
        errors = group.relative_error.dropna()
        rows.append(
            {
                "experiment": experiment,
                "pathway": pathway,
                "estimator": estimator,
                "quantity": quantity,
                "unit": unit_symbol(group.unit.iloc[0]),
                "truth": span(group.truth),
                "truth_of": group.truth_of.iloc[0],
                "low": _cell(quantity, group.value.min()),
                "high": _cell(quantity, group.value.max()),
                "median_error": percent(100.0 * errors.median()) if len(errors) else number(None),
                "covered": f"{covered} of {len(group)}",
            }
        )
    return rows


def provenance_data(provenance: dict) -> dict:
    """The provenance page as text: facts, packages and checksums (no units)."""
    commit = provenance["commit"] or "not a git checkout"
    if provenance["modified"]:
        commit += ", with uncommitted changes"
    engine = provenance["engine"]
    return {
        "facts": [
            ["Commit", commit],
            ["Python", provenance["python"]],
            *([["Engine of the simulations", f"{engine['name']} {engine['version']}"]] if engine else []),
            ["Configuration, SHA-256", provenance["config_sha256"]],
            ["Seed of the analysis", str(provenance["seed"])],
        ],
        "packages": [[name, text] for name, text in sorted(provenance["packages"].items())],
        "files": [[kind, entry["file"], entry["sha256"]] for kind, entry in provenance["files"].items()],
        "raw": [
            [trial, kind, entry["sha256"]]
            for trial, kinds in provenance["raw_files"].items()
            for kind, entry in kinds.items()
        ],
    }
