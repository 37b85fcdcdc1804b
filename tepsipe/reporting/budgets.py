"""Uncertainty budgets across trials, relative to the estimates: what a laboratory should measure better."""

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from tepsipe.io.estimates import QUOTED, Contribution, Estimate
from tepsipe.statistics.uncertainty import SCATTER, coverage_factor

# name of a source -> what a reader understands by it
SOURCES = {
    SCATTER: "scatter of the data",
    "leg_mass_kg": "mass of the leg",
    "leg_com_m": "centre of mass of the leg",
    "leg_inertia_kgm2": "moment of inertia of the leg",
    "joint_offset_m": "position of the joint's axis",
    "anterior_offset_m": "markers, across the leg",
    "longitudinal_offset_m": "markers, along the leg",
    "vertical_rad": "direction of gravity",
    "marker_scale": "lengths of the motion capture",
    "clock_ratio": "rate of the motion capture",
    "marker_sampling_s": "time between markers",
    "levelled_rad": "axes after levelling by the belt",
    "leg_bending_rad_per_m_per_s2": "bending of the leg",
    "foot_mass_kg": "mass of the foot",
    "foot_com_m": "centre of mass of the foot",
    "foot_compliance_rad_per_Nm": "compliance of the foot",
    "force_scale": "scale of the force plate",
    "vertical_leak": "cross-talk of the force plate",
    "origin_height_m": "height of the plate's axes",
    "origin_anterior_m": "position of the plate's axes along the belt",
    "log_delay_s": "delay of belt velocity after forces",
    "belt_force_ratio": "belt-induced force",
    "treadmill_calibration": "calibration of the treadmill model",
    "treadmill_residual": "residual of the treadmill model",
    "treadmill_model": "calibration of the treadmill model",
    "joint_centre_anterior_m": "position of the ankle's centre along the belt",
    "joint_centre_height_m": "height of the ankle's centre",
    "foot_mass": "mass of the feet",
    "force_marker_delay_s": "delay of forces after markers",
    "skin_m": "motion of soft tissue over bone",
    "tissue_hz": "natural frequency of soft tissue",
    "marked_rotation": "difference between the legs",
    "foot_rotation": "rotation of the hindfoot",
    "moment_scale": "scale of the plate's moment",
    "window_s": "choice of the window",
    "model_discrepancy": "error of the rig's model",
    "model_discrepancy_of_trial": "error of the rig's model in each trial",
    "reflex_onset_s": "onset of the reflex",
    "joint_yield": "hysteresis of the joint",
    "torque_scale": "scale of the torque",
    "angle_scale": "scale of the angle",
    "torque_delay_s": "delay of the torque after its record",
    "fit_criterion": "criterion of the fit",
    "fitted_band": "fitted band",
    "frequency_resolution": "width of the averaged bands",
}
# stiffness before damping, as the report discusses them
SHOWN = ("K", "B", "mass")
UNITS_OF_NAMES = ("_kgm2", "_kg", "_m", "_s", "_rad", "_scale", "_ratio", "_Nm", "_N", "_hz")


@dataclass(frozen=True)
class RelativeBudget:
    """Budget of one quantity over the trials of one pathway and estimator."""

    quantity: str
    """For example K."""
    conditions: list[str]
    percent: dict[str, np.ndarray]
    """Source -> standard uncertainty that it contributes, of the estimate (%); `SCATTER` is Type A. NaN for
    trials whose estimate does not have the source, shape (conditions,)."""

    @property
    def type_a(self) -> np.ndarray:
        """Type A of every trial, shape (conditions,) (%)."""
        return self.percent.get(SCATTER, np.zeros(len(self.conditions)))

    @property
    def type_b(self) -> np.ndarray:
        """Type B of every trial, shape (conditions,) (%)."""
        parts = [np.nan_to_num(x) ** 2 for name, x in self.percent.items() if name != SCATTER]
        return np.sqrt(np.sum([np.zeros(len(self.conditions)), *parts], axis=0))

    @property
    def combined(self) -> np.ndarray:
        """Combined standard uncertainty of every trial, shape (conditions,) (%)."""
        return np.hypot(self.type_a, self.type_b)

    @property
    def by_size(self) -> list[str]:
        """Sources (no unit), the largest in the typical trial first."""
        return sorted(self.percent, key=lambda name: -float(np.nanmedian(self.percent[name])))

    @property
    def largest(self) -> str:
        """The source (no unit) that contributes most in the typical trial."""
        return self.by_size[0]

    def expanded(self, times: float) -> float:
        """1.96 combined standard uncertainties in the typical trial, with so many times as much data (%)."""
        combined = np.hypot(self.type_a / math.sqrt(times), self.type_b)
        return float(coverage_factor(np.array(np.inf)) * np.median(combined))


