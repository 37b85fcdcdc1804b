"""Numbers of the chapter on the participants."""

import math

import pandas as pd

from tepsipe.reporting.figures.names import unit_symbol
from tepsipe.reporting.numbers.format import number, span

SHOWN = ("K", "B", "K_per_kg", "B_per_kg", "K_over_mgh")
# of experiments whose joints are several
OF_JOINTS = {
    "platform": ("K_mode_ankle", "K_mode_hip", "K_ankle_ankle", "K_hip_hip", "B_ankle_ankle"),
}
HEADS = {
    "K": "$K$ (N·m/rad)",
    "B": "$B$ (N·m·s/rad)",
    "K_per_kg": "$K$ per kg",
    "B_per_kg": "$B$ per kg",
    "K_over_mgh": "$K slash m g h$",
    "K_mode_ankle": "$K$, slow, ankle (N·m/rad)",
    "K_mode_hip": "$K$, slow, hip (N·m/rad)",
    "K_ankle_ankle": "$K$, ankle (N·m/rad)",
    "K_hip_hip": "$K$, hip (N·m/rad)",
    "B_ankle_ankle": "$B$, ankle (N·m·s/rad)",
}
LABELS = {
    "K_mode_ankle": "K of the ankle, slow",
    "K_mode_hip": "K of the hip, slow",
    "K_ankle_ankle": "K, ankle",
    "K_hip_hip": "K, hip",
    "B_ankle_ankle": "B, ankle",
    "K_per_kg": "K per body mass",
    "B_per_kg": "B per body mass",
    "K_over_mgh": "K over m g h",
}


def participants_data(people: pd.DataFrame, group: pd.DataFrame, shown: dict[str, list[str]]) -> dict:
    """Numbers of the participants' chapter as text.

    Parameters
    ----------
    people, group : DataFrame
        Tables of participants and of means over them (units in the column ``unit``).
    shown : dict of str to list of str
        Experiment -> pathway and estimator that the report shows.

    Returns
    -------
    dict
        Text: number of people, span of their masses (kg), and one block per experiment.
    """
    masses = people.dropna(subset="mass_kg").groupby("participant").mass_kg.first()
    return {
        "count": str(people.participant.nunique()),
        "masses": span(masses) if len(masses) else None,
        "belts": "belt" in people,
        "experiments": [
            _block(experiment, _of(people, experiment, choice), _of(group, experiment, choice), choice)
            for experiment, choice in shown.items()
        ],
    }


def _of(table: pd.DataFrame, experiment: str, choice: list[str]) -> pd.DataFrame:
    pathway, estimator = choice
    own = (table.experiment == experiment) & (table.pathway == pathway) & (table.estimator == estimator)
    rows = table[own & table.quantity.isin(OF_JOINTS.get(experiment, SHOWN))].copy()
    if "belt" in rows:
        belts = rows.belt.fillna("")
        rows["condition"] = rows.condition.where(belts == "", rows.condition + ", " + belts)
    return rows


def _block(experiment: str, people: pd.DataFrame, group: pd.DataFrame, choice: list[str]) -> dict:
    quantities = OF_JOINTS.get(experiment, SHOWN)
    persons = [
        {
            "participant": participant,
            "condition": condition,
            "mass": number(_first(rows.mass_kg)),
            "cells": [_cell(rows, quantity) for quantity in quantities],
        }
        for (condition, participant), rows in people.groupby(["condition", "participant"], sort=False)
    ]
    order = {quantity: k for k, quantity in enumerate(quantities)}
    means = [
        {
            "condition": r.condition,
            "quantity": LABELS.get(r.quantity, r.quantity),
            "unit": "" if r.unit == "1" else unit_symbol(r.unit),
            "n": str(r.n),
            "mean": number(r.mean),
            "interval": "" if math.isnan(r.ci_low) else f"{number(r.ci_low)} to {number(r.ci_high)}",
            "sd": number(r.sd),
            "sem": number(r.sem),
            "within": number(r.u_within),
        }
        for r in sorted(group.itertuples(), key=lambda r: order[r.quantity])
    ]
    conditions = list(dict.fromkeys(group.condition))
    means.sort(key=lambda row: conditions.index(row["condition"]))
    return {
        "experiment": experiment.replace("_", " "),
        "pathway": choice[0],
        "estimator": choice[1],
        "heads": [HEADS[quantity] for quantity in quantities],
        "persons": persons,
        "means": means,
    }


def _first(values: pd.Series) -> float | None:
    there = values.dropna()
    return float(there.iloc[0]) if len(there) else None


def _cell(rows: pd.DataFrame, quantity: str) -> str:
    """A value with its standard error within the person (unit of the row)."""
    found = rows[rows.quantity == quantity]
    if found.empty:
        return number(None)
    value, error = found.value.iloc[0], found.standard_error.iloc[0]
    return number(value) if math.isnan(error) else f"{number(value)} ± {number(error, 2)}"
