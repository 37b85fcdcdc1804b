"""Numbers of the chapter on the ankle dummy."""

import math

import numpy as np
import pandas as pd

from tepsipe.experiments.dummy.specification_curve import FILTERED, NONE, RECOMMENDED, Specification
from tepsipe.identification.estimators import (
    JOINT_LIKELIHOOD,
    LEAST_SQUARES,
    LEAST_SQUARES_THESIS,
    OUTPUT_ERROR,
)
from tepsipe.io.result import Result
from tepsipe.reporting.figures.names import short_name
from tepsipe.reporting.numbers.format import _cell, number, percent, span, span_of_decimals
from tepsipe.reporting.numbers.joint_likelihood import joint_likelihood_data
from tepsipe.reporting.recovery import AT_WORK, SMALL

MARKER_ACCURACY_M = 1e-4  # section 2-1-2


def dummy_data(
    fits: dict[str, Result],
    estimates: pd.DataFrame,
    choices: dict,
    recovery: pd.DataFrame | None,
    amplitudes: dict[str, float | None],
) -> dict:
    """Numbers of the ankle dummy's chapter as text.

    Parameters
    ----------
    fits : dict of str to Result
        Condition -> fit.
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
    own = estimates[estimates.experiment == "dummy"]
    printed, recommended = choices["as_printed"], choices["recommended"]

    def values(quantity: str, pathway: str) -> pd.Series:
        chosen = own[(own.quantity == quantity) & (own.pathway == pathway)]
        return chosen.set_index("condition").value

    def amplitude(condition: str) -> float:
        return math.nan if amplitudes[condition] is None else amplitudes[condition]

    geometry = choices["geometry"]
    leg_mgr = geometry["leg_mass_kg"] * geometry["gravity_m_per_s2"] * geometry["leg_com_m"]
    conditions = list(fits)
    smallest = min(conditions, key=lambda c: (amplitude(c), c))
    largest = max(conditions, key=lambda c: (amplitude(c), c))
    clear = [c for c in conditions if amplitude(c) >= 0.3] or conditions
    slope = 1e-3 * float(
        np.mean([fit.facts["damping_per_skew_Nms_per_rad_per_s"][printed] for fit in fits.values()])
    )
    stiffness = own[(own.quantity == "K") & (own.pathway == printed)]
    data = {
        "sem_stiffness": span(stiffness.sem_as_printed, 2),
        "error_stiffness": span(stiffness.u_type_a, 2),
        "printed": printed,
        "recommended": recommended,
        "two_leg_inertia": number(2.0 * geometry["leg_inertia_kgm2"]),
        "two_mgr": number(2.0 * leg_mgr),
        "printed_inertia": span(values("I", printed)),
        "printed_stiffness": span(values("K", printed)),
        "printed_mean_inertia": number(values("I", printed).mean()),
        "printed_mean_stiffness": number(values("K", printed)[clear].mean()),
        "recommended_mean_inertia": number(float(values("I", recommended)[clear].mean()), 2),
        "recommended_mean_stiffness": number(float(values("K", recommended)[clear].mean())),
        "recommended_mean_damping": number(values("B", recommended)[clear].mean()),
        "inertia_found": _differs_from_zero(own, recommended, clear),
        "falls": _falls(values("K", printed), amplitudes),
        "shift_inertia": number(float((values("I", printed) - values("I", recommended))[clear].mean())),
        "shift_stiffness": number(float((values("K", recommended) - values("K", printed))[clear].mean())),
        "signs_explain": _signs_explain(values, printed, recommended, geometry, clear),
        "noise_below_accuracy": bool(
            np.mean([fit.facts["marker_noise_m"] for fit in fits.values()]) < 0.5 * MARKER_ACCURACY_M
        ),
        "clear_from": number(min(map(amplitude, clear)), 1),
        "smallest_name": short_name(smallest),
        "largest_name": short_name(largest),
        "vaf_printed_smallest": percent(values("VAF_perturbation", printed)[smallest], 2),
        "vaf_recommended_smallest": percent(values("VAF_perturbation", recommended)[smallest]),
        "vaf_printed_largest": percent(values("VAF_perturbation", printed)[largest], 2),
        "vaf_recommended_largest": percent(values("VAF_perturbation", recommended)[largest]),
        "vaf_trial_printed": span_of_decimals(values("VAF_trial", printed), 2),
        "vaf_lower": bool(
            (values("VAF_perturbation", recommended) < values("VAF_perturbation", printed)).all()
        ),
        "vaf_of_trial": _vaf_of_trial(own, printed),
        "window_ms": number(1e3 * float(np.mean([fit.facts["mean_window_s"] for fit in fits.values()]))),
        "marker_noise_mm": number(
            1e3 * float(np.mean([fit.facts["marker_noise_m"] for fit in fits.values()])), 2
        ),
        "marker_residual_mm": number(
            1e3 * max(fit.facts["marker_residual_rms_m"] for fit in fits.values()), 2
        ),
        "perturbations": span([len(fit.arrays["windows"]) for fit in fits.values()], 2),
        "damping_per_ms": number(slope, 2),
        "strober": None,
        "recovery": None,
        "output_error": None,
        "joint_likelihood": None,
    }
    by_simulation = [name for name, c in choices["pathways"].items() if c["estimator"] == OUTPUT_ERROR]
    if by_simulation:
        data["output_error"] = _output_error_data(by_simulation[0], fits, own, recovery)
    by_likelihood = [name for name, c in choices["pathways"].items() if c["estimator"] == JOINT_LIKELIHOOD]
    if by_likelihood:
        data["joint_likelihood"] = joint_likelihood_data(by_likelihood[0], own, recovery)
    strober = choices["ingest"]["marker_sampling_hz"]
    alike = {
        pathway["marker_instants"]: name
        for name, pathway in choices["pathways"].items()
        if all(pathway[key] == choices["pathways"][printed][key] for key in ("torque", "estimator"))
    }
    if len(alike) == 2 and strober:
        markers = len(choices["files"]["marker_labels"])
        data["strober"] = {
            "pathway": alike["as-sampled"],
            "aligned": alike["aligned"],
            "frequency": number(strober, 4),
            "spread_ms": number(1e3 * (markers - 1) / strober, 2),
            **{
                f"change_{name}": percent(
                    100.0
                    * float((values(q, alike["as-sampled"]) / values(q, alike["aligned"]) - 1).abs().max())
                )
                for q, name in (("I", "inertia"), ("K", "stiffness"))
            },
            "damping": number(values("B", alike["as-sampled"])[clear].mean(), 2),
            "damping_aligned": number(values("B", alike["aligned"])[clear].mean(), 2),
        }
    if recovery is not None:
        rows = recovery[
            (recovery.experiment == "dummy")
            & (recovery.pathway == recommended)
            & recovery.condition.isin(clear)
        ]
        by = rows.groupby("quantity")
        covered = (rows.covered.astype(str).str.lower() == "true").mean()
        small = recovery[(recovery.experiment == "dummy") & (recovery.truth_of == SMALL)]
        data["recovery"] = {
            "truth": {q: span(g.truth) for q, g in by},
            "at_work": bool((rows.truth_of == AT_WORK).all()),
            "small": {q: number(g.truth.iloc[0]) for q, g in small.groupby("quantity")},
            "rows": _at_work(recovery, recommended, conditions),
            "worst_stiffness": percent(100.0 * by.get_group("K").relative_error.abs().max()),
            "worst_damping": percent(100.0 * by.get_group("B").relative_error.abs().max(), 0),
            "covered": percent(100.0 * covered, 0),
            "count": str(len(clear)),
        }
        below = recovery[
            (recovery.experiment == "dummy")
            & (recovery.pathway == recommended)
            & ~recovery.condition.isin(clear)
        ]
        for name, quantity in (("stiffness", "K"), ("damping", "B")):
            errors = below[below.quantity == quantity].relative_error.abs()
            data["recovery"][f"small_{name}"] = percent(100.0 * errors.max()) if len(errors) else number(None)
    return data


def _signs_explain(values, printed: str, recommended: str, geometry: dict, clear: list[str]) -> bool:
    """Whether I (N·m·s²/rad) and K (N·m/rad) differ by what the signs predict, within 5 %."""
    weight = geometry["leg_mass_kg"] * geometry["gravity_m_per_s2"] * geometry["leg_com_m"]
    expected = {"I": 2.0 * geometry["leg_inertia_kgm2"], "K": -2.0 * weight}
    found = {q: float((values(q, printed) - values(q, recommended))[clear].mean()) for q in expected}
    return all(abs(found[q] / expected[q] - 1.0) < 0.05 for q in expected)


def _output_error_data(
    pathway: str, fits: dict[str, Result], own: pd.DataFrame, recovery: pd.DataFrame | None
) -> dict:
    """Numbers of the output error as text."""
    rows = own[own.pathway == pathway]
    delays = [1e3 * fit.facts["output_error_delay_s"][pathway] for fit in fits.values()]
    data = {
        "pathway": pathway,
        "stiffness": span(rows[rows.quantity == "K"].value, 4),
        "damping": span(rows[rows.quantity == "B"].value),
        "inertia": span(rows[rows.quantity == "I"].value, 2),
        "error_stiffness": span(rows[rows.quantity == "K"].u_type_a, 1),
        "vaf_angle": span_of_decimals(rows[rows.quantity == "VAF_theta_trial"].value, 2),
        "delay_ms": number(max(map(abs, delays)), 1),
        "recovery": None,
    }
    if recovery is not None:
        known = recovery[(recovery.experiment == "dummy") & (recovery.pathway == pathway)]
        by = known.groupby("quantity")
        covered = known.covered.astype(str).str.lower() == "true"
        data["recovery"] = {
            "worst_stiffness": percent(100.0 * by.get_group("K").relative_error.abs().max()),
            "worst_damping": percent(100.0 * by.get_group("B").relative_error.abs().max()),
            "worst_inertia": percent(100.0 * by.get_group("I").relative_error.abs().max(), 0),
            "covered": str(int(covered.sum())),
            "total": str(len(known)),
            "hold": bool(covered.mean() >= 0.8),
        }
    return data


def _vaf_of_trial(own: pd.DataFrame, pathway: str) -> bool:
    """Whether VAF (%) differs between trials more than twice as much as between their parameters."""
    rows = own[own.pathway == pathway].groupby("quantity").value
    if not {"VAF_trial", "VAF_cross_validated"} <= set(rows.groups):
        return False
    of_trials, of_parameters = (np.ptp(rows.get_group(q)) for q in ("VAF_trial", "VAF_cross_validated"))
    return bool(of_parameters < 0.5 * of_trials)


def _differs_from_zero(own: pd.DataFrame, pathway: str, conditions: list[str]) -> bool:
    """Whether every 95 % interval of I (N·m·s²/rad) lies above 0."""
    rows = own[(own.quantity == "I") & (own.pathway == pathway) & own.condition.isin(conditions)]
    return bool((rows.ci_low > 0.0).all())


def _falls(stiffness: pd.Series, amplitudes: dict[str, float | None]) -> bool:
    """Whether K (N·m/rad) at the largest belt velocity is below that at the smallest by more than 5 %."""
    known = {c: a for c, a in amplitudes.items() if a is not None and c in stiffness}
    if len(set(known.values())) < 2:
        return False
    low, high = min(known.values()), max(known.values())
    ends = [stiffness[[c for c, a in known.items() if a == end]].mean() for end in (low, high)]
    return bool(ends[1] < 0.95 * ends[0])


def _at_work(recovery: pd.DataFrame, pathway: str, conditions: list[str]) -> list[dict]:
    """I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad) of every condition, true in its windows and estimated."""
    own = recovery[(recovery.experiment == "dummy") & (recovery.pathway == pathway)]
    by = own.set_index(["condition", "quantity"])
    return [
        {
            "condition": short_name(condition),
            **{
                q: [_cell(q, by.truth[condition, q]), _cell(q, by.value[condition, q])]
                for q in ("I", "B", "K")
            },
        }
        for condition in conditions
        if (condition, "K") in by.index
    ]


def specification_data(rows: list[Specification]) -> dict:
    """Numbers of the specification curve as text.

    Parameters
    ----------
    rows : list of Specification
        Of one trial (units in their names).

    Returns
    -------
    dict
        Text; ``recommended`` is None where none of them is the recommended one.
    """
    stiffness = np.array([row.K_Nm_per_rad for row in rows])
    role = np.array([row.role for row in rows])
    torque = np.array([row.torque for row in rows])
    estimator = np.array([row.estimator for row in rows])
    filtered = np.array([row.filtered for row in rows])
    damping = np.array([row.B_Nms_per_rad for row in rows])
    alike = filtered == FILTERED[0]
    vaf = np.array([row.VAF_percent for row in rows])
    sound = (torque == "leg") & alike & (estimator == "windowed-least-squares")
    printed = (torque == "leg-thesis") & alike
    data = {
        "condition_name": short_name(rows[0].condition),
        "count": str(len(rows)),
        "stiffness": span(stiffness, 2),
        "quarters": f"{number(np.percentile(stiffness, 25), 2)} to {number(np.percentile(stiffness, 75), 2)}",
        "sound": span(stiffness[sound]),
        "sound_count": str(int(sound.sum())),
        "leg_printed": span(stiffness[printed]),
        "leg_printed_count": str(int(printed.sum())),
        "output_error": span(stiffness[estimator == OUTPUT_ERROR]),
        "damping": [
            {"filtered": name, "values": span(damping[(torque == "leg") & (filtered == name)], 2)}
            for name in (*FILTERED, NONE)
        ],
        "foot_rest_in": span(stiffness[(torque == "foot") & (estimator == LEAST_SQUARES_THESIS)], 2),
        "foot_rest_out": span(stiffness[(torque == "foot") & (estimator == LEAST_SQUARES)], 2),
        "recommended": None,
    }
    chosen = stiffness[role == RECOMMENDED]
    if chosen.size:
        near = np.abs(stiffness / chosen[0] - 1.0) < 0.05
        high = vaf > 99.0
        data["recommended"] = {
            "stiffness": number(float(chosen[0])),
            "near": percent(100.0 * near.mean(), 0),
            "near_leg": percent(100.0 * near[torque == "leg"].mean(), 0),
            "near_filtered": [
                {
                    "filtered": name,
                    "near": percent(100.0 * near[(torque == "leg") & (filtered == name)].mean(), 0),
                }
                for name in (*FILTERED, NONE)
            ],
            "near_others": percent(100.0 * near[(torque != "leg") & (torque != "none")].mean(), 0),
            "high_vaf": str(int(high.sum())),
            "high_vaf_far": str(int((high & ~near).sum())),
        }
    return data
