"""Numbers of the chapter on the position-controlled manipulator."""

import math

import pandas as pd

from tepsipe.experiments.position_manipulator import ESTIMATOR, MUSCLE_ESTIMATOR, REFLEX_ESTIMATOR
from tepsipe.io.result import Result
from tepsipe.reporting.figures.names import unit_symbol
from tepsipe.reporting.numbers.format import by_uncertainty, number, percent, span, span_of_decimals
from tepsipe.reporting.numbers.manipulator_recordings import parts_data, recordings_data, residuals_data
from tepsipe.reporting.numbers.manipulator_sentences import abstract_data, each, trials_named

MODELS = {
    ESTIMATOR: "Inertia, damping and stiffness only",
    REFLEX_ESTIMATOR: "Parallel-cascade model",
    MUSCLE_ESTIMATOR: "Parallel-cascade model with a second-order muscle",
}
LABELS = {
    "I": "inertia $I$",
    "B": "damping $B$",
    "K": "stiffness $K$",
    "K_growth": "angle-dependent stiffness $2 c$",
    "reflex_gain": "reflex gain $G$",
    "reflex_delay": "reflex delay $delta$, assumed",
    "reflex_share": "torque variance from the reflex",
    "reflex_frequency": "natural frequency of the muscle",
    "reflex_damping": "damping ratio of the muscle",
}
# trials beside each other in a table
COLUMNS = 4
# a kernel that is still active so long after the stretch holds more than a short-latency reflex (s)
LATE_S = 0.15
STAR = "*"


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

    alone, both = (values(name, "VAF_held_out") for name in (ESTIMATOR, REFLEX_ESTIMATOR))
    data = {
        "joint": _joint(joint),
        "columns": conditions,
        "groups": [conditions[k : k + COLUMNS] for k in range(0, len(conditions), COLUMNS)],
        "one": len(conditions) == 1,
        "models": [
            {"name": name, "rows": _rows(own[own.estimator == estimator], conditions)}
            for estimator, name in MODELS.items()
            if (own.estimator == estimator).any()
        ],
        "starred": _starred(own),
        "comparison": _comparison(own, conditions),
        "held_out": span_of_decimals(alone, 1),
        "held_out_reflex": span_of_decimals(both, 1),
        "reflex_raises": _raises(values),
        "predicts": bool((alone > 0.0).all()),
        "any_offset": span_of_decimals(values(ESTIMATOR, "VAF_held_out_any_offset"), 1),
        "any_offset_reflex": span_of_decimals(values(REFLEX_ESTIMATOR, "VAF_held_out_any_offset"), 1),
        "stiffness": each(_quoted(own, ESTIMATOR, "K", conditions), values(ESTIMATOR, "K")),
        "stiffness_intrinsic": each(
            _quoted(own, REFLEX_ESTIMATOR, "K", conditions), values(REFLEX_ESTIMATOR, "K")
        ),
        "vaf_each": each({c: percent(v) for c, v in both.items()}, both, unit="%"),
        "vaf_alone_each": each({c: percent(v) for c, v in alone.items()}, alone, unit="%"),
        "training": span([fit.facts["training_s"] for fit in fits.values()]),
        "reflexes": [_reflex(condition, fit, own) for condition, fit in fits.items()],
        "recordings": recordings_data(fits),
        "parts": parts_data(fits),
        "residuals": residuals_data(fits),
    }
    data["with_reflex"] = trials_named([r["condition"] for r in data["reflexes"] if r["there"]], conditions)
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


def _rows(rows: pd.DataFrame, conditions: list[str]) -> list[dict]:
    """One row of text per coefficient, in the order of the estimates; a dash where a trial has none."""
    found = []
    for quantity, group in rows.groupby("quantity", sort=False):
        if quantity.startswith("VAF"):
            continue
        by = group.set_index("condition")
        cells = [_cell(by.loc[c]) if c in by.index else (number(None), "") for c in conditions]
        found.append(
            {
                "label": LABELS.get(quantity, quantity.replace("_", " ")),
                "unit": "" if by.unit.iloc[0] == "1" else unit_symbol(by.unit.iloc[0]),
                "values": [value for value, _ in cells],
                "intervals": [interval for _, interval in cells],
            }
        )
    return found


