"""Comparison of estimates with the truth, the only part of the library with the laboratory's constants."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from tepsipe.io.estimates import Estimate, Recovery

SMALL, AT_WORK = "small movements", "the fitted windows"
AT_PHASE = "the phase to which K belongs"


def recovery_of(estimate: Estimate, truth: float, truth_of: str = SMALL) -> Recovery:
    """An estimate beside its true value (same unit), which holds for the movements ``truth_of``."""
    e, error = estimate, math.nan if truth == 0.0 else (estimate.value - truth) / truth
    return Recovery(
        *(e.experiment, e.condition, e.pathway, e.estimator, e.quantity, e.unit),
        truth=float(truth),
        value=e.value,
        relative_error=error if math.isfinite(error) else None,
        covered=None if e.ci_low is None or e.ci_high is None else bool(e.ci_low <= truth <= e.ci_high),
        truth_of=truth_of,
        recommended=e.recommended,
        flags=e.flags,
    )


def true_parameters(truth: dict) -> dict[str, dict[str, float]]:
    """Experiment -> I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad) for small movements, mass (kg) or latency (s).

    For the standing person the keys are experiment and task: standing/relax, standing/stiff. K and B are the
    intrinsic values of both ankles, K with the short range; the latency of a muscle, that of its first
    reflex, is the same in every task. For all trials of the manipulator together the key is
    wristalyzer/pooled, with friction (N·m), hardening and softening.

    ``truth`` is the laboratory's configuration, or sections of it. The rubber is the same in both rigs; in
    the manipulator the foot rotates with the handle, whose inertia is that of the rig.
    """
    found = {}
    if "dummy" in truth:
        rubber, subject = truth["dummy"]["rubber"], truth["dummy"].get("subject", {})
        small = _of_joint(subject.get("joint_inertia_kgm2", 0.0), rubber)
        found["dummy"] = small | {f"{quantity}_small": value for quantity, value in small.items()}
    if "wristalyzer" in truth:
        rig = truth["wristalyzer"]["manipulator"]
        found["wristalyzer"] = _of_joint(rig["inertia_kgm2"], rubber)
        found["wristalyzer/pooled"] = found["wristalyzer"] | {
            "friction": rig["friction_Nm"],
            "K_cubic": rig["contact_Nm_per_rad3"],
            "K_softened": rubber["softening"] * rubber["stiffness_Nm_per_rad"],
            "B_softened": rubber["softened_damping_Nms_per_rad"],
            "softening_angle": rubber["softening_angle_rad"],
        }
    if "weight" in truth:
        found["weight"] = {"mass": truth["weight"]["mass_kg"]}
    if "heavy_weight" in truth:
        found["weight/heavy"] = {"mass": truth["heavy_weight"]["mass_kg"]}
    for task in truth.get("standing", {}).get("tasks", ()):
        found[f"standing/{task}"] = _of_person(truth["standing"], task)
    return found


def _of_joint(inertia: float, rubber: dict) -> dict[str, float]:
    return {"I": inertia, "B": rubber["damping_Nms_per_rad"], "K": rubber["stiffness_Nm_per_rad"]}


def _of_person(standing: dict, task: str) -> dict[str, float]:
    constants = standing["tasks"][task]
    latencies = {f"latency_{name}": muscle["latency_s"] for name, muscle in standing["muscles"].items()}
    return {
        "I": 0.0,
        "B": constants["damping_Nms_per_rad"][0],
        "K": constants["stiffness_Nm_per_rad"][0] + constants["short_range_Nm_per_rad"],
        **latencies,
    }


def compare_with_truth(
    estimates: Sequence[Estimate],
    known: Mapping[str, float],
    at_work: Mapping[str, Mapping[str, float]] = MappingProxyType({}),
) -> list[Recovery]:
    """Compare the estimates of simulated trials that are analysed together with the laboratory's constants.

    ``known`` are the constants by quantity, for small movements. ``at_work`` are I (N·m·s²/rad),
    B (N·m·s/rad) and K (N·m/rad) of the linear joint nearest to the true one in the fitted windows, by what
    was fitted in them: a pathway, for a standing person an estimator.
    """
    rows = []
    for e in estimates:
        working = at_work.get(e.estimator if e.experiment == "standing" else e.pathway, {})
        if e.quantity in working:
            rows.append(recovery_of(e, working[e.quantity], AT_WORK))
        elif e.quantity in known:
            rows.append(recovery_of(e, known[e.quantity]))
    return rows


def in_order(rows: Sequence[Recovery], estimates: Sequence[Estimate]) -> list[Recovery]:
    """Rows in the order of their estimates (units in them), with the flags that these have by now."""

    def key(row: Recovery | Estimate) -> tuple[str, ...]:
        return row.experiment, row.condition, row.pathway, row.estimator, row.quantity

    compared = {key(row): row for row in rows}
    return [replace(compared[key(e)], flags=e.flags) for e in estimates if key(e) in compared]


def compare_phases_with_truth(
    estimates: list[Estimate], curves: Mapping[str, Mapping[str, np.ndarray]]
) -> list[Recovery]:
    """Compare I, B and K of simulated walking trials with the truth at the phase to which K belongs.

    estimates: all rows (units in them); ``phase`` of each pathway is where its K belongs (% of stance).
    curves: condition -> ``percent`` (%), ``I``, ``B``, ``K`` (N·m·s²/rad, N·m·s/rad, N·m/rad) over stance.
    Returns: one per value; what has no value, or is assumed, is left out (units in the estimates).
    """
    at = {(e.condition, e.pathway): e.value for e in estimates if e.quantity == "phase"}
    return [
        recovery_of(
            e,
            float(
                np.interp(
                    at[e.condition, e.pathway],
                    curves[e.condition]["percent"],
                    curves[e.condition][e.quantity],
                )
            ),
            AT_PHASE,
        )
        for e in estimates
        if e.condition in curves and e.quantity in ("I", "B", "K")
        if (e.condition, e.pathway) in at and "assumed" not in e.flags.split(";")
    ]
