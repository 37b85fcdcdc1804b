r"""The weight experiment: the belt-induced force under acceleration (thesis section 3-1-2).

Symbols: F_y measured force (N), y_w position of the weight (m), m_w its mass (kg).

    ideal force           F_hat = m_w y_w''              (3-10)
    belt-induced force    Delta F = F_y - F_hat          (3-11), there with the opposite sign
    empty belt            F_y0
    estimated mass        m_hat = y_w'' \ F_y            (3-12)

If the dynamics of the treadmill did not depend on the load carried, Delta F would equal F_y0. m_w is known:
an interval of m_hat that excludes it indicates a belt-induced force larger than its budget allows.
"""

from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np

from tepsipe.experiments.budgets import contributions_of, rows_of
from tepsipe.experiments.fitted import Fitted
from tepsipe.identification.result import Quantity, quantities_of
from tepsipe.io.estimates import recommended
from tepsipe.io.result import Result
from tepsipe.statistics.uncertainty import Budget, Source, scatter
from tepsipe.treadmill.recording import BeltRecording

PATHWAY = "force"
ESTIMATOR = "least-squares"


@dataclass(frozen=True)
class WeightAnalysis:
    """Results of one trial with the weight or with the empty belt."""

    recordings: dict[str, BeltRecording]
    """Name of a filter -> fore-aft force with it (N)."""
    masses: Annotated[np.ndarray, "(perturbations,)"]
    """m_hat of every perturbation (kg); empty for the empty belt."""
    quantities: dict[str, Quantity]
    """Mean of m_hat and its SD over perturbations, ``mass`` and ``mass_sd`` (kg; none of the empty belt), and
    the peak of the mean belt-induced force, ``added_force_peak`` (N)."""
    marker_lag_s: float | None = None
    """Time by which the weight's markers lag behind the belt (s); None for the empty belt."""


def estimate_masses(recording: BeltRecording) -> np.ndarray:
    """Thesis eq (3-12) for every perturbation, from the fore-aft force (N), shape (perturbations,) (kg).

    The acceleration a_b of the belt, from its log, is the instrument of the weight's, whose noise would make
    the mass too small (errors in variables): m_hat = sum(a_b F_y) / sum(a_b y_w'').
    """
    acceleration = recording.segments(recording.carried) / recording.carried_kg
    force = recording.segments(recording.load + recording.carried)
    instrument = recording.segments(recording.acceleration)
    return np.sum(instrument * force, axis=1) / np.sum(instrument * acceleration, axis=1)


def mass_budget(
    masses: Annotated[np.ndarray, "(perturbations,)", "kg"], sources: dict[str, Source]
) -> Budget:
    """Uncertainty of the mean of m_hat.

    m_hat is F_y over y_w''. A relative error of the force is therefore an equal relative error of the mass;
    an error of the motion capture's lengths has the opposite sign. A belt-induced force in phase with y_w'',
    which grows with the load, adds its share. The known mass of the weight does not enter.

    masses: m_hat of every perturbation.
    sources: force_scale, marker_scale and belt_force_ratio, as far as they are known.
    Returns: budget of one quantity, the mass.
    """
    type_a, freedom = scatter(masses[:, None])
    mass = float(masses.mean())
    per_unit = {"force_scale": mass, "marker_scale": -mass, "belt_force_ratio": mass}
    return Budget(
        type_a,
        freedom,
        {
            name: np.array([[slope * sources[name].standard_uncertainty]])
            for name, slope in per_unit.items()
            if name in sources
        },
        {name: source.freedom for name, source in sources.items()},
    )


