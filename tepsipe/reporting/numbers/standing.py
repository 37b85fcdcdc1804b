"""Numbers of the chapter on the standing person."""

import math

import numpy as np
import pandas as pd

from tepsipe.io.estimates import FLAGS
from tepsipe.io.result import Result
from tepsipe.reporting.budgets import source_words
from tepsipe.reporting.numbers.format import by_uncertainty, number, percent, span
from tepsipe.reporting.recovery import AT_WORK
from tepsipe.signals.onsets import DETECTORS

# peaks above this many standard deviations of sway are clearly visible (-)
VISIBLE = 3.0
# a knee that rotates less than this part of the shank leaves the body rigid (-)
RIGID = 0.1
# K of a torque that misses most of it (%)
LITTLE = 20.0


def standing_data(
    fits: dict[str, Result],
    task_fits: dict[str, Result],
    estimates: pd.DataFrame,
    choices: dict,
    recovery: pd.DataFrame | None,
    people: dict[str, dict] | None = None,
) -> dict:
    """Numbers of the standing person's chapter as text.

    Parameters
    ----------
    fits, task_fits : dict of str to Result
        Condition -> result of its trial; task -> joint result of its trials.
    estimates : DataFrame
        Rows of estimates (units in the column ``unit``).
    choices : dict
        Section ``standing`` of the configuration (units in the keys).
    recovery : DataFrame or None
        Estimates beside the truth, where there is one.
    people : dict of str to dict, optional
        Participant -> settings of the person (units in the keys), where the study names participants.

    Returns
    -------
    dict
        Text.
    """
    own = estimates[estimates.experiment == "standing"]
    persons = list((people or {"": choices["person"]}).values())
    pathway, estimator = choices["recommended"]["pathway"], choices["recommended"]["estimator"]
    short = _short_window(choices)
    facts = [fit.facts for fit in fits.values()]
    stood = [f for f in facts if f["responses"]]
    truth = None if recovery is None else recovery[recovery.experiment == "standing"]
    return {
        "trials": str(len(fits)),
        "stood": str(len(stood)),
        "perturbations": str(sum(f["perturbations"] for f in facts)),
        "responses": str(sum(f["responses"] for f in facts)),
        "participants": str(len(people)) if people else None,
        "mass": _range([person["mass_kg"] for person in persons]),
        "stature": _range([person["stature_m"] for person in persons]),
        "mgh": span([f["critical_stiffness_Nm_per_rad"] for f in facts]),
        "angle_over_sway": span([f["angle_over_sway"] for f in stood], 2) if stood else number(None),
        "torque_over_sway": span([f["torque_over_sway"] for f in stood], 2) if stood else number(None),
        "left_out": [s for fit in (*fits.values(), *task_fits.values()) for s in fit.facts["left_out"]],
        "tasks": list(task_fits),
        "active": [n for n, c in choices["estimators"].items() if c["active"] not in ("none", "free")],
        "recommended": {"pathway": pathway, "estimator": estimator},
        "pre_reflex": short,
        "pre_reflex_ms": f"{1e3 * choices['estimators'][short]['window_s']:g}",
        "free": _free(own, task_fits, choices, short),
        "estimators": _blocks(own, task_fits, "estimator", list(choices["estimators"]), "pathway", pathway),
        "pathways": _blocks(own, task_fits, "pathway", list(choices["pathways"]), "estimator", short),
        "by_trial": _by_trial(own, list(fits), pathway, estimator),
        "window_spread": _window_spread(task_fits, choices["estimators"][short]["window_s"]),
        "latencies": _latencies(task_fits, choices["latency"]["detector"], truth),
        "joints": _joints(task_fits),
        "rigid": all(row["rigid"] for row in _joints(task_fits)),
        "visible": bool(stood and min(f["angle_over_sway"] for f in stood) > VISIBLE),
        "torques": _torques(own, task_fits, choices, short),
        "single_joint": _single_joint(own, task_fits, choices, short),
        "apart": _apart(own, fits, task_fits, pathway, estimator),
        "recovery": None if truth is None or truth.empty else _recovery(truth, task_fits, choices),
    }