def relative_budgets(
    contributions: Iterable[Contribution], estimates: Iterable[Estimate], quantities: Sequence[str] = QUOTED
) -> dict[str, RelativeBudget]:
    """Budgets of some estimates, relative to their values.

    estimates: those whose budgets are wanted, one per trial and quantity (units in them).
    quantities: names of quantities; those without a budget are left out, and I, which may be 0.
    Returns: quantity -> its budget (%). Estimates whose 95 % interval includes 0 are left out: a percentage
    of a value that may be 0 has no meaning.
    """
    values = {
        (e.condition, e.pathway, e.estimator, e.quantity): e.value
        for e in estimates
        if e.quantity in quantities and e.quantity != "I" and _has_percentage(e)
    }
    found: dict[str, dict[str, dict[str, float]]] = {}
    for row in contributions:
        value = values.get((row.condition, row.pathway, row.estimator, row.quantity))
        if value is not None:
            of_source = found.setdefault(row.quantity, {}).setdefault(row.source, {})
            of_source[row.condition] = 100.0 * row.u / abs(value)
    budgets = {}
    for quantity in quantities:
        if quantity in found:
            conditions = list(dict.fromkeys(c for parts in found[quantity].values() for c in parts))
            percent = {
                source: np.array([parts.get(c, np.nan) for c in conditions])
                for source, parts in found[quantity].items()
            }
            budgets[quantity] = RelativeBudget(quantity, conditions, percent)
    return budgets


def _has_percentage(estimate: Estimate) -> bool:
    """The value is finite, and neither it nor its 95 % interval includes 0."""
    low, high = (math.nan if x is None else x for x in (estimate.ci_low, estimate.ci_high))
    return math.isfinite(estimate.value) and estimate.value != 0.0 and not low <= 0.0 <= high


def budgeted(estimates: Iterable[Estimate], foot_pathway: str | None) -> dict[str, list[Estimate]]:
    """Estimates whose budgets are shown (units in them): an experiment -> its recommended ones.

    ``foot`` are those of the dummy by ``foot_pathway``, if there is one.
    """
    found: dict[str, list[Estimate]] = {}
    for e in estimates:
        # a fit to all trials together has a budget, but not the same sources
        if e.recommended and (e.experiment, e.condition) != ("wristalyzer", "pooled"):
            found.setdefault(e.experiment, []).append(e)
        if e.experiment == "dummy" and e.pathway == foot_pathway and e.quantity in QUOTED:
            found.setdefault("foot", []).append(e)
    return found


def parts_of(estimate: Estimate, contributions: Mapping[str, float] | None = None) -> dict[str, float]:
    """Standard uncertainty of an estimate by source, in its unit; empty where it has none.

    contributions: source -> u of its budget, if it has one (unit of the estimate). Without one, Type A and
    all of Type B are two sources, the second one of this trial alone.
    """
    if contributions:
        return dict(contributions)
    if estimate.u_type_b is not None and estimate.u_type_a is not None:
        return {SCATTER: estimate.u_type_a, f"type_b/{estimate.condition}": estimate.u_type_b}
    return {} if estimate.standard_error is None else {SCATTER: estimate.standard_error}


def mean_parts(parts: Sequence[Mapping[str, float]]) -> dict[str, float]:
    """Standard uncertainty by source of a mean over trials of one person or rig (unit of the estimates).

    Scatter is independent between trials; a source is the same quantity in all of them and acts with one
    sign, so it does not average out.
    """
    names = dict.fromkeys(name for own in parts for name in own)
    count = len(parts)
    return {
        name: math.hypot(*(own.get(name, 0.0) for own in parts)) / count
        if name == SCATTER
        else sum(own.get(name, 0.0) for own in parts) / count
        for name in names
    }


def difference_parts(first: Mapping[str, float], second: Mapping[str, float]) -> dict[str, float]:
    """Standard uncertainty by source of the difference of two estimates of one person or rig (their unit).

    Scatter is independent. Of a source of both, which acts with one sign, only the difference counts
    (JCGM 100, section 5.2); a source of one of them counts alone.
    """
    names = dict.fromkeys([*first, *second])
    return {
        name: math.hypot(first.get(name, 0.0), second.get(name, 0.0))
        if name == SCATTER
        else abs(second.get(name, 0.0) - first.get(name, 0.0))
        for name in names
    }


def source_words(name: str) -> str:
    """What a reader understands by the name of a source (no unit)."""
    if name in SOURCES:
        return SOURCES[name]
    for unit in UNITS_OF_NAMES:
        name = name.removesuffix(unit)
    return name.replace("_", " ")
