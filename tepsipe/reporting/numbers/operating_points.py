"""Numbers of the section on operating points."""

import pandas as pd

from tepsipe.reporting.figures.names import unit_symbol
from tepsipe.reporting.numbers.format import MINUS, by_uncertainty, number, span, span_of_decimals
from tepsipe.reporting.operating_points import LITERATURE_SLOPE, LITERATURE_TORQUE_NM, STIFFNESS

COLUMNS = (STIFFNESS, "B", "reflex_gain", "damping_ratio")


def operating_points_data(points: pd.DataFrame, relations: pd.DataFrame) -> dict:
    """Numbers of the section as text.

    Parameters
    ----------
    points, relations : DataFrame
        Tables of operating points and of lines of K against torque (units in their columns).

    Returns
    -------
    dict
        Text, and truth values on which the sentences depend.
    """
    trials = points.drop_duplicates("condition")
    ratios = points[points.quantity == "damping_ratio"].value
    return {
        "trials": len(trials),
        "named": bool(trials.participant.notna().any()),
        "torques": span(trials.torque_Nm),
        "angles": span_of_decimals(trials.angle_rad, 3),
        "stiffness": span(points[points.quantity == STIFFNESS].value) if len(points) else number(None),
        "damping_ratios": span(ratios, 2) if len(ratios) else None,
        "literature": span(LITERATURE_SLOPE, 2),
        "literature_torque": number(LITERATURE_TORQUE_NM),
        "literature_stiffness": span([LITERATURE_TORQUE_NM * slope for slope in LITERATURE_SLOPE]),
        "rows": [_row(points[points.condition == condition]) for condition in trials.condition],
        "lines": [_line(line) for line in relations.itertuples()],
    }


def _row(own: pd.DataFrame) -> dict:
    """One trial: operating point and values with standard errors."""
    first, by = own.iloc[0], own.set_index("quantity")
    cells = []
    for quantity in COLUMNS:
        if quantity not in by.index:
            cells.append(number(None))
            continue
        row = by.loc[quantity]
        error = "" if pd.isna(row.standard_error) else f" ± {number(row.standard_error, 2)}"
        cells.append(number(row.value) + error)
    return {
        "participant": "" if pd.isna(first.participant) else first.participant,
        "condition": first.condition,
        "angle": f"{first.angle_rad:.3f}".replace("-", MINUS)
        + ("*" if first.angle_from == "trial sheet" else ""),
        "torque": number(first.torque_Nm) + ("*" if first.torque_from == "trial sheet" else ""),
        "cells": cells,
    }


def _line(line) -> dict:
    """One line of K against torque, and where its slope lies by the literature's."""
    slope, interval = by_uncertainty(line.slope_per_rad, line.slope_low, line.slope_high)
    rest, rest_interval = by_uncertainty(line.at_rest_Nm_per_rad, line.at_rest_low, line.at_rest_high)
    low, high = LITERATURE_SLOPE
    if line.slope_high < low:
        place = "below"
    elif line.slope_low > high:
        place = "above"
    else:
        place = "overlaps"
    return {
        "participant": "" if pd.isna(line.participant) else line.participant,
        "torque": line.torque,
        "trials": line.trials,
        "slope": slope,
        "slope_interval": interval,
        "rest": rest,
        "rest_interval": rest_interval,
        "unit": unit_symbol("Nm/rad"),
        "place": place,
        "rises": bool(line.slope_low > 0.0),
    }