def _rows(own: pd.DataFrame, condition: str, pathway: str, estimator: str) -> pd.DataFrame:
    chosen = (own.condition == condition) & (own.pathway == pathway) & (own.estimator == estimator)
    return own[chosen].set_index("quantity")


def _with_interval(rows: pd.DataFrame, quantity: str) -> str:
    if quantity not in rows.index:
        return number(None)
    r = rows.loc[quantity]
    value, interval = by_uncertainty(r.value, r.ci_low, r.ci_high)
    return f"{value} ({interval})" if interval else value


def _plain(rows: pd.DataFrame, quantity: str, scale: float = 1.0, digits: int = 3) -> str:
    return number(scale * rows.loc[quantity].value, digits) if quantity in rows.index else number(None)


def _blocks(own, tasks, what: str, names: list[str], fixed: str, chosen: str) -> list[dict]:
    """Rows of a table: every estimator on one pathway, or every pathway by one estimator, for each task."""
    blocks = []
    for task in tasks:
        for name in names:
            rows = _rows(own, task, **{what: name, fixed: chosen})
            if rows.empty:
                continue
            blocks.append(
                {
                    "task": task,
                    "name": name,
                    "stiffness": _with_interval(rows, "K"),
                    "damping": _with_interval(rows, "B"),
                    "over_mgh": _plain(rows, "K_over_mgh", digits=2),
                    "rotation": _plain(rows, "rotation", 180.0 / math.pi, 2),
                    "vaf": percent(rows.loc["VAF_response"].value),
                }
            )
    return blocks


def _window_spread(task_fits: dict[str, Result], window_s: float) -> str:
    """Largest deviation of K for windows within 20 ms of the chosen length (%)."""
    worst = []
    for fit in task_fits.values():
        length = fit.arrays["windows/length"]
        near = np.abs(length - window_s) <= 0.0201
        if not near.any():
            continue
        value = fit.arrays["windows/K"][:, 0]
        own = value[np.abs(length - window_s).argmin()]
        worst.append(100.0 * float(np.abs(value[near] / own - 1.0).max()))
    return percent(max(worst), 0) if worst else number(None)


def _by_trial(own: pd.DataFrame, conditions: list[str], pathway: str, estimator: str) -> list[dict]:
    rows = []
    for condition in conditions:
        found = _rows(own, condition, pathway, estimator)
        if found.empty:
            rows.append({"condition": condition, "stiffness": "left out", "rotation": "", "count": ""})
            continue
        rows.append(
            {
                "condition": condition,
                "stiffness": _with_interval(found, "K"),
                "over_mgh": _plain(found, "K_over_mgh", digits=2),
                "rotation": _plain(found, "rotation", 180.0 / math.pi, 2),
                "count": str(int(found.loc["K"].n_perturbations)),
            }
        )
    return rows


def _latencies(task_fits: dict[str, Result], shown: str, truth: pd.DataFrame | None) -> list[dict]:
    """One row per muscle and task: latency by every detector (ms)."""
    rows = []
    for task, fit in task_fits.items():
        for muscle in fit.facts["muscles"]:
            if muscle not in fit.facts["latencies"]:
                continue
            found = fit.facts["latencies"][muscle]
            cells = []
            for detector in DETECTORS:
                onset = found[detector]
                text = number(None)
                if onset["latency_s"] is not None:
                    text = f"{1e3 * onset['latency_s']:.1f}"
                    if detector == shown and onset["interval_s"]:
                        low, high = (1e3 * x for x in onset["interval_s"])
                        text += f" ({low:.1f} to {high:.1f})"
                cells.append(text)
            true = number(None)
            if truth is not None:
                known = truth[truth.quantity == f"latency_{muscle}"].truth
                true = number(1e3 * float(known.iloc[0]), 2) if len(known) else number(None)
            rows.append(
                {
                    "task": task,
                    "muscle": muscle,
                    "cells": cells,
                    "count": str(found["responses"]),
                    "truth": true,
                }
            )
    return rows


