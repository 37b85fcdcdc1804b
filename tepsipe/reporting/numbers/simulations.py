"""Numbers of the chapters on forward simulation and noise."""

import numpy as np
import pandas as pd

from tepsipe.reporting.figures.names import PARAMETER_SETS, short_name, unit_symbol
from tepsipe.reporting.numbers.format import LABELS, _printed, fixed, number, percent, span_of_decimals
from tepsipe.reporting.thesis_tables import TableRow

# an uncertainty below this is numerical (in its unit)
NOTHING = 1e-9
STATES = {"grows": "grows", "falls": "ends in a fall"}
# who moves the dummy, as the report says it
ENGINES = {
    "pybullet": "the multi-body engine PyBullet",
    "mujoco": "the multi-body engine MuJoCo",
    "equations": "a Runge-Kutta method for its equations of motion",
}


def owner(parameter_set: str) -> str:
    """Whose parameters they are, as a sentence says it (no unit)."""
    name = PARAMETER_SETS[parameter_set]
    return f"the {name}" if parameter_set == "wristalyzer" else name


def forward_data(forward: pd.DataFrame, step_s: float, engine: str) -> dict:
    """Numbers of the forward simulations as text.

    Parameters
    ----------
    forward : DataFrame
        Rows of ``forward.csv`` (%).
    step_s : float
        Step of the simulation (s).
    engine : {"pybullet", "mujoco", "equations"}
        What moved the dummy.

    Returns
    -------
    dict
        Text.
    """

    def vafs(name: str, quantity: str, key: str) -> str:
        own = forward[(forward.parameter_set == name) & (forward.quantity == quantity)][key]
        low, high = (percent(x, 0) if x > -1000.0 else "< \N{MINUS SIGN}1000" for x in (own.min(), own.max()))
        return low if low == high else f"{low} to {high}"

    rows = [
        {
            "name": label,
            **{
                f"{quantity}_{key}": vafs(name, quantity, f"vaf_{key}")
                for quantity in ("theta", "tau", "tau_consistent")
                for key in ("perturbation", "trial")
            },
        }
        for name, label in PARAMETER_SETS.items()
        if name in set(forward.parameter_set)
    ]
    states = forward.drop_duplicates(["condition", "parameter_set"])
    unsettled = states[states.state != "settles"]
    return {
        "rows": rows,
        "step_ms": number(1e3 * step_s, 2),
        "engine": ENGINES[engine],
        "conditions": str(forward.condition.nunique()),
        "unsettled": [
            f"with the parameters of {owner(name)} it {STATES.get(state, state)} in "
            f"{', '.join(map(short_name, group.condition))}"
            for (name, state), group in unsettled.groupby(["parameter_set", "state"], sort=False)
        ],
        **_comparisons(forward),
    }


def _comparisons(forward: pd.DataFrame) -> dict:
    """Which parameters predict better (VAF, %): what the sentences of the chapter depend on."""

    def of(name: str, quantity: str, key: str = "vaf_trial") -> pd.Series:
        own = forward[(forward.parameter_set == name) & (forward.quantity == quantity)]
        return own.set_index("condition")[key]

    def low(name: str, quantity: str, key: str = "vaf_trial") -> float:
        return float(of(name, quantity, key).min())

    known = set(forward.parameter_set)
    if not {"wristalyzer", "tep", "corrected"} <= known:
        return {"compared": None}
    best = pd.DataFrame({name: of(name, "theta") for name in ("wristalyzer", "tep", "corrected")}).idxmax(
        axis=1
    )
    won = list(best.index[best == "corrected"])
    printed_grow = forward[(forward.parameter_set == "tep") & (forward.state == "grows")].condition.nunique()
    return {
        "compared": {
            "angle": bool(low("wristalyzer", "theta") > of("tep", "theta").max()),
            "torque": bool(low("tep", "tau") > of("wristalyzer", "tau").max()),
            "corrected_best": [short_name(c) for c in won],
            "corrected_others": [short_name(c) for c in best.index if c not in won],
            "all": str(len(best)),
            "growing": str(printed_grow),
            "windows": percent(low("corrected", "theta", "vaf_perturbation"), 0),
        }
    }


def _of_noise(at: pd.DataFrame, truth: list[float]) -> dict:
    """What the sentences on filtering and on usable noise levels depend on: errors (%) at one SNR."""

    def worst(estimator: str, noise_on: tuple[str, ...], quantity: str, to: float | None) -> float:
        own = at[(at.estimator == estimator) & at.noise_on.isin(noise_on) & (at.quantity == quantity)]
        wanted = own.apparent if to is None else to
        return 100.0 * float(np.abs(own["mean"] / wanted - 1.0).max())

    iv, ls = (
        max(worst(name, ("theta", "both"), q, truth[k]) for k, q in ((1, "B"), (2, "K")))
        for name in ("recommended", "recommended-regression")
    )
    alike, alone = (worst("as-printed", on, "K", None) for on in (("both",), ("tau", "theta")))
    return {
        "iv_error": percent(iv, 1),
        "ls_error": percent(ls, 1),
        "iv_accurate": bool(iv < 5.0),
        "ls_biased": bool(ls > 2.0 * iv and ls > 5.0),
        "method_sound": bool(iv < 5.0 < worst("as-printed", ("tau", "theta", "both"), "K", truth[2])),
        "alike": percent(alike, 0),
        "alone": percent(alone, 0),
        "near_apparent": bool(alike < 10.0),
        "filter_dominates": bool(alone > 2.0 * alike),
    }


