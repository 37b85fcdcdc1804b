"""Numbers of the section on impedance that changes within a trial."""

import statistics

import numpy as np

from tepsipe.experiments.position_manipulator.time_varying import VaryingRow
from tepsipe.reporting.numbers.format import by_uncertainty, number, percent, span


def time_varying_data(rows: list[VaryingRow], conditions: list[str]) -> dict:
    """Numbers of the section as text.

    Parameters
    ----------
    rows : list of VaryingRow
        Rows of all trials (units in the rows).
    conditions : list of str
        All trials, with or without rows.

    Returns
    -------
    dict
        Text, and truth values on which the sentences depend.
    """
    by = {condition: [row for row in rows if row.condition == condition] for condition in conditions}
    return {
        "short": [condition for condition, own in by.items() if not own],
        "kinds": list(dict.fromkeys(row.over for row in rows)),
        "trials": [_trial(condition, own) for condition, own in by.items() if own],
    }


def _trial(condition: str, rows: list[VaryingRow]) -> dict:
    """One trial: lowest and highest K with their intervals, and whether K changes."""
    stiffness = [row for row in rows if row.quantity == "K"]
    lowest, highest = (choose(stiffness, key=lambda row: row.value) for choose in (min, max))
    ends = []
    for row in (lowest, highest):
        value, interval = by_uncertainty(row.value, row.ci_low, row.ci_high)
        ends.append({"value": value, "interval": interval, "at": number(row.at)})
    half = statistics.median(50.0 * (row.ci_high - row.ci_low) / abs(row.value) for row in stiffness)
    return {
        "condition": condition,
        "over": stiffness[0].over,
        "places": len(stiffness),
        "pieces": span([row.pieces for row in stiffness]),
        "lowest": ends[0],
        "highest": ends[1],
        "ratio": number(highest.value / lowest.value, 2) if lowest.value > 0.0 else number(None),
        "changes": _changes(stiffness),
        "half_width": percent(half),
        "torques": span([row.torque_Nm for row in stiffness]),
        "vaf": span([row.vaf_percent for row in stiffness]),
    }


def _changes(rows: list[VaryingRow]) -> bool:
    """Whether a value is further from the weighted mean than chance, at 5 % over all places (Bonferroni)."""
    value, error = (np.array([getattr(row, name) for row in rows]) for name in ("value", "standard_error"))
    mean = np.average(value, weights=error**-2.0)
    limit = statistics.NormalDist().inv_cdf(1.0 - 0.025 / value.size)
    return bool((np.abs(value - mean) > limit * error).any())