def _joints(task_fits: dict[str, Result]) -> list[dict]:
    """Rotation of segments within 0.3 s of an onset, means over trials (degrees)."""
    rows = []
    for task, fit in task_fits.items():
        if "mean/time" not in fit.arrays:
            continue
        near = (fit.arrays["mean/time"] >= 0.0) & (fit.arrays["mean/time"] <= 0.3)
        turned = {
            key: float(np.degrees(np.ptp(fit.arrays[f"mean/{key}"][:, near], axis=1).mean()))
            for key in ("shank", "thigh", "knee")
        }
        rows.append(
            {"task": task, **{key: number(value, 2) for key, value in turned.items()}}
            | {
                "knee_over_shank": percent(100.0 * turned["knee"] / turned["shank"], 0),
                "rigid": bool(turned["knee"] < RIGID * turned["shank"]),
            }
        )
    return rows


def _torques(own, tasks: dict[str, Result], choices: dict, estimator: str) -> dict:
    """K by other torques as part of that by the recommended pathway (%): as printed, and not compensated."""
    best = choices["recommended"]["pathway"]
    kinds = choices["pathways"]
    others = {
        "printed": [name for name, p in kinds.items() if p["torque"] == "ankle-thesis"],
        "uncompensated": [
            name
            for name, p in kinds.items()
            if p["torque"] == kinds[best]["torque"] and p["treadmill_model"] is None and name != best
        ],
    }
    found: dict[str, str | None] = {}
    for kind, names in others.items():
        parts = []
        for task in tasks if names else ():
            one, all_of_it = (_rows(own, task, name, estimator) for name in (names[0], best))
            if "K" in one.index and "K" in all_of_it.index:
                parts.append(100.0 * one.loc["K"].value / all_of_it.loc["K"].value)
        found[kind] = span(parts, 2) if parts else None
        found[f"{kind}_little"] = bool(parts and max(abs(part) for part in parts) < LITTLE)
    return found


def _single_joint(own, tasks: dict[str, Result], choices: dict, estimator: str) -> str | None:
    """Stiffness from the single-joint torque (inverted pendulum), in units of m g h."""
    names = [name for name, pathway in choices["pathways"].items() if pathway["torque"] == "single-joint"]
    values = []
    for task, fit in tasks.items() if names else ():
        rows = _rows(own, task, names[0], estimator)
        if "K" in rows.index:
            values.append(rows.loc["K"].value / fit.facts["critical_stiffness_Nm_per_rad"])
    return span(values, 2) if values else None


def _range(values: list[float]) -> str:
    """Lowest to highest of some settings (any unit), as they are written."""
    low, high = f"{min(values):g}", f"{max(values):g}"
    return low if low == high else f"{low} to {high}"


def _apart(own: pd.DataFrame, fits: dict, tasks: dict, pathway: str, estimator: str) -> list[dict]:
    """Differences of K between the tasks of a person (N·m/rad), with what both share subtracted."""
    apart = (own.pathway == pathway) & (own.estimator == estimator) & (own.quantity == "K")
    found = []
    for row in own[apart & ~own.condition.isin([*fits, *tasks])].itertuples():
        parts = [own[apart & (own.condition == task)] for task in row.condition.split("-")]
        error = math.hypot(*[float(p.standard_error.iloc[0]) for p in parts if len(p)])
        value, interval = by_uncertainty(row.value, row.ci_low, row.ci_high)
        found.append(
            {
                "tasks": row.condition,
                "difference": value,
                "interval": interval,
                "differs": bool(row.ci_low * row.ci_high > 0.0),
                "u": number(row.standard_error, 2),
                "independent": number(error, 2),
                "sharper": bool(error > 1.05 * row.standard_error),
            }
        )
    return found


def _short_window(choices: dict) -> str:
    """Name of the first estimator without active torque and inertia; the recommended one if there is none."""
    for name, choice in choices["estimators"].items():
        if choice["active"] == "none" and not choice["inertia"]:
            return name
    return choices["recommended"]["estimator"]


