"""Coefficients and comparison of the models of a joint in the position-controlled manipulator, as text."""

import math

import pandas as pd

from tepsipe.experiments.position_manipulator.analysis import (
    ESTIMATOR,
    MUSCLE_ESTIMATOR,
    REFLEX_ESTIMATOR,
    TERMS,
)
from tepsipe.io.result import Result
from tepsipe.reporting.figures.names import unit_symbol
from tepsipe.reporting.numbers.format import by_uncertainty, number, percent, span_of_decimals

MODELS = {
    ESTIMATOR: "Inertia, damping and stiffness only",
    REFLEX_ESTIMATOR: "Parallel-cascade model",
    MUSCLE_ESTIMATOR: "Its variant with a second-order muscle",
}
LABELS = {
    "I": "inertia $I$",
    "B": "damping $B$",
    "K": "stiffness $K$",
    "K_working": "stiffness at the recorded amplitude",
    "K_short_range": "stiffness of the smallest movements",
    "yield_angle": "yield angle",
    "K_relaxing": "stiffness that relaxes",
    "relaxation_time": "time of its relaxation",
    "K_growth": "angle-dependent stiffness $2 c$",
    "reflex_gain": "reflex gain $G$",
    "reflex_gain_slope": "change of $G$ per angle",
    "unloading_gain": "gain of unloading",
    "reflex_delay": "reflex delay $delta$",
    "reflex_threshold": "velocity threshold of the reflex",
    "reflex_peak": "peak of the response after the stretch",
    "reflex_duration": "duration of the response",
    "reflex_share": "torque variance from the reflex",
    "reflex_frequency": "natural frequency of the muscle",
    "reflex_damping": "damping ratio of the muscle",
    "slow_torque_sd": "slow torque, standard deviation",
}
# the same as in the block before
LEFT_OUT = {MUSCLE_ESTIMATOR: ("reflex_delay",)}
# names of the terms beyond the linear intrinsic pathway
TERM_NAMES = {
    "direction": "reflex",
    "stops": "short-range stiffness",
    "stiffening": "angle-dependent stiffness",
    "gain_slope": "angle-dependent reflex gain",
    "unloading": "response to unloading",
    "relaxing": "relaxation",
}
# models of the comparison, of those that were fitted
CHAIN = (
    (),
    ("stops",),
    ("stiffening",),
    ("direction",),
    ("direction", "stops"),
    ("direction", "stops", "stiffening"),
    ("direction", "stops", "gain_slope"),
    TERMS,
)
STAR, ASSUMED = "*", "assumed"


def coefficients_data(own: pd.DataFrame, conditions: list[str]) -> list[dict]:
    """Blocks of the table of the coefficients: name of the model, one row for each quantity (its unit)."""
    return [
        {
            "name": name,
            "rows": _rows(own[own.estimator == estimator], conditions, LEFT_OUT.get(estimator, ())),
        }
        for estimator, name in MODELS.items()
        if (own.estimator == estimator).any()
    ]


def _rows(rows: pd.DataFrame, conditions: list[str], left_out: tuple[str, ...]) -> list[dict]:
    """One row of text per coefficient, in the order of the estimates; a dash where a trial has none."""
    quantities = list(dict.fromkeys(rows.quantity))
    ends = {f"{q}_{end}" for q in quantities for end in ("low", "high")}
    found = []
    for quantity in quantities:
        if quantity.startswith("VAF") or quantity in ends or quantity in left_out:
            continue
        by = rows[rows.quantity == quantity].set_index("condition")
        cells = []
        for condition in conditions:
            if condition not in by.index:
                cells.append((number(None), ""))
                continue
            value, interval = cell(by.loc[condition])
            cells.append((value, interval or _alike(rows, quantity, condition)))
        found.append(
            {
                "label": LABELS.get(quantity, quantity.replace("_", " ")),
                "unit": "" if by.unit.iloc[0] == "1" else unit_symbol(by.unit.iloc[0]),
                "values": [value for value, _ in cells],
                "intervals": [interval for _, interval in cells],
            }
        )
    return found


def _alike(rows: pd.DataFrame, quantity: str, condition: str) -> str:
    """Range of a choice that predicts the fitted part alike (unit of the quantity)."""
    own = rows[rows.condition == condition].set_index("quantity")
    if f"{quantity}_low" not in own.index:
        return ""
    low, high = (float(own.value[f"{quantity}_{end}"]) for end in ("low", "high"))
    assumed = "assumed; " if ASSUMED in flags_of(own.loc[quantity]) else ""
    between = number(low, 2) if low == high else f"{number(low, 2)} to {number(high, 2)}"
    return f"{assumed}best {between}"


