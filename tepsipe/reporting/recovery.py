"""Comparison of estimates with the truth, the only part of the library with the laboratory's constants.

The truth of a joint that is not linear is the linear joint nearest to it in the motion that it made. A rubber
that softens has no one stiffness. What an estimator of I, B, K should find is the least-squares fit of the
true torque by the true motion, over the same windows:

    tau - tau_rest = I theta'' + B theta' + K (theta - theta_rest)

A standing person sways: there every perturbation has its own rest, the time just before its onset, and the
fit is to the mean responses of each trial, as that of the estimators. The torque is the intrinsic one of both
ankles, the angle the mean of both.

The reflex torque of a standing person is the active torque of the true muscles, from its mean just before
each onset. Its numbers are those of `tepsipe.experiments.standing.free_reflex.reflex`, by the same function.

A joint in the manipulator is never at rest, because its drive ripples: angle and torque then count from their
means, as in a spectral fit.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from types import MappingProxyType
from typing import Annotated

import h5py
import numpy as np

from tepsipe.errors import InputError
from tepsipe.experiments.standing.free_reflex.reflex import REFLEX, REFLEX_S, mean_reflex, stretches
from tepsipe.io.estimates import AT_WORK, SMALL, Estimate, Recovery
from tepsipe.io.result import read_hdf5

SIGNALS = ("time", "angle", "rate", "acceleration", "torque")


@dataclass(frozen=True)
class TrueMotion:
    """Hidden motion of a joint, as the laboratory wrote it."""

    time: Annotated[np.ndarray, "(n,)", "s"]
    angle: Annotated[np.ndarray, "(n,)", "rad"]
    rate: Annotated[np.ndarray, "(n,)", "rad/s"]
    acceleration: Annotated[np.ndarray, "(n,)", "rad/s²"]
    torque: Annotated[np.ndarray, "(n,)", "N·m"]
    """From the trigger on."""
    active: Annotated[np.ndarray, "(n,)", "N·m"] | None = None
    """Delayed torque of the muscles of both ankles of a standing person."""


def read_true_motion(path: str | Path) -> TrueMotion:
    """Read the hidden motion of a trial (s, rad, N·m)."""
    return TrueMotion(**read_hdf5(_read, path, "the laboratory's motion", advice="make the trial again"))


def _read(path: str | Path) -> dict[str, np.ndarray]:
    with h5py.File(path, "r") as file:
        return {name: file[name][...] for name in (*SIGNALS, "active") if name in SIGNALS or name in file}


def linear_truth(
    motion: TrueMotion,
    windows_s: list[tuple[float, float]],
    *,
    about_mean: bool = False,
    inertia_beyond: float = 0.0,
) -> dict[str, float]:
    """I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad) of the nearest linear joint, mean over windows.

    windows_s: start and end of each window.
    about_mean: count angle and torque from their means in the window, not from the first sample of the
    trial.
    inertia_beyond: inertia beyond the place where the torque is measured (N·m·s²/rad): the foot feels the
    moment of the rubber, but not the inertia that turns with the leg.
    """
    found = []
    at_rest, torque_at_rest = motion.angle[0], motion.torque[0]
    for start, end in windows_s:
        own = slice(*np.searchsorted(motion.time, (start, end)))
        columns = np.column_stack([motion.acceleration[own], motion.rate[own], motion.angle[own] - at_rest])
        torque = motion.torque[own] - torque_at_rest - inertia_beyond * columns[:, 0]
        if columns.shape[0] < 5 or not np.ptp(columns[:, 2]):
            raise InputError(
                f"expected motion from {start:.2f} to {end:.2f} s, found none: make the trial again"
            )
        if about_mean:
            columns, torque = columns - columns.mean(axis=0), torque - torque.mean()
        found.append(np.linalg.lstsq(columns, torque, rcond=None)[0])
    return dict(zip("IBK", np.mean(found, axis=0).tolist(), strict=True))


def linear_truth_standing(
    motions: list[TrueMotion],
    onsets_s: list[np.ndarray],
    window_s: float,
    inertia: bool,
    baseline_s: tuple[float, float],
) -> dict[str, float]:
    """B (N·m·s/rad), K (N·m/rad) of the linear ankles nearest to the true ones in the mean responses.

    motions: of the trials that were fitted together: mean angle and intrinsic torque of both ankles.
    onsets_s: onsets of the fitted perturbations of each trial.
    window_s: length of the fitted window from the onset.
    inertia: whether I (N·m·s²/rad) is fitted too.
    baseline_s: from where to where a response counts as rest, from the onset.
    Returns: B and K, and I if it is fitted.
    """
    names = ("acceleration", "rate", "angle") if inertia else ("rate", "angle")
    columns, torques = [], []
    for motion, onsets in zip(motions, onsets_s, strict=True):
        means = {name: _mean_response(motion, name, onsets, window_s, baseline_s) for name in SIGNALS[1:]}
        if not onsets.size or not np.ptp(means["angle"]):
            raise InputError(
                f"expected motion within {window_s:g} s after every onset, found none: make the trial again"
            )
        columns.append(np.column_stack([means[name] for name in names]))
        torques.append(means["torque"])
    found = np.linalg.lstsq(np.concatenate(columns), np.concatenate(torques), rcond=None)[0]
    return dict(zip("IBK" if inertia else "BK", found.tolist(), strict=True))


def _mean_response(
    motion: TrueMotion, name: str, onsets_s: np.ndarray, window_s: float, baseline_s: tuple[float, float]
) -> np.ndarray:
    """Mean over the perturbations of a signal in the window, less its mean before the onset (its unit)."""
    return _responses(motion, name, onsets_s, window_s, baseline_s).mean(axis=0)


def _responses(
    motion: TrueMotion, name: str, onsets_s: np.ndarray, window_s: float, baseline_s: tuple[float, float]
) -> np.ndarray:
    """The same of every perturbation, shape (perturbations, n)."""
    step_s = float(motion.time[1] - motion.time[0])
    signal = getattr(motion, name)
    window, before = (
        start + np.arange(0.0, stop - start + 0.5 * step_s, step_s)
        for start, stop in ((0.0, window_s), baseline_s)
    )

    def at(instants: np.ndarray) -> np.ndarray:
        return np.interp(onsets_s[:, None] + instants, motion.time, signal)

    return at(window) - at(before).mean(axis=1, keepdims=True)


def true_reflex(
    motions: list[TrueMotion], onsets_s: list[np.ndarray], baseline_s: tuple[float, float]
) -> dict[str, float]:
    """Peak, impulse, gain and delay (N·m, N·m·s, N·m·s/rad, s) of the active torque in the mean responses.

    motions: of the trials that were fitted together, with the active torque.
    onsets_s: onsets of the fitted perturbations of each trial.
    baseline_s: from where to where a response counts as rest, from the onset.
    """
    means = []
    for motion, onsets in zip(motions, onsets_s, strict=True):
        torque, angle = (
            _responses(motion, name, onsets, REFLEX_S[1], baseline_s) for name in ("active", "angle")
        )
        ways = stretches(angle)[0]
        means += [(torque[ways == way].mean(axis=0), angle[ways == way].mean(axis=0)) for way in set(ways)]
    torques, angles = (np.stack(signals) for signals in zip(*means, strict=True))
    time = np.arange(torques.shape[1]) * float(motions[0].time[1] - motions[0].time[0])
    return dict(zip(REFLEX, mean_reflex(time, torques, angles).values.tolist(), strict=True))


AT_PHASE = "the phase to which K belongs"


def recovery_of(estimate: Estimate, truth: float, truth_of: str = SMALL) -> Recovery:
    """An estimate beside its true value (same unit), which holds for the movements ``truth_of``."""
    e, error = estimate, math.nan if truth == 0.0 else (estimate.value - truth) / truth
    return Recovery(
        *(*e.key, e.unit),
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
    compared = {row.key: row for row in rows}
    return [replace(compared[e.key], flags=e.flags) for e in estimates if e.key in compared]


def compare_phases_with_truth(
    estimates: list[Estimate], curves: Mapping[str, Mapping[str, np.ndarray]]
) -> list[Recovery]:
    """Compare I, B and K of simulated walking trials with the truth at the phase to which K belongs.

    estimates: all rows (units in them); ``phase`` of each pathway is where its K belongs (% of stance).
    curves: condition -> ``percent`` (%), ``I``, ``B``, ``K`` (N·m·s²/rad, N·m·s/rad, N·m/rad) over stance.
    Returns: one per value; what has no value, or is assumed, is left out (units in the estimates).
    """
    at = {(e.condition, e.pathway): e.value for e in estimates if e.quantity == "phase"}
    rows = []
    for e in estimates:
        curve, phase = curves.get(e.condition), at.get((e.condition, e.pathway))
        assumed = "assumed" in e.flags.split(";")
        if curve is not None and phase is not None and e.quantity in ("I", "B", "K") and not assumed:
            truth = float(np.interp(phase, curve["percent"], curve[e.quantity]))
            rows.append(recovery_of(e, truth, AT_PHASE))
    return rows