def _free(own: pd.DataFrame, tasks: dict[str, Result], choices: dict, short: str) -> list[dict]:
    """What the estimate with a free reflex torque rests on, task by task; empty without such estimates."""
    pathway, estimator = choices["recommended"]["pathway"], choices["recommended"]["estimator"]
    found = []
    for task, fit in tasks.items():
        if estimator not in fit.facts.get("budgets", {}):
            continue
        value = fit.arrays[f"budget/{estimator}/values"]
        sources = {
            key.rpartition("/")[2]: 100.0 * np.sqrt((rows**2).sum(axis=0)) / np.abs(value)
            for key, rows in fit.arrays.items()
            if key.startswith(f"budget/{estimator}/sources/")
        }
        largest = sorted(sources, key=lambda name: -sources[name][1])[:3]
        windows = fit.arrays[f"budget/{estimator}/windows"]
        plain = _rows(own, task, pathway, short)
        other = plain.loc["K"].value if "K" in plain.index else math.nan
        facts, flags = fit.facts, fit.facts["budgets"][estimator]["flags"]
        found.append(
            {
                "task": task,
                "window_ms": f"{1e3 * choices['estimators'][estimator]['window_s']:g}",
                "windows_ms": f"{1e3 * windows[0, 0]:g} to {1e3 * windows[-1, 0]:g}",
                "range": percent(100.0 * float(np.ptp(windows[:, 2])) / abs(value[1])),
                "range_B": percent(100.0 * float(np.ptp(windows[:, 1])) / abs(value[0])),
                "other": percent(100.0 * (other / value[1] - 1.0)),
                "sources": [f"{source_words(name)} ({percent(sources[name][1])} %)" for name in largest],
                "centre": facts["centre_used"],
                "centre_mm": ["\N{EN DASH}"] * 2
                if facts["joint_centre_m"] is None
                else [percent(1e3 * x) for x in facts["joint_centre_m"]],
                "skin_mm": f"{1e3 * facts['skin_m']:.2f}",
                "flags": [FLAGS[flag] for flag in flags],
            }
        )
    return found


def _recovery(truth: pd.DataFrame, task_fits: dict[str, Result], choices: dict) -> dict:
    """Largest errors of the estimates, and number of intervals that cover the truth."""
    pathway, estimator = choices["recommended"]["pathway"], choices["recommended"]["estimator"]
    pooled = truth.condition.isin(list(task_fits))

    def rows(quantity: str, estimator: str, which) -> pd.DataFrame:
        return truth[
            (truth.quantity == quantity) & (truth.pathway == pathway) & (truth.estimator == estimator) & which
        ]

    def errors(found: pd.DataFrame) -> str:
        return percent(100.0 * found.relative_error.abs().max()) if len(found) else number(None)

    def covered(found: pd.DataFrame) -> str:
        count = int((found.covered.astype(str).str.lower() == "true").sum())
        return f"{count} of {len(found)}"

    active = [n for n, choice in choices["estimators"].items() if choice["active"] not in ("none", "free")]
    recommended = truth[
        truth.quantity.isin(["K", "B"]) & (truth.pathway == pathway) & (truth.estimator == estimator)
    ]
    latencies = truth[
        truth.quantity.str.startswith("latency_") & (truth.estimator == choices["latency"]["detector"])
    ]
    late = 1e3 * (latencies.value - latencies.truth)
    trials = rows("K", estimator, ~pooled)
    return {
        "truth": {
            task: {q: number(float(g.truth.iloc[0])) for q, g in of_task.groupby("quantity")}
            for task in task_fits
            if len(of_task := recommended[recommended.condition == task])
        },
        "at_work": bool((recommended.truth_of == AT_WORK).all()),
        "stiffness": errors(rows("K", estimator, pooled)),
        "damping": errors(rows("B", estimator, pooled)),
        "covered": covered(rows("K", estimator, pooled)),
        "damping_covered": covered(rows("B", estimator, pooled)),
        "trials_stiffness": errors(trials),
        "trials_covered": covered(trials),
        "active": [
            {
                "name": name,
                "stiffness": errors(rows("K", name, pooled)),
                "covered": covered(rows("K", name, pooled)),
            }
            for name in active
        ],
        "latency": f"{late.abs().max():.1f}" if len(late) else number(None),
        "latency_mean": f"{late.mean():.1f}".replace("-", "\N{MINUS SIGN}") if len(late) else number(None),
        "latency_covered": covered(latencies),
    }
