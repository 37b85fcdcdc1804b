"""Numbers of the chapter on a person on a moving platform."""

import math

import pandas as pd

from tepsipe.io.result import Result
from tepsipe.reporting.figures.names import unit_symbol
from tepsipe.reporting.numbers.format import by_uncertainty, number, percent


def platform_data(fits: dict[str, Result], estimates: pd.DataFrame) -> dict:
    """Numbers of the chapter as text.

    Parameters
    ----------
    fits : dict of str to Result
        Condition -> fit.
    estimates : DataFrame
        Rows of estimates (units in the column ``unit``).

    Returns
    -------
    dict
        Text, one entry per trial under ``trials``.
    """
    own = estimates[estimates.experiment == "platform"]
    trials = [_trial(name, fit, own[own.condition == name]) for name, fit in fits.items()]
    return {
        "trials": trials,
        "one_perturbation": all(fit.facts["perturbations"] == 1 for fit in fits.values()),
        "identified": sum(trial["identified"] for trial in trials),
        "quantities": sum(trial["quantities"] for trial in trials),
        "rejected_trials": sum(trial["rejected"] for trial in trials),
    }


def _trial(condition: str, fit: Result, rows: pd.DataFrame) -> dict:
    """Text of one trial: models, quantities of the recommended one, VAFs (%)."""
    facts, chosen = fit.facts, fit.facts["chosen"]
    joints = facts["joints"]
    by_estimator = {
        name: group.set_index("quantity") for name, group in rows.groupby("estimator", sort=False)
    }
    quoted = by_estimator[f"iv-{chosen}"]
    values = quoted[~quoted.index.str.startswith(("VAF", "p_value"))]
    threshold = facts["coherence_threshold"]
    coherence = fit.arrays["coherence"]
    significant = (coherence > threshold).mean(axis=0)
    ratio = fit.arrays["mode"]
    return {
        "condition": condition,
        "chosen": chosen,
        "rejected": facts["rejected"],
        "perturbations": facts["perturbations"],
        "quantities": len(values),
        "identified": int(values.value.notna().sum()),
        "rows": [_row(name, row) for name, row in values.iterrows()],
        "refused": [_refused(joint, values.index, facts["models"][chosen]["refusals"]) for joint in joints],
        "mode": [number(float(x), 2) for x in ratio],
        "joints": joints,
        "significant": [percent(100.0 * float(x), 0) for x in significant],
        "models": [_model(name, facts["models"][name], by_estimator, joints) for name in facts["order"]],
    }


def _refused(joint: str, quantities: pd.Index, refusals: list[str]) -> dict:
    """Quantities of one joint's torque that are refused, by reason: what to print of them."""
    reasons = {sentence.split(" ")[0]: sentence.partition(": ")[2] for sentence in refusals}
    own = [name for name in quantities if name in reasons and _torque_of(name) == joint]
    together = [name for name in own if "does not separate" in reasons[name]]
    return {
        "joint": joint,
        "together": [_text(name) for name in together],
        "others": [{**_text(name), "reason": reasons[name]} for name in own if name not in together],
    }


def _torque_of(name: str) -> str:
    """Joint whose torque a quantity (any unit) is about."""
    return name.rsplit("_", 1)[1] if name.startswith(("delay", "K_mode")) else name.rsplit("_", 2)[1]


def _text(name: str) -> dict:
    """Kind of a quantity (any unit) and its joints."""
    if name.startswith(("delay", "K_mode")):
        kind, _, joint = name.rpartition("_")
        return {"kind": kind, "joints": joint}
    kind, torque, angle = name.rsplit("_", 2)
    return {"kind": kind, "joints": f"{torque} per {angle}"}


def _row(name: str, row: pd.Series) -> dict:
    """A quantity with its interval, or without a number."""
    value, interval = (
        ("not identified", "")
        if math.isnan(row.value)
        else by_uncertainty(row.value, row.ci_low, row.ci_high)
    )
    return {**_text(name), "value": value, "interval": interval, "unit": unit_symbol(row.unit)}


def _model(name: str, facts: dict, by_estimator: dict[str, pd.DataFrame], joints: list[str]) -> dict:
    """One model: test, share of quantities that are identified, VAFs of both joints (%)."""
    instrument, direct = by_estimator[f"iv-{name}"], by_estimator[f"direct-{name}"]
    values = instrument[~instrument.index.str.startswith(("VAF", "p_value"))]

    def vafs(rows: pd.DataFrame, kind: str) -> str:
        return ", ".join(percent(rows.value[f"{kind}_{joint}"]) for joint in joints)

    return {
        "name": name,
        "rejected": facts["rejected"],
        "p_values": ", ".join(number(p, 2) for p in facts["p_values"]),
        "identified": f"{int(values.value.notna().sum())} of {len(values)}",
        "held_out": vafs(instrument, "VAF_held_out"),
        "driven": vafs(instrument, "VAF_driven_held_out"),
        "direct": vafs(direct, "VAF_held_out"),
    }