def noise_table(rows: list[TableRow], columns: list[str], stiffness: float) -> dict:
    """Table 4-4 of the thesis beside the same table by every processing, as text.

    Parameters
    ----------
    rows : list of TableRow
        Of `tepsipe.reporting.noise_table.table_4_4` (units in them).
    columns : list of str
        Noise on: none, tau, theta, both.
    stiffness : float
        Simulated stiffness of the rows that are shown (N·m/rad).

    Returns
    -------
    dict
        ``groups`` (processings), ``columns``, and ``rows`` with ``label``, ``unit``, ``reported``, and
        ``values``: a list for each group.
    """
    shown = [row for row in rows if row.estimator == f"K = {stiffness:g} Nm/rad"]
    groups = list(dict.fromkeys(row.pathway for row in shown))
    by_quantity: dict[str, dict] = {}
    for row in shown:
        cells = by_quantity.setdefault(
            row.quantity,
            {
                "label": LABELS.get(row.quantity, row.quantity),
                "unit": unit_symbol(row.unit) if row.unit not in ("1", "as printed") else "",
                "reported": [_printed(x) for x in row.reported],
                "values": [[number(None)] * len(columns) for _ in groups],
            },
        )
        cells["values"][groups.index(row.pathway)] = [_short(row.quantity, x) for x in row.values]
    return {"groups": groups, "columns": columns, "rows": list(by_quantity.values())}


def _short(quantity: str, value: float | None) -> str:
    """A number of a wide table (its unit): three significant digits, two of uncertainties and decimals."""
    if value is None or quantity.startswith("SE"):
        return "0" if value is not None and abs(value) < NOTHING else number(value, 2)
    if quantity.startswith("VAF") or quantity == "K":
        return fixed(value, 2 if quantity == "K" or 99.0 < value < 99.995 else 1)
    return number(value, 3 if abs(value) >= 1e-3 else 2)


def noise_shown(rows: list[TableRow], stiffness: float) -> dict | None:
    """Mean K (N·m/rad) over the conditions by the printed and the recommended processing.

    Parameters
    ----------
    rows : list of TableRow
        Of `tepsipe.reporting.noise_table.table_4_4` (units in them).
    stiffness : float
        Simulated stiffness of the figure (N·m/rad).

    Returns
    -------
    dict or None
        Processing -> lowest to highest of noise on torque, angle and both; None where one was not computed.
    """
    own = [row for row in rows if row.quantity == "K" and row.estimator == f"K = {stiffness:g} Nm/rad"]
    found = {row.pathway: [x for x in row.values[1:] if x is not None] for row in own}
    names = ("as-printed", "recommended")
    if not all(found.get(name) for name in names):
        return None
    return {name: span_of_decimals(found[name], 1) for name in names}


def noise_data(noise: pd.DataFrame, choices: dict) -> dict:
    """Numbers of the noise study as text.

    Parameters
    ----------
    noise : DataFrame
        Rows of ``noise.csv`` (units in the column ``unit``).
    choices : dict
        Section ``noise`` of the configuration (units in the keys).

    Returns
    -------
    dict
        Text.
    """
    level, joint = choices["table_snr_db"], choices["joint"]
    stiffness = joint["stiffness_Nm_per_rad"][0]
    truth = [joint["inertia_Nms2_per_rad"], joint["damping_Nms_per_rad"], stiffness]
    at = noise[(noise.snr_db == level) & noise.quantity.isin(("I", "B", "K"))]
    at = at[at.stiffness_Nm_per_rad == stiffness]
    rows = []
    for estimator in choices["table_estimators"]:
        for noise_on in ("tau", "theta", "both"):
            own = at[(at.estimator == estimator) & (at.noise_on == noise_on)]
            cells = {"estimator": estimator, "noise_on": noise_on}
            for k, quantity in enumerate(("I", "B", "K")):
                values = own[own.quantity == quantity]["mean"]
                cells[quantity] = span_of_decimals(values, (4, 4, 2)[k])
                cells[f"{quantity}_off"] = percent(100.0 * float(np.abs(values / truth[k] - 1.0).max()), 0)
            rows.append(cells)
    return {
        "rows": rows,
        **_of_noise(at, truth),
        "level": f"{level:g}",
        "draws": str(choices["draws"]),
        "figure_stiffness": f"{joint['stiffness_Nm_per_rad'][-1]:g}",
        "truth": [number(x) for x in truth],
        "apparent": [number(float(at[at.quantity == q].apparent.iloc[0])) for q in ("I", "B", "K")],
        "cells": str(len(noise.drop_duplicates(["condition", "noise_on", "snr_db", "estimator"]))),
    }
