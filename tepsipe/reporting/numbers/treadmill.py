"""Numbers of the chapters on the weight, the foot pathways and the treadmill."""

import numpy as np
import pandas as pd

from tepsipe.experiments.weight import shapes, usual_weight
from tepsipe.io.result import Result
from tepsipe.reporting.figures.names import short_name
from tepsipe.reporting.numbers.format import MINUS, number, percent, span, span_of_decimals
from tepsipe.reporting.numbers.treadmill_sentences import (
    foot_sentences,
    force_sentence,
    frame_of,
    linear_sentence,
    mass_sentence,
    peak_speeds,
    resonance_sentence,
)
from tepsipe.treadmill.calibration import BOTH, OF_BOTH, ModelScore

CLEAR_FROM_M_PER_S = 0.3

# delay of the weight's markers that the report discusses (s)
LAG_S = 1e-4


def matrix_data(scores: list[ModelScore], shown_hz: float) -> dict:
    """R² of every model at one cutoff (Hz), a row for each fit and a column for each evaluation, as text.

    Returns
    -------
    dict
        ``columns``: name, upper limit of R² and root mean square before compensation (unit of the load) of
        each test; ``rows``: model, order, fit, and R² and residual for each test.
    """
    own = [s for s in scores if s.cutoff_hz == shown_hz]
    tests = list(dict.fromkeys(s.test for s in own))
    rows: dict[tuple, dict] = {}
    for s in own:
        row = rows.setdefault(
            (s.model, s.train),
            {"model": s.model, "train": s.train, "order": str(s.order), "converged": True, "cells": {}},
        )
        row["converged"] &= bool(s.converged)
        row["cells"][s.test] = [
            number(s.r2, 3) if s.r2 > -10.0 else f"< {MINUS}10",
            number(s.rms_after, 3),
        ]
    missing = [number(None)] * 2
    first = {test: next(s for s in own if s.test == test) for test in tests}
    for row in rows.values():
        row["cells"] = [row["cells"].get(test, missing) for test in tests]
    return {
        "columns": [
            {"name": test, "limit": number(s.r2_limit, 3), "before": number(s.rms_before, 3)}
            for test, s in first.items()
        ],
        "rows": list(rows.values()),
    }


