"""Results of the trials of a standing person, individually and per task: fits, estimates and result files.

Every fit has its own random generator, seeded by the study, the trial and the name of the fit: adding a
pathway or estimator does not change the others.
"""

from typing import Annotated

import numpy as np

from tepsipe.experiments.standing.epochs import StandingEpochs, epochs_result
from tepsipe.experiments.standing.estimates import Fits, StandingFit, generator, standing_estimates
from tepsipe.experiments.standing.joint_torque import StandingTrial
from tepsipe.experiments.standing.muscle_torque import FREE, NONE, ActiveOptions
from tepsipe.experiments.standing.options import StandingEstimator
from tepsipe.experiments.standing.thesis.impedance import fit_standing
from tepsipe.experiments.standing.thesis.latency import MuscleLatency, latency_estimates
from tepsipe.io.estimates import Estimate
from tepsipe.io.result import Result
from tepsipe.signals.epochs import ensemble
from tepsipe.statistics.uncertainty import Source

# mean responses that are stored to show the coordination of the joints
SHOWN = {"ankle": "rad", "knee": "rad", "shank": "rad", "thigh": "rad", "belt_velocity": "m/s"}
PROCESSED = {
    "time": "s",
    "ankle": "rad",
    "ankle_d": "rad/s",
    "ankle_dd": "rad/s2",
    "belt_velocity": "m/s",
    "f_y": "N",
    "y_cop": "m",
    "onsets_s": "s",
}


def fit_all(
    trials: list[StandingEpochs],
    name: str,
    pathways: list[str],
    estimators: dict[str, StandingEstimator],
    options: ActiveOptions,
    draws: int,
    seed: int,
) -> tuple[Fits, list[str]]:
    """Fit every estimator to every pathway, except those with a free reflex torque.

    trials: trials that share their parameters; those without responses do not count.
    name: name of the trial or task: seed of the resampling, and name in messages.
    estimators: name -> estimator.
    draws, seed: number of resampled sets of responses, and seed of the study.

    Returns:
        fits: (pathway, estimator) -> fit.
        notes: one sentence per unusable estimator.
    """
    usable = [responses for responses in trials if responses.count]
    fits: Fits = {}
    notes: list[str] = []
    if not usable:
        return fits, [f"{name}: expected a trial with usable responses, found none: repeat the trials"]
    for key, estimator in estimators.items():
        for pathway in pathways if estimator.active != FREE else ():
            rng = generator(seed, name, pathway, key)
            fit = fit_standing(usable, pathway, estimator, options, draws, rng)
            if isinstance(fit, StandingFit):
                fits[pathway, key] = fit
            elif pathway == pathways[0]:
                notes.append(f"{name}: estimator {key} left out: {fit}")
    return fits, notes


def fit_estimates(
    name: str,
    fits: Fits,
    critical_stiffness: Annotated[float, "N·m/rad"],
    latencies: list[MuscleLatency],
    stretch: Source | None = None,
) -> list[Estimate]:
    """Tidy rows of a trial or task.

    fits: (pathway, estimator) -> fit.
    latencies: latencies of the muscles with a response.
    stretch: type B of the latencies.
    """
    rows = []
    for (pathway, estimator), fit in fits.items():
        rows += standing_estimates(name, pathway, estimator, fit, critical_stiffness)
    for latency in latencies:
        rows += latency_estimates(name, latency, stretch)
    return rows


def stiffness_by_window(
    trials: list[StandingEpochs],
    pathway: str,
    windows_s: list[float],
    options: ActiveOptions,
    draws: int,
    rng: np.random.Generator,
) -> Annotated[np.ndarray, "(windows, 4)"]:
    """K from windows of several lengths without active torque: longer windows include the effect of reflexes.

    trials: trials that share their parameters; those without responses do not count.
    pathway: torque that is fitted.
    windows_s: lengths from the onset.
    options: as for `fit_standing`.
    draws: number of resampled sets of responses.
    Returns: window (s), K and both ends of its 95 % interval (N·m/rad); empty without a usable trial.
    """
    usable = [responses for responses in trials if responses.count]
    rows = []
    for window in windows_s if usable else []:
        fit = fit_standing(usable, pathway, StandingEstimator(window, False, NONE), options, draws, rng)
        value, _, low, high = fit.interval("K")
        rows.append([window, value, low, high])
    return np.array(rows).reshape(-1, 4)


