"""Numbers of the chapter on the position-controlled manipulator."""

import math

import pandas as pd

from tepsipe.experiments.position_manipulator import ESTIMATOR, MUSCLE_ESTIMATOR, REFLEX_ESTIMATOR
from tepsipe.io.result import Result
from tepsipe.reporting.figures.names import unit_symbol
from tepsipe.reporting.numbers.format import number, percent, span

MODELS = {
    ESTIMATOR: "Inertia, damping and stiffness only",
    REFLEX_ESTIMATOR: "Parallel-cascade model",
    MUSCLE_ESTIMATOR: "Parallel-cascade model with a second-order muscle",
}
# quantities that a table of the report omits, because they are redundant there
LEFT_OUT = {
    REFLEX_ESTIMATOR: ("VAF_held_out_as_printed",),
    MUSCLE_ESTIMATOR: ("VAF_held_out_as_printed", "reflex_delay"),
}
LABELS = {
    "K_growth": "angle-dependent stiffness",
    "reflex_gain": "reflex gain",
    "reflex_delay": "reflex delay",
    "reflex_share": "fraction of the torque variance from the reflex",
    "reflex_frequency": "natural frequency of the muscle",
    "reflex_damping": "damping ratio of the muscle",
    "VAF_training": "VAF of the fitted part",
    "VAF_cross_validated": "VAF of the fitted part, cross-validated",
    "VAF_held_out": "VAF of the held-out part",
    "VAF_held_out_any_offset": "VAF of the held-out part, free offset",
    "VAF_held_out_as_printed": "VAF of the held-out part, uncentred",
}


def manipulator_data(fits: dict[str, Result], estimates: pd.DataFrame) -> dict:
    """Numbers of the position-controlled manipulator's chapter as text.

    Parameters
    ----------
    fits : dict of str to Result
        Condition -> fit.
    estimates : DataFrame
        Rows of estimates (units in the column ``unit``).

    Returns
    -------
    dict
        Text.
    """
    own = estimates[estimates.experiment == "position_manipulator"]

    def values(estimator: str, quantity: str) -> pd.Series:
        return own[(own.estimator == estimator) & (own.quantity == quantity)].value

    return {
        "columns": list(fits),
        "models": [
            {"name": name, "rows": _rows(own[own.estimator == estimator], list(fits), estimator)}
            for estimator, name in MODELS.items()
            if (own.estimator == estimator).any()
        ],
        "held_out": span(values(ESTIMATOR, "VAF_held_out")),
        "held_out_reflex": span(values(REFLEX_ESTIMATOR, "VAF_held_out")),
        "reflex_raises": _raises(values),
        "predicts": bool((values(ESTIMATOR, "VAF_held_out") > 0.0).all()),
        "any_offset": span(values(ESTIMATOR, "VAF_held_out_any_offset")),
        "any_offset_reflex": span(values(REFLEX_ESTIMATOR, "VAF_held_out_any_offset")),
        "stiffness": span(values(ESTIMATOR, "K")),
        "stiffness_intrinsic": span(values(REFLEX_ESTIMATOR, "K")),
        "training": span([fit.facts["training_s"] for fit in fits.values()]),
        "reflexes": [_reflex(condition, fit, own) for condition, fit in fits.items()],
    }


def _raises(values) -> bool:
    """Whether the reflex pathway raises the held-out VAF (%) in every trial."""
    plain, reflex = (values(name, "VAF_held_out").to_numpy() for name in (ESTIMATOR, REFLEX_ESTIMATOR))
    return bool(plain.size == reflex.size > 0 and (reflex > plain).all())


def _rows(rows: pd.DataFrame, conditions: list[str], estimator: str) -> list[dict]:
    """One row of text per quantity, in the order of the estimates; a dash where a trial has none."""
    found = []
    for quantity, group in rows.groupby("quantity", sort=False):
        if quantity in LEFT_OUT.get(estimator, ()):
            continue
        by = group.set_index("condition")
        found.append(
            {
                "label": LABELS.get(quantity, quantity),
                "unit": "" if by.unit.iloc[0] == "1" else unit_symbol(by.unit.iloc[0]),
                "values": [_cell(quantity, by.loc[c]) if c in by.index else number(None) for c in conditions],
            }
        )
    last = [row for row in found if row["label"].startswith("VAF")]
    return [row for row in found if row not in last] + last


def _cell(quantity: str, row: pd.Series) -> str:
    """A value with its standard error (unit of the row)."""
    if quantity.startswith("VAF"):
        return percent(row.value)
    if math.isnan(row.standard_error):
        return number(row.value, 2 if quantity.startswith("reflex") else 3)
    return f"{number(row.value)} ± {number(row.standard_error)}"


def _delay_sentence(selected_s: float, low_s: float, high_s: float) -> str:
    """The selected delay, and those that the trial does not separate from it (s)."""
    text = f"The selected delay is {number(1e3 * selected_s, 2)} ms"
    if low_s == high_s:
        return f"{text}; the trial separates it from all others that were tried."
    return f"{text}; the trial does not separate delays of {span([1e3 * low_s, 1e3 * high_s], 2)} ms."


def _reflex(condition: str, fit: Result, own: pd.DataFrame) -> dict:
    """Structure selected by cross-validation for one trial, and the reflex gain with its interval."""
    rows = own[(own.estimator == REFLEX_ESTIMATOR) & (own.condition == condition)].set_index("quantity")
    facts = fit.facts["reflex"]
    gain = rows.loc["reflex_gain"]
    return {
        "condition": condition,
        "there": facts["direction"] != 0,
        "rising": facts["direction"] > 0,
        "stiffening": facts["stiffening"],
        "growth": number(rows.value.get("K_growth")),
        "gain": number(gain.value),
        "gain_low": number(gain.ci_low),
        "gain_high": number(gain.ci_high),
        # a gain whose interval holds 0 is not seen
        "clear": bool(gain.ci_low > 0.0 or gain.ci_high < 0.0),
        "delay_sentence": _delay_sentence(facts["delay_s"], *facts["delay_range_s"]),
        "share": percent(rows.value["reflex_share"]),
    }