def weight_data(
    fits: dict[str, dict[str, Result]],
    plate: Result,
    scores: list[ModelScore],
    estimates: pd.DataFrame,
    choices: dict,
) -> dict:
    """Numbers of the weight's chapter as text.

    Parameters
    ----------
    fits : dict of str to dict of str to Result
        Experiments weight and empty: condition -> fit.
    plate : Result
        Mean measured and predicted responses.
    scores : list of ModelScore
        Of the force plate's models (units in them).
    estimates : DataFrame
        Rows of estimates (units in the column ``unit``).
    choices : dict
        Section ``weight`` of the configuration (units in the keys).

    Returns
    -------
    dict
        Text.
    """
    weight, empty = usual_weight(fits["weight"]), fits["empty"]
    fine, coarse = (f"{choices['analysis']['cutoffs_hz'][k]:g} Hz" for k in (0, -1))
    fine_hz = float(choices["analysis"]["cutoffs_hz"][0])
    own = estimates[(estimates.experiment == "weight") & estimates.condition.isin(list(weight))]
    masses = own[own.quantity == "mass"].set_index("condition").value
    spread = own[own.quantity == "mass_sd"].set_index("condition").value
    alike, sizes = {}, {}
    for name in (fine, coarse):
        alike[name], sizes[name] = shapes(empty, weight, name)

    lags = [result.facts["marker_lag_s"] for result in weight.values()]

    def peaks(results: dict[str, Result], name: str) -> list[float]:
        return [float(np.abs(r.arrays[f"{name}/added_force"].mean(axis=0)).max()) for r in results.values()]

    def r2_of(model: str, train: str, test: str, load: str) -> float | None:
        found = [
            s.r2
            for s in scores
            if (s.model, s.train, s.test, s.load, s.cutoff_hz) == (model, train, test, load, fine_hz)
        ]
        return found[0] if found else None

    def best(model: str, train: str, test: str, load: str) -> str:
        return number(r2_of(model, train, test, load), 3)

    def linear_r2(train: str, test: str) -> list[float]:
        return [
            s.r2
            for s in scores
            if (s.train, s.test, s.load, s.cutoff_hz) == (train, test, "Fy", fine_hz)
            and s.model not in (*OF_BOTH, "mean-subtraction")
        ]

    def linear(train: str, test: str) -> str:
        found = linear_r2(train, test)
        return span(found, 2) if found else number(None)

    frame = plate.facts["loaded_frame"]
    data = {
        "mass": number(choices["weight"]["mass_kg"]),
        "masses": [
            {"condition": short_name(c), "mass": f"{masses[c]:.2f}", "spread": f"{spread[c]:.2f}"}
            for c in masses.index
        ],
        "mass_span": f"{masses.min():.2f} to {masses.max():.2f}",
        "lag_ms": span([1e3 * abs(x) for x in lags], 2),
        "lag_sense": "lags" if min(lags) > 0.0 else "leads" if max(lags) < 0.0 else "differs from",
        "peak_empty": span(peaks(empty, fine), 2),
        "peak_weight": span(peaks(weight, fine), 2),
        "peak_belt": span(peaks(weight, "belt"), 2),
        "force_sentence": force_sentence(weight, fine, peaks(weight, fine)),
        "mass_sentence": mass_sentence(
            peak_speeds(weight, fine), [masses[c] for c in weight], [spread[c] for c in weight]
        ),
        "linear_sentence": linear_sentence(
            linear_r2("weight", "weight"),
            linear_r2("empty", "weight"),
            "The attempt of the thesis therefore did not fail because its second-order model was too simple:",
        ),
        # by more than a tenth, in every condition
        "load_matters": bool(sizes[fine]) and all(abs(x - 1.0) > 0.1 for x in sizes[fine]),
        "lags": bool(lags and min(map(abs, lags)) > LAG_S),
        "alike": bool(alike[coarse] and min(alike[coarse]) > 0.9),
        "fine": fine,
        "coarse": coarse,
        "alike_fine": span(alike[fine], 2),
        "alike_coarse": span(alike[coarse], 2),
        "size_fine": span(sizes[fine], 2),
        "size_coarse": span(sizes[coarse], 2),
        "subtraction": best("mean-subtraction", "empty, all", "weight", "Fy"),
        "linear_own": linear("weight", "weight"),
        "linear_other": linear("empty", "weight"),
        "frame_force": best("loaded-frame", "empty+weight", "weight", "Fy"),
        "frame_force_empty": best("loaded-frame", "empty+weight", "empty", "Fy"),
        "frame_moment": best("loaded-frame", "empty+weight", "weight", "Mx"),
        "force_scores": matrix_data([s for s in scores if s.load == "Fy"], fine_hz),
        "best_frame": number(
            max((r for m in OF_BOTH if (r := r2_of(m, BOTH, "weight", "Fy")) is not None), default=None), 3
        ),
        "frame": None,
        "bristle": frame_of(plate.facts.get("bristle_frame"), scores, fine_hz),
    }
    if frame is not None:
        mass = choices["weight"]["mass_kg"]
        data["frame"] = {
            "resonance": resonance_sentence(frame["empty_hz"], frame["loaded_hz"]),
            "lag_ms": number(1e3 * frame["lag_s"], 2),
            "viscous": number(frame["motion"][1], 2),
            "friction_empty": number(frame["motion"][2], 2),
            "friction_loaded": number(frame["motion"][2] + mass * frame["motion"][3], 2),
            "speed": number(frame["friction_speed_m_per_s"], 2),
            "share": percent(100.0 * frame["mount_share"], 1),
            "time_ms": number(1e3 * frame["mount_time_s"], 2),
        }
    return data


def foot_data(
    estimates: pd.DataFrame, choices: dict, recovery: pd.DataFrame | None, amplitudes: dict[str, float | None]
) -> dict:
    """Numbers of the foot pathways as text.

    Parameters
    ----------
    estimates : DataFrame
        Rows of estimates (units in the column ``unit``).
    choices : dict
        Section ``dummy`` of the configuration (units in the keys).
    recovery : DataFrame or None
        Estimates beside the truth, where there is one.
    amplitudes : dict of str to float or None
        Condition -> velocity amplitude (m/s), None where the trial sheet has none.

    Returns
    -------
    dict
        Text.
    """
    clear = [c for c, a in amplitudes.items() if a is not None and a >= CLEAR_FROM_M_PER_S] or list(
        amplitudes
    )
    known = [amplitudes[c] for c in clear]
    lowest = None if None in known else min(known)
    own = estimates[(estimates.experiment == "dummy") & estimates.condition.isin(clear)]
    rows = []
    for pathway in (choices["recommended"], *choices["foot"]["pathways"]):
        values = own[own.pathway == pathway].groupby("quantity").value
        row = {"pathway": pathway}
        for quantity in ("I", "B", "K", "VAF_perturbation"):
            row[quantity] = span_of_decimals(
                values.get_group(quantity), {"I": 4, "B": 3, "K": 2}.get(quantity, 1)
            )
        row["worst"] = number(None)
        if recovery is not None:
            found = recovery[
                (recovery.experiment == "dummy")
                & (recovery.pathway == pathway)
                & (recovery.quantity == "K")
                & recovery.condition.isin(clear)
            ]
            row["worst"] = percent(100.0 * found.relative_error.abs().max(), 0)
        rows.append(row)
    return {
        "rows": rows,
        "count": str(len(clear)),
        "clear_from": number(lowest, 1),
        "sentences": foot_sentences(own, choices["recommended"]),
    }
