"""Comparison of estimates with the truth, the only part of the library with the laboratory's constants."""

import csv
import math
from dataclasses import dataclass
from pathlib import Path

from tepsipe.io.estimates import Estimate

COLUMNS = (
    "experiment",
    "condition",
    "pathway",
    "estimator",
    "quantity",
    "unit",
    "truth",
    "value",
    "relative_error",
    "covered",
)


@dataclass(frozen=True)
class Recovery:
    """One estimate and its true value.

    Attributes
    ----------
    estimate : Estimate
        The estimate (its ``unit``).
    truth : float
        The laboratory's constant (same unit).
    """

    estimate: Estimate
    truth: float

    @property
    def relative_error(self) -> float | None:
        """(value - truth) / truth (-); None where the truth is 0."""
        return None if self.truth == 0.0 else (self.estimate.value - self.truth) / self.truth

    @property
    def covered(self) -> bool | None:
        """Whether the 95 % interval holds the truth (-); None without an interval."""
        low, high = self.estimate.ci_low, self.estimate.ci_high
        return None if low is None or high is None else low <= self.truth <= high


def true_parameters(truth: dict) -> dict[str, dict[str, float]]:
    """Experiment -> I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad) for small movements, mass (kg) or latency (s).

    For the standing person the keys are experiment and task: standing/relax, standing/stiff. K and B are the
    intrinsic values of the ankles; the latency of a muscle is the same in every task.

    ``truth`` is the laboratory's configuration, or sections of it. The rubber of the dummy has no inertia, so
    the inertia *of the joint* is 0 on the treadmill; in the manipulator the foot rotates with the handle.
    """
    found = {}
    if "wristalyzer" in truth:
        inertia = truth["wristalyzer"]["manipulator"]["inertia_kgm2"]
        found["wristalyzer"] = _of_joint(inertia, truth["wristalyzer"]["rubber"])
    if "dummy" in truth:
        found["dummy"] = _of_joint(0.0, truth["dummy"]["rubber"])
    if "weight" in truth:
        found["weight"] = {"mass": truth["weight"]["mass_kg"]}
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
        "K": constants["stiffness_Nm_per_rad"][0],
        **latencies,
    }


def compare_with_truth(
    estimates: list[Estimate], truth: dict, made: dict[str, list[str]], tasks: dict[str, str]
) -> list[Recovery]:
    """Compare every estimate of I, B, K, mass or latency from a simulated trial with the truth.

    Parameters
    ----------
    estimates : list of Estimate
        All estimates (units in them).
    truth : dict
        The laboratory's configuration, or the sections that are compared (units in its keys).
    made : dict of str to list of str
        Experiment -> conditions that the laboratory made.
    tasks : dict of str to str
        Condition of the standing person -> task; a task of simulated trials only counts as a condition.

    Returns
    -------
    list of Recovery
        In the order of the estimates.
    """
    parameters = true_parameters(truth)
    rows = []
    for e in estimates:
        if e.experiment == "standing":
            known = parameters.get(f"standing/{tasks.get(e.condition)}", {})
        else:
            known = parameters.get(e.experiment, {}) if e.condition in made.get(e.experiment, []) else {}
        if e.quantity in known:
            rows.append(Recovery(e, known[e.quantity]))
    return rows


def write_recovery(path: str | Path, rows: list[Recovery]) -> None:
    """Write as CSV; empty cells where there is no relative error or no interval (units in ``unit``)."""
    with open(path, "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        for row in rows:
            e, error, covered = row.estimate, row.relative_error, row.covered
            writer.writerow(
                [
                    *(e.experiment, e.condition, e.pathway, e.estimator, e.quantity, e.unit),
                    f"{row.truth:.10g}",
                    f"{e.value:.10g}" if math.isfinite(e.value) else "",
                    f"{error:.10g}" if error is not None and math.isfinite(error) else "",
                    "" if covered is None else str(covered).lower(),
                ]
            )