def analyse_weight(
    recordings: dict[str, BeltRecording], sources: dict[str, Source], marker_lag_s: float | None = None
) -> WeightAnalysis:
    """Mass of the weight, and belt-induced force.

    recordings: name of a filter -> fore-aft force; the mass is estimated with the first.
    sources: uncertain constants, as in `mass_budget`.
    marker_lag_s: time by which the weight's markers lag behind the belt (s), stored with the results.
    Returns: masses and their uncertainty; none for an empty belt.
    """
    first = next(iter(recordings.values()))
    peak = float(np.abs(first.segments(first.load).mean(axis=0)).max())
    force = {"added_force_peak": Quantity(peak, "N")}
    if first.carried_kg == 0.0:
        return WeightAnalysis(recordings, np.empty(0), force)
    masses = estimate_masses(first)
    return WeightAnalysis(recordings, masses, _mass(first, masses, sources) | force, marker_lag_s)


def _mass(recording: BeltRecording, masses: np.ndarray, sources: dict[str, Source]) -> dict[str, Quantity]:
    """Mean of m_hat and its SD over perturbations (kg); the mean is flagged far from the recording's mass."""
    mass = quantities_of({"mass": masses.mean()}, mass_budget(masses, sources))["mass"]
    flags = () if mass.low <= recording.carried_kg <= mass.high else ("mass-differs",)
    spread = float(masses.std(ddof=1)) if masses.size > 1 else 0.0
    return {"mass": replace(mass, flags=flags), "mass_sd": Quantity(spread, "kg")}


def fitted_weight(experiment: str, condition: str, analysis: WeightAnalysis) -> Fitted:
    """Result and rows of one trial."""
    names = (experiment, condition, PATHWAY, ESTIMATOR)
    first = next(iter(analysis.recordings.values()))
    rows = recommended(rows_of(names, analysis.quantities, len(first.onsets)), PATHWAY, ESTIMATOR)
    return Fitted(weight_result(analysis), rows, contributions_of(names, analysis.quantities))


def weight_result(analysis: WeightAnalysis) -> Result:
    """Arrays and facts of one trial, for figures and claims."""
    signals = {"masses": (analysis.masses, "kg")}
    for name, recording in analysis.recordings.items():
        for key, x, unit in (
            ("added_force", recording.load, "N"),
            ("carried_force", recording.carried, "N"),
            ("belt_velocity", recording.velocity, "m/s"),
            ("belt_acceleration", recording.acceleration, "m/s2"),
        ):
            signals[f"{name}/{key}"] = (recording.segments(x), unit)
    first = next(iter(analysis.recordings.values()))
    signals["onsets"] = (np.array(first.onsets, dtype=int), "samples")
    facts = {
        "filters": list(analysis.recordings),
        "rate_hz": first.rate_hz,
        "carried_kg": first.carried_kg,
        "perturbations": len(first.onsets),
        "marker_lag_s": analysis.marker_lag_s,
    }
    return Result.of(signals, facts)


def usual_weight(results: dict[str, Result]) -> dict[str, Result]:
    """Trials with the weight of the first trial: the thesis's trials, without further weights (kg)."""
    usual_kg = next(iter(results.values())).facts["carried_kg"] if results else 0.0
    return {name: r for name, r in results.items() if r.facts["carried_kg"] == usual_kg}


def shapes(empty: dict[str, Result], weight: dict[str, Result], filter_name: str) -> tuple[list, list]:
    """Correlation and ratio of magnitudes of the mean Fy0 and Delta Fy, condition by condition."""
    alike, sizes = [], []
    for condition in [c for c in weight if c in empty]:
        f, d = (
            results[condition].arrays[f"{filter_name}/added_force"].mean(axis=0)
            for results in (empty, weight)
        )
        alike.append(float(f @ d / np.sqrt((f @ f) * (d @ d))))
        sizes.append(float(np.sqrt((d @ d) / (f @ f))))
    return alike, sizes


def speed_at_peak(results: dict[str, Result], filter_name: str) -> list[float]:
    """Belt speed at the peak of the mean belt-induced force, relative to the peak speed, by condition."""
    shares = []
    for result in results.values():
        force = result.arrays[f"{filter_name}/added_force"].mean(axis=0)
        speed = np.abs(result.arrays[f"{filter_name}/belt_velocity"].mean(axis=0))
        shares.append(float(speed[np.abs(force).argmax()] / speed.max()))
    return shares