def over_sway(responses: StandingEpochs, pathway: str) -> dict[str, float]:
    """Size of the responses relative to unperturbed sway (thesis section 4-2).

    pathway: pathway of the torque.
    Returns: ``angle_over_sway``, ``torque_over_sway``: median over responses of the peak ankle velocity,
    and of the peak change of torque, within 0.3 s, relative to the standard deviation in unperturbed
    standing.
    """
    near = (responses.time >= 0.0) & (responses.time <= 0.3)
    signals = {"angle_over_sway": "ankle_d", "torque_over_sway": f"torque/{pathway}"}
    return {
        name: float(
            np.median(np.abs(responses.perturbed[key][:, near]).max(axis=1))
            / responses.unperturbed[key][:, near].std()
        )
        for name, key in signals.items()
        if responses.count
    }


def trial_epochs_result(standing: StandingTrial, responses: StandingEpochs, torques: dict) -> Result:
    """Responses and post-processed signals of one trial.

    torques: role -> pathway, for the torques that Figure 4-13 shows: as_printed and recommended.
    Returns: arrays of `epochs_result` and the group ``processed`` (in their units).
    """
    result = epochs_result(responses)
    arrays, units = dict(result.arrays), dict(result.units)
    for key, unit in PROCESSED.items():
        arrays[f"processed/{key}"] = getattr(standing, key).astype(np.float32 if key != "time" else float)
        units[f"processed/{key}"] = unit
    for role, pathway in torques.items():
        arrays[f"processed/torque_{role}"] = standing.torque[pathway].astype(np.float32)
        units[f"processed/torque_{role}"] = "Nm"
    return Result(arrays, units, {**result.facts, "torques": torques, "fault": standing.fault})


def standing_result(
    trials: list[StandingEpochs],
    fits: Fits,
    recommended: str,
    latencies: list[MuscleLatency],
    facts: dict,
    windows: Annotated[np.ndarray, "(windows, 4)"] | None = None,
) -> Result:
    """Results of a trial, or of the trials of a task, for the report and the figures.

    trials: the trials; those without responses do not count.
    fits: (pathway, estimator) -> fit.
    recommended: pathway whose curves are stored.
    latencies: latencies of the muscles with a response, for a task.
    facts: further facts.
    windows: from `stiffness_by_window` (s, N·m/rad), for a task.
    Returns: ``windows/K`` and ``windows/length``; ``K/<pathway>/<estimator>``: value and 95 % interval;
    ``rotation/...`` of the ankle; ``mean/<signal>``: mean response per trial; ``curve/<estimator>/<part>``:
    torque, intrinsic and active part per trial; ``latency/<muscle>/...``.
    """
    arrays: dict[str, np.ndarray] = {}
    units: dict[str, str] = {}

    def keep(name: str, values: np.ndarray, unit: str) -> None:
        arrays[name], units[name] = np.asarray(values, dtype=float), unit

    usable = [responses for responses in trials if responses.count]
    if usable:
        keep("mean/time", usable[0].time, "s")
        for key, unit in SHOWN.items():
            keep(f"mean/{key}", np.array([r.perturbed[key].mean(axis=0) for r in usable]), unit)
    if len(usable) == 1:
        for k, muscle in enumerate(usable[0].muscles):
            activity = ensemble(usable[0].drive[usable[0].usable[:, k]][..., k])
            keep(f"activity/{muscle}", np.array([activity.mean, activity.sd]), "uV")
    for (pathway, estimator), fit in fits.items():
        value, _, low, high = fit.interval("K")
        keep(f"K/{pathway}/{estimator}", np.array([value, low, high]), "Nm/rad")
        keep(f"rotation/{pathway}/{estimator}", np.array(fit.rotation_rad), "rad")
        if pathway == recommended:
            for part in ("torque", "intrinsic", "active", "ankle"):
                unit = "rad" if part == "ankle" else "Nm"
                keep(f"curve/{estimator}/{part}", np.array([c[part] for c in fit.curves]), unit)
            keep(f"curve/{estimator}/time", fit.curves[0]["time"], "s")
    if windows is not None:
        keep("windows/length", windows[:, 0], "s")
        keep("windows/K", windows[:, 1:], "Nm/rad")
    for latency in latencies:
        keep(f"latency/{latency.muscle}/time", latency.time, "s")
        keep(f"latency/{latency.muscle}/rectified", latency.rectified, "uV")
    onsets = {
        latency.muscle: {
            detector: {
                "latency_s": onset.latency_s,
                "standard_error_s": onset.standard_error_s,
                "interval_s": onset.interval_s,
                "reason": onset.reason,
            }
            for detector, onset in latency.onsets.items()
        }
        | {"responses": latency.responses}
        for latency in latencies
    }
    return Result(arrays, units, {**facts, "latencies": onsets})