def _cell(row: pd.Series) -> tuple[str, str]:
    """A value with its 95 % interval (unit of the row), and a star if it is flagged."""
    value, interval = by_uncertainty(float(row.value), _known(row.ci_low), _known(row.ci_high))
    if not interval:
        value = number(float(row.value), 2)
    return value + STAR * _is_flagged(row), interval


def _known(value: float) -> float | None:
    return None if value is None or math.isnan(value) else float(value)


def _is_flagged(row: pd.Series) -> bool:
    flags = row.get("flags", "")
    return isinstance(flags, str) and flags != ""


def _starred(own: pd.DataFrame) -> bool:
    """Whether any coefficient has a flag (values in their units)."""
    return any(_is_flagged(row) for _, row in own.iterrows())


def _quoted(own: pd.DataFrame, estimator: str, quantity: str, conditions: list[str]) -> dict[str, str]:
    """Value with its interval of every trial (unit of the quantity)."""
    rows = own[(own.estimator == estimator) & (own.quantity == quantity)].set_index("condition")
    found = {}
    for condition in conditions:
        if condition in rows.index:
            value, interval = _cell(rows.loc[condition])
            found[condition] = f"{value} (95 % interval {interval})" if interval else value
    return found


def _comparison(own: pd.DataFrame, conditions: list[str]) -> list[dict]:
    """VAFs (%) of the models: of the fitted part, cross-validated, held out, held out with a free offset."""
    rows = []
    for estimator, name in MODELS.items():
        group = own[own.estimator == estimator]
        if group.empty:
            continue
        table = group.pivot_table(index="quantity", columns="condition", values="value", sort=False)

        def row(quantity: str, table=table) -> list[str]:
            known = quantity in table.index
            return [
                percent(table.loc[quantity, c]) if known and c in table.columns else number(None)
                for c in conditions
            ]

        rows.append(
            {
                "name": name,
                "training": row("VAF_training"),
                "crossed": row("VAF_cross_validated"),
                "held_out": row("VAF_held_out"),
                "any_offset": row("VAF_held_out_any_offset"),
            }
        )
    return rows


def _reflex(condition: str, fit: Result, own: pd.DataFrame) -> dict:
    """Structure selected by cross-validation for one trial, and the reflex gain with its interval."""
    rows = own[(own.estimator == REFLEX_ESTIMATOR) & (own.condition == condition)].set_index("quantity")
    facts = fit.facts["reflex"]
    gain, gain_interval = _cell(rows.loc["reflex_gain"])
    growth, growth_interval = _cell(rows.loc["K_growth"]) if "K_growth" in rows.index else ("", "")
    delays = [1e3 * delay for delay in facts["delay_range_s"]]
    lasting = _lasting_s(fit)
    return {
        "condition": condition,
        "there": facts["direction"] != 0,
        "rising": facts["direction"] > 0,
        "stiffening": facts["stiffening"],
        "growth": growth,
        "growth_interval": growth_interval,
        "gain": gain,
        "gain_interval": gain_interval,
        # a gain whose interval holds 0 is not seen
        "clear": bool(rows.ci_low["reflex_gain"] > 0.0 or rows.ci_high["reflex_gain"] < 0.0),
        "delay": number(1e3 * facts["delay_s"], 2),
        "delays": span(delays, 2),
        "delay_open": delays[0] < delays[1],
        "share": percent(rows.value["reflex_share"]),
        "lasting": number(1e3 * lasting, 2),
        "lasting_ms": 1e3 * lasting,
        "late": bool(lasting > LATE_S),
    }


def _lasting_s(fit: Result) -> float:
    """Time after the stretch (s) by which 95 % of the area of the reflex response has passed; 0 without."""
    response = fit.arrays["reflex/response"]
    if response.size == 0:
        return 0.0
    area = abs(response).cumsum()
    return float(fit.arrays["reflex/time"][(area >= 0.95 * area[-1]).argmax()]) if area[-1] > 0.0 else 0.0
