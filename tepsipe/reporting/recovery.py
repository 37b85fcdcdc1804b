"""Comparison of estimates with the truth, the only part of the library with the laboratory's constants."""

import math
from collections.abc import Mapping, Sequence

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
    estimates: list[Estimate],
    truth: dict,
    made: dict[str, list[str]],
    tasks: dict[str, str],
    at_work: dict[tuple[str, str, str], dict[str, float]] | None = None,
    heavy: Sequence[str] = (),
) -> list[Recovery]:
    """Compare every estimate of I, B, K, mass or latency from a simulated trial with the truth.

    truth: the laboratory's configuration, or the sections that are compared (units in its keys).
    made: experiment -> conditions that the laboratory made.
    tasks: condition of the standing person -> task; a task of simulated trials only counts as a condition.
    at_work: experiment, condition and pathway, for a standing person the estimator -> I, B, K of the linear
    joint nearest to the true one in the fitted windows (N·m·s²/rad, N·m·s/rad, N·m/rad).
    heavy: conditions of the weight with the laboratory's heavy one.
    Returns: in the order of the estimates.
    """
    parameters = true_parameters(truth)
    rows = []
    own = {e.condition for e in estimates if e.experiment == "wristalyzer" and e.condition != "pooled"}
    # a fit to all trials has a truth if the laboratory made all of them
    together = {("wristalyzer", "pooled")} if own <= set(made.get("wristalyzer", [])) else set()
    for e in estimates:
        if e.experiment == "standing":
            known = parameters.get(f"standing/{tasks.get(e.condition)}", {})
        elif e.experiment == "weight" and e.condition in heavy:
            known = parameters.get("weight/heavy", {})
        elif (e.experiment, e.condition) in together:
            known = parameters.get(f"{e.experiment}/pooled", {})
        else:
            known = parameters.get(e.experiment, {}) if e.condition in made.get(e.experiment, []) else {}
        # windows belong to the pathway of the dummy and of the manipulator, to the estimator of a person
        fitted = e.estimator if e.experiment == "standing" else e.pathway
        working = (at_work or {}).get((e.experiment, e.condition, fitted), {})
        if e.quantity in working:
            rows.append(recovery_of(e, working[e.quantity], AT_WORK))
        elif e.quantity in known:
            rows.append(recovery_of(e, known[e.quantity]))
    return rows


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