def cell(row: pd.Series) -> tuple[str, str]:
    """A value with its 95 % interval (unit of the row), and a star if it failed a check."""
    value, interval = by_uncertainty(float(row.value), _known(row.ci_low), _known(row.ci_high))
    if not interval:
        value = number(float(row.value), 2)
    return value + STAR * bool(flags_of(row) - {ASSUMED}), interval


def _known(value: float | None) -> float | None:
    return None if value is None or math.isnan(value) else float(value)


def flags_of(row: pd.Series) -> set[str]:
    """Names of the checks that an estimate failed (no unit)."""
    flags = row.get("flags", "")
    return set(filter(None, flags.split(";"))) if isinstance(flags, str) else set()


def quoted(own: pd.DataFrame, estimator: str, quantity: str, conditions: list[str]) -> dict[str, str]:
    """Value with its interval of every trial (unit of the quantity)."""
    rows = own[(own.estimator == estimator) & (own.quantity == quantity)].set_index("condition")
    found = {}
    for condition in conditions:
        if condition in rows.index:
            value, interval = cell(rows.loc[condition])
            found[condition] = f"{value} ({interval})" if interval else value
    return found


def comparison_data(fits: dict[str, Result], own: pd.DataFrame) -> list[dict]:
    """Rows of the comparison: label, number of coefficients, cross-validated and held-out VAFs (%)."""
    conditions = list(fits)
    rows = [_row_of_estimator(own, ESTIMATOR, "inertia, damping, stiffness and offset", conditions, "4")]
    for terms in CHAIN:
        found = [_score(fit, terms) for fit in fits.values()]
        if any(found):
            rows.append(
                {
                    "label": _named(terms),
                    "coefficients": _count([score[0] for score in found if score]),
                    "crossed": [percent(score[1]) if score else number(None) for score in found],
                    "held_out": [percent(score[2]) if score else number(None) for score in found],
                }
            )
    chosen = [_score(fit, selected_terms(fit)) for fit in fits.values()]
    count = _count([score[0] for score in chosen if score])
    rows.append(_row_of_estimator(own, REFLEX_ESTIMATOR, "*selected terms*", conditions, count))
    if (own.estimator == MUSCLE_ESTIMATOR).any():
        rows.append(_row_of_estimator(own, MUSCLE_ESTIMATOR, "the same, second-order muscle", conditions, ""))
    return rows


def selected_terms(fit: Result) -> tuple[str, ...]:
    """Names of the terms that cross-validation selected for a trial (no unit)."""
    facts = fit.facts["reflex"]
    present = {"direction": facts["direction"] != 0, "stops": facts["short_range"]}
    return tuple(name for name in TERMS if present.get(name, facts.get(name, False)))


def _count(counts: list) -> str:
    known = [count for count in counts if count]
    return span_of_decimals(known, 0) if known else ""


def _named(terms: tuple[str, ...]) -> str:
    """A model in words."""
    if not terms:
        return "linear intrinsic pathway"
    if terms == TERMS:
        return "with all terms"
    return "with " + ", ".join(TERM_NAMES[name] for name in terms)


def _score(fit: Result, terms: tuple[str, ...]) -> tuple[float, float, float] | None:
    """Number of coefficients, cross-validated and held-out VAF (%) of a model of a trial, if fitted."""
    wanted = [float(name in terms) for name in TERMS]
    for k, present in enumerate(fit.arrays["reflex/models_terms"]):
        if list(present) == wanted:
            names = ("coefficients", "vaf_cross_validated", "vaf_held_out")
            return tuple(float(fit.arrays[f"reflex/models_{name}"][k]) for name in names)
    return None


def _row_of_estimator(own, estimator: str, label: str, conditions: list[str], coefficients: str) -> dict:
    """VAFs of the estimates."""

    def texts(quantity: str) -> list[str]:
        rows = own[(own.estimator == estimator) & (own.quantity == quantity)].set_index("condition").value
        return [percent(rows[c]) if c in rows.index else number(None) for c in conditions]

    return {
        "label": label,
        "coefficients": coefficients,
        "crossed": texts("VAF_cross_validated"),
        "held_out": texts("VAF_held_out"),
    }
