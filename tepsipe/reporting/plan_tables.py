"""Tables of the plan study: designs beside their Monte Carlo, best pulses, and filters."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Annotated

import numpy as np
import pandas as pd

from tepsipe.experiments.planning.design import FOOT, JOINT_LIKELIHOOD_LINEAR, LEG, Design
from tepsipe.experiments.planning.filter_trials import FilteredEstimates
from tepsipe.experiments.planning.filtering import mismatch_bias
from tepsipe.experiments.planning.optimal_pulse import best_of
from tepsipe.experiments.planning.plan import Plan, plan_experiment
from tepsipe.experiments.planning.pulses import STEP_S, Limits, peaks_of
from tepsipe.mechanics.impedance_model import PARAMETERS, UNITS
from tepsipe.reporting.recovery import TrueMotion, linear_truth
from tepsipe.signals.filters import Lowpass

ALIKE, TORQUE_ONLY, MOTION_ONLY = "alike", "torque only", "motion only"
PREDICTED = "predicted"
_PEAKS = ("velocity_m_per_s", "displacement_m", "acceleration_m_per_s2", "jerk_m_per_s3")


def checked_rows(name: str, plan: Plan, drawn: Annotated[np.ndarray, "(draws, 3)"]) -> list[dict]:
    """Rows of a design beside what its draws show.

    drawn: estimates of trials with noise (N·m·s²/rad, N·m·s/rad, N·m/rad).
    Returns: one per quantity, with ``monte_carlo_u``, its relative standard error and ``monte_carlo_bias``.
    """
    spread, shift = drawn.std(axis=0, ddof=1), drawn.mean(axis=0) - plan.design.parameters
    protocol = plan.design.protocol
    found = []
    for k, row in enumerate(plan.rows()):
        first = ("quantity", "n_perturbations", "predicted_u")
        found.append(
            {
                "design": name,
                **{key: row[key] for key in first},
                "monte_carlo_u": float(spread[k]),
                "monte_carlo_error": float(1.0 / np.sqrt(2.0 * (len(drawn) - 1.0))),
                "monte_carlo_bias": float(shift[k]),
                "draws": len(drawn),
                "pathway": protocol.pathway,
                "profile": protocol.pulse.profile,
                "of_rest": float(plan.of_rest[k]),
                **{key: value for key, value in row.items() if key not in first},
            }
        )
    return found


# ---- pulses --------------------------------------------------------------------------------------


def compared_pulses(name: str, plan: Plan, comfort: Limits) -> tuple[list[dict], list[dict]]:
    """Best pulses of the length of a reference, and what they show at the same number.

    Returns: one row per set of limits, with Cramer-Rao bounds of a linear joint (N·m/rad), and the
    velocities of the belt (m/s) over time (s).
    """
    peaks, drive = peaks_of(plan.motion.pulse_velocity), plan.design.rig.drive
    protocol = replace(plan.design.protocol, pathway=JOINT_LIKELIHOOD_LINEAR)
    linear = plan_experiment(replace(plan.design, protocol=protocol))
    acceleration = Limits(acceleration_m_per_s2=peaks.acceleration_m_per_s2)
    cases = [
        ("its own peaks", peaks, False),
        ("its own peaks", peaks, True),
        ("its own acceleration", acceleration, True),
        ("comfort", comfort, False),
        ("comfort", comfort, True),
    ]
    rows, shapes = [], _shape(name, "reference", False, plan)
    for which, limits, one_way in cases:
        best = best_of(plan, limits, one_way)
        held = replace(
            limits, acceleration_m_per_s2=min(limits.acceleration_m_per_s2, drive.acceleration_m_per_s2)
        )
        rows.append(
            {
                "reference": name,
                "limits": which,
                "belt": "one way" if one_way else "returns",
                "reference_u": float(plan.type_a[2]),
                "best_u": float(best.plan.type_a[2]),
                "u_ratio": float(best.plan.type_a[2] / plan.type_a[2]),
                "reference_cramer_rao": float(linear.bound[2]),
                "best_cramer_rao": float(best.found.standard_error),
                "least_cramer_rao": float(best.found.least_standard_error),
                **{f"limit_{key}": getattr(held, key) for key in _PEAKS},
                **{f"peak_{key}": getattr(best.found.peaks, key) for key in _PEAKS},
            }
        )
        shapes += _shape(name, which, one_way, best.plan)
    return rows, shapes


def _shape(name: str, which: str, one_way: bool, plan: Plan) -> list[dict]:
    kept = plan.motion.pulse_velocity[: round(0.25 / STEP_S)]
    return [
        {
            "reference": name,
            "limits": which,
            "belt": "one way" if one_way else "returns",
            "time_s": STEP_S * k,
            "velocity_m_per_s": float(v),
        }
        for k, v in enumerate(kept)
    ]


# ---- filters -------------------------------------------------------------------------------------


def _filter_row(source: str, pathway: str, filtered: str, lowpass: Lowpass) -> dict:
    return {
        "source": source,
        "pathway": pathway,
        "filtered": filtered,
        "kind": "zero-lag" if lowpass.zero_lag else "one-sided",
        "order": lowpass.order,
        "cutoff_hz": lowpass.cutoff_hz,
    }


def predicted_filters(design: Design, lowpasses: Sequence[Lowpass]) -> list[dict]:
    """Bias and standard deviation of one window behind every filter, predicted.

    Returns: rows with bias and standard deviation (units of I, B, K); filters of one side only without
    noise.
    """
    rows = []
    for lowpass in lowpasses:
        own = {"cutoff_hz": lowpass.cutoff_hz, "order": lowpass.order, "zero_lag": lowpass.zero_lag}
        for pathway in (LEG, FOOT):
            planned = plan_experiment(
                replace(design, protocol=replace(design.protocol, pathway=pathway, **own), sources={})
            )
            falling = planned.type_a**2 - planned.of_rest**2
            of_window = np.sqrt(falling * design.protocol.number)
            first = _filter_row(PREDICTED, pathway, ALIKE, lowpass)
            rows += _quantities(first, planned.bias, of_window, design.parameters)
        for filtered, sides in ((TORQUE_ONLY, (lowpass, None)), (MOTION_ONLY, (None, lowpass))):
            bias = mismatch_bias(design, planned.motion, *sides)
            first = _filter_row(PREDICTED, LEG, filtered, lowpass)
            rows += _quantities(first, bias, np.zeros(3), design.parameters)
    return rows


def _quantities(first: dict, bias: np.ndarray, sd: np.ndarray, values: np.ndarray) -> list[dict]:
    return [
        {
            **first,
            "quantity": name,
            "unit": UNITS[name],
            "truth": float(values[k]),
            "bias": float(bias[k]),
            "sd_of_window": float(sd[k]),
            "bias_percent": 100.0 * float(bias[k] / values[k]),
            "sd_percent": 100.0 * float(sd[k] / values[k]),
        }
        for k, name in enumerate(PARAMETERS)
        if name != "I"  # of which plate and foot show another part than the motion of the leg
    ]


def window_rows(condition: str, found: Sequence[FilteredEstimates]) -> list[dict]:
    """Estimates of every window of a trial behind a filter (units of I, B, K; s)."""
    return [
        {
            **_filter_row(condition, one.pathway, ALIKE, one.lowpass),
            "start_s": start,
            "stop_s": stop,
            **{name: float(x) for name, x in zip(PARAMETERS, parameters, strict=True)},
        }
        for one in found
        for (start, stop), parameters in zip(one.windows_s, one.parameters, strict=True)
    ]


def simulated_filters(windows: pd.DataFrame, truth: Mapping[str, TrueMotion]) -> list[dict]:
    """Bias and standard deviation over the windows of simulated trials, against the truth of every window.

    windows: rows of `window_rows` of all trials (units there).
    truth: condition -> true motion.
    Returns: as `predicted_filters`.
    """
    known: dict[tuple, np.ndarray] = {}

    def true(condition: str, start: float, stop: float) -> np.ndarray:
        key = (condition, round(start, 6), round(stop, 6))
        if key not in known:
            found = linear_truth(truth[condition], [(start, stop)])
            known[key] = np.array([found[name] for name in PARAMETERS])
        return known[key]

    groups = ["source", "pathway", "filtered", "kind", "order", "cutoff_hz"]
    rows = []
    for key, own in windows.groupby(groups, sort=False):
        first = dict(zip(groups, key, strict=True))
        own_truth = np.array([true(first["source"], w.start_s, w.stop_s) for w in own.itertuples()])
        errors = own[list(PARAMETERS)].to_numpy() - own_truth
        rows += _quantities(first, errors.mean(axis=0), errors.std(axis=0, ddof=1), own_truth.mean(axis=0))
    return rows
