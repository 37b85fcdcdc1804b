"""Numbers of the chapter on the position-controlled manipulator."""

import math

import pandas as pd

from tepsipe.experiments.position_manipulator.analysis import ESTIMATOR, REFLEX_ESTIMATOR
from tepsipe.io.result import Result
from tepsipe.reporting.numbers.format import number, percent, span, span_of_decimals
from tepsipe.reporting.numbers.manipulator_models import (
    ASSUMED,
    TERM_NAMES,
    cell,
    coefficients_data,
    comparison_data,
    flags_of,
    quoted,
    selected_terms,
)
from tepsipe.reporting.numbers.manipulator_recordings import (
    SHOWN_TRIALS,
    parts_data,
    recordings_data,
    residuals_data,
    validity_data,
)
from tepsipe.reporting.numbers.manipulator_sentences import abstract_data, each, joined, trials_named

# trials beside each other in a table
COLUMNS = 4
# a response still active so long after the stretch holds more than a short-latency reflex, and one that
# begins earlier than that is no reflex (s)
LATE_S, SHORTEST_S = 0.15, 0.03


def manipulator_data(fits: dict[str, Result], estimates: pd.DataFrame, joint: dict | None = None) -> dict:
    """Numbers of the position-controlled manipulator's chapter as text.

    Parameters
    ----------
    fits : dict of str to Result
        Condition -> fit.
    estimates : DataFrame
        Rows of estimates (units in the column ``unit``).
    joint : dict, optional
        ``name`` of the joint, and the movements ``positive`` and ``negative``, each a text or None.

    Returns
    -------
    dict
        Text.
    """
    own = estimates[estimates.experiment == "position_manipulator"]
    conditions = list(fits)

    def values(estimator: str, quantity: str) -> pd.Series:
        found = own[(own.estimator == estimator) & (own.quantity == quantity)]
        return found.set_index("condition").value.reindex(conditions)

    def told(estimator: str, quantity: str) -> str:
        return each(quoted(own, estimator, quantity, conditions), values(estimator, quantity))

    def vafs(estimator: str, quantity: str) -> str:
        found = values(estimator, quantity)
        return each({c: percent(v) for c, v in found.items()}, found, unit="%")

    alone, both = (values(name, "VAF_held_out") for name in (ESTIMATOR, REFLEX_ESTIMATOR))
    data = {
        "joint": _joint(joint),
        "columns": conditions,
        "groups": [conditions[k : k + COLUMNS] for k in range(0, len(conditions), COLUMNS)],
        "one": len(conditions) == 1,
        "models": coefficients_data(own, conditions),
        "starred": any(flags_of(row) - {ASSUMED} for _, row in own.iterrows()),
        "comparison": comparison_data(fits, own),
        "reflex_raises": _raises(values),
        "predicts": bool((alone > 0.0).all()),
        "half_unpredicted": trials_named(list(both[both < 50.0].index), conditions),
        "any_offset": span_of_decimals(values(ESTIMATOR, "VAF_held_out_any_offset"), 1),
        "any_offset_reflex": span_of_decimals(values(REFLEX_ESTIMATOR, "VAF_held_out_any_offset"), 1),
        "stiffness": told(ESTIMATOR, "K"),
        "stiffness_beyond": told(REFLEX_ESTIMATOR, "K"),
        "stiffness_working": told(REFLEX_ESTIMATOR, "K_working"),
        "stiffness_small": told(REFLEX_ESTIMATOR, "K_short_range"),
        "vaf_each": vafs(REFLEX_ESTIMATOR, "VAF_held_out"),
        "vaf_alone_each": vafs(ESTIMATOR, "VAF_held_out"),
        "vaf_slow_each": vafs(REFLEX_ESTIMATOR, "VAF_held_out_with_slow_torque"),
        "slow_raises": bool((values(REFLEX_ESTIMATOR, "VAF_held_out_with_slow_torque") > both).all()),
        "slow_horizon": number(1e3 * next(iter(fits.values())).facts["reflex"]["slow_horizon_s"], 2),
        "training": span([fit.facts["training_s"] for fit in fits.values()]),
        "reflexes": [_reflex(condition, fit, own) for condition, fit in fits.items()],
        "recordings": recordings_data(fits),
        "validity": validity_data(fits),
        "parts": parts_data(fits),
        "residuals": residuals_data(fits),
    }
    short = [c for c, fit in fits.items() if fit.facts["reflex"]["short_range"]]
    groups: dict[str, list[str]] = {}
    for r in data["reflexes"]:
        groups.setdefault(r["terms"] or "none", []).append(r["condition"])
    data |= {
        "terms": "; ".join(f"{terms} in {trials_named(c, conditions)}" for terms, c in groups.items()),
        "drawn": len(conditions) > SHOWN_TRIALS,
        "with_reflex": trials_named([r["condition"] for r in data["reflexes"] if r["there"]], conditions),
        "short_range": bool(short),
        "with_short_range": trials_named(short, conditions),
        "with_relaxation": trials_named(
            [c for c, fit in fits.items() if fit.facts["reflex"].get("relaxing", False)], conditions
        ),
    }
    return data | {"abstract": abstract_data(data)}


def _joint(joint: dict | None) -> dict:
    """Names of the joint and of the movements of its angle, with words where there are none."""
    given = joint or {}
    name, positive, negative = (given.get(key) or "" for key in ("name", "positive", "negative"))
    return {
        "name": name or "joint",
        "of": f"human {name}" if name else "joint",
        "positive": positive,
        "negative": negative,
    }


def _raises(values) -> bool:
    """Whether the reflex pathway raises the held-out VAF (%) in every trial."""
    plain, reflex = (values(name, "VAF_held_out").to_numpy() for name in (ESTIMATOR, REFLEX_ESTIMATOR))
    return bool(plain.size == reflex.size > 0 and (reflex > plain).all())


def _reflex(condition: str, fit: Result, own: pd.DataFrame) -> dict:
    """Structure selected by cross-validation for one trial, and the reflex gain with its interval."""
    rows = own[(own.estimator == REFLEX_ESTIMATOR) & (own.condition == condition)].set_index("quantity")
    facts = fit.facts["reflex"]
    gain, gain_interval = cell(rows.loc["reflex_gain"])
    delay, (low, high) = facts["delay_s"], facts["delay_range_s"]
    lasting = facts["delay_s"] + facts["duration_s"] if facts["direction"] else 0.0
    return {
        "condition": condition,
        "there": facts["direction"] != 0,
        "rising": facts["direction"] > 0,
        "terms": joined([TERM_NAMES[name] for name in selected_terms(fit)]),
        "gain": gain,
        "gain_interval": gain_interval,
        # a gain whose interval holds 0 is not seen
        "clear": bool(rows.ci_low["reflex_gain"] > 0.0 or rows.ci_high["reflex_gain"] < 0.0),
        "delay": number(1e3 * delay, 2),
        "delays": f"{span([1e3 * low, 1e3 * high], 2)} ms",
        "delay_assumed": "reflex_delay" in facts["assumed"],
        "delay_within": bool(low <= delay <= high),
        # what responds so early is no reflex
        "too_early": bool(high < SHORTEST_S),
        "share": percent(rows.value["reflex_share"]),
        "lasting": number(1e3 * lasting, 2),
        "lasting_ms": 1e3 * lasting if math.isfinite(lasting) else 0.0,
        "late": bool(lasting > LATE_S),
    }
