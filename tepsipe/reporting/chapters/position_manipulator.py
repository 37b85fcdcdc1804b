"""Chapter on the position-controlled manipulator: numbers of its fits, and conditions of its sentences."""

import statistics

import numpy as np
import pandas as pd

from tepsipe.reporting.operating_points import LITERATURE_SLOPE, LITERATURE_TORQUE_NM
from tepsipe.reporting.run import Run

# probability of a difference by chance (-)
LEVEL = 0.05


def numbers(run: Run) -> dict:
    """Slopes of the literature (1/rad), their torque (N·m), and trials in which K changes."""
    return {
        "literature_slope": LITERATURE_SLOPE,
        "literature_torque_Nm": LITERATURE_TORQUE_NM,
        "changing": [
            condition
            for condition, rows in run.rows("time_varying", quantity="K").groupby("condition", sort=False)
            if _changes(rows)
        ],
    }


def _changes(rows: pd.DataFrame) -> bool:
    """A value is further from the weighted mean than chance, at 5 % over all places (Bonferroni)."""
    value, error = (rows[name].to_numpy() for name in ("value", "standard_error"))
    mean = np.average(value, weights=error**-2.0)
    limit = statistics.NormalDist().inv_cdf(1.0 - 0.5 * LEVEL / value.size)
    return bool((np.abs(value - mean) > limit * error).any())


# ---- conditions of sentences


def participants_named(run: Run) -> bool:
    """The trial sheet names the participant of a trial with an operating point."""
    points = run.tables.get("operating_points")
    return points is not None and bool(points.participant.notna().any())


PREDICATES = (participants_named,)
