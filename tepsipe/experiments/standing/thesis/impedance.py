"""Ankle impedance of a standing person from responses to perturbations: intrinsic and active torque.

    tau(t) = I phi'' + B phi' + K phi + tau_active(t)

for mean responses relative to unperturbed standing. phi is the ankle angle, tau the torque of both ankles.
In the pre-reflex window, before the first reflex can generate force, tau_active is 0. Later the muscles
contribute; `tepsipe.experiments.standing.muscle_torque` defines models of tau_active, with delays L, D and T.

Linear parameters follow from least squares; L, D and T are selected from a grid. The bootstrap resamples
whole responses, perturbed and unperturbed, with torque and angle of each kept together.

Results of the trials of a standing person, individually and per task: fits, estimates and result files.

Every fit has its own random generator, seeded by the study, the trial and the name of the fit: adding a
pathway or estimator does not change the others.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Annotated

import numpy as np
import scipy

from tepsipe.errors import InputError
from tepsipe.experiments.standing.epochs import StandingEpochs, epochs_result
from tepsipe.experiments.standing.estimates import Fits, StandingFit, generator, of_responses
from tepsipe.experiments.standing.joint_torque import StandingTrial
from tepsipe.experiments.standing.muscle_torque import (
    ACTIVE,
    FILTER_WIDTH_S,
    FREE,
    NONE,
    ActiveOptions,
    MeanResponses,
    MuscleTorque,
)
from tepsipe.experiments.standing.options import StandingEstimator
from tepsipe.experiments.standing.thesis.latency import MuscleLatency
from tepsipe.identification.result import Quantity, symbol_of
from tepsipe.io.result import Result, joined
from tepsipe.signals.epochs import between, ensemble

# signal of the epochs that each linear parameter multiplies
MOTION = {"I": "ankle_dd", "B": "ankle_d", "K": "ankle"}
# delay -> name of its estimate
DELAYS = {"T": "twitch_time", "L": "reflex_lag", "D": "balance_delay"}


def _means(
    responses: StandingEpochs,
    samples: int,
    pathway: str,
    muscles: tuple[str, ...],
    draws: int,
    rng: np.random.Generator,
) -> MeanResponses:
    """Mean responses up to a number of samples: a fit needs none behind its window."""
    count = responses.count
    quiet = next(iter(responses.unperturbed.values())).shape[0]
    weights = np.vstack([np.ones(count), rng.multinomial(count, np.full(count, 1.0 / count), draws)])
    beside = np.vstack([np.ones(quiet), rng.multinomial(quiet, np.full(quiet, 1.0 / quiet), draws)])

    def parts(drawn: np.ndarray, usable: np.ndarray | float = 1.0) -> np.ndarray:
        counted = drawn * usable
        # a resampling without any usable response uses all responses
        counted = np.where(counted.sum(axis=1, keepdims=True) > 0.0, counted, counted[:1])
        return counted / counted.sum(axis=1, keepdims=True)

    of_all = parts(weights), parts(beside)

    def mean(
        perturbed: np.ndarray, unperturbed: np.ndarray, shares: tuple[np.ndarray, np.ndarray] = of_all
    ) -> np.ndarray:
        return shares[0] @ perturbed[:, :samples] - shares[1] @ unperturbed[:, :samples]

    wanted = [*MOTION.values(), f"torque/{pathway}"]
    return MeanResponses(
        responses.time[:samples],
        {key: mean(responses.perturbed[key], responses.unperturbed[key]) for key in wanted},
        {
            muscle: mean(
                responses.drive[..., k],
                responses.unperturbed_drive[..., k],
                (parts(weights, responses.usable[:, k]), parts(beside, responses.unperturbed_usable[:, k])),
            )
            for k, muscle in enumerate(responses.muscles)
            if muscle in muscles
        },
    )


def fit_standing(
    trials: list[StandingEpochs],
    pathway: str,
    estimator: StandingEstimator,
    options: ActiveOptions,
    draws: int,
    rng: np.random.Generator,
) -> StandingFit | str:
    """Fit the responses of one trial, or of several trials with common parameters.

    trials: responses (rad, N·m, uV), each with at least two.
    pathway: torque that is fitted.
    options: delays that are tried, and the actions of the muscles.
    draws: number of resampled sets of responses.
    Returns: parameters, or the reason why this estimator cannot be used for these trials.
    """
    time = trials[0].time
    _check(estimator, float(time[-1]))
    model, muscles, flags = ACTIVE[estimator.active], (), ()
    if model.by_muscle:
        recorded = [set(responses.muscles) for responses in trials]
        muscles = tuple(m for m in options.action if all(m in usable for usable in recorded))
        if not muscles:
            return (
                "expected a muscle that acts at the ankle and has a usable channel in every trial, found none"
            )
        flags = ("muscle-left-out",) * (len(muscles) < len(options.action))
    inside = between(time, -FILTER_WIDTH_S, estimator.window_s)
    samples = int(np.flatnonzero(inside)[-1]) + 1
    inside = inside[:samples]
    means = [_means(responses, samples, pathway, muscles, draws, rng) for responses in trials]
    linear = tuple(name for name in MOTION if name != "I" or estimator.inertia)
    torque = np.concatenate([m.signals[f"torque/{pathway}"][:, inside] for m in means], axis=1)
    regression = _Regression(means, inside, torque, linear, model, options)
    delays, ranges = _selected_delays(regression, muscles)
    if model.by_muscle:
        gains = regression.best(delays, muscles)[0][len(linear) :]
        # gains at their bound of 0 remain there
        muscles = tuple(m for m, gain in zip(muscles, gains, strict=True) if gain > 0.0)
    regressors = regression.regressors(delays, muscles)
    normal = np.einsum("dnp,dnq->dpq", regressors, regressors)
    try:
        parameters = np.linalg.solve(normal, np.einsum("dnp,dn->dp", regressors, torque)[..., None])[..., 0]
    except np.linalg.LinAlgError:
        return (
            f"expected a window that determines I, B, K and the muscles' gains, found "
            f"{estimator.window_s:g} s, which is too short: lengthen it"
        )
    predicted = regressors[0] @ parameters[0]
    intrinsic = regressors[0][:, : len(linear)] @ parameters[0][: len(linear)]
    curves = regression.curves(intrinsic, predicted)
    count = sum(responses.count for responses in trials)
    freedom = count - len(trials)
    quantities = {
        name: replace(of_draws(parameters[:, k], symbol_of(name), count, freedom), flags=flags)
        for k, name in enumerate(linear)
    }
    vaf = 100.0 * (1.0 - float(np.sum((torque[0] - predicted) ** 2) / np.sum(torque[0] ** 2)))
    quantities |= of_responses(curves, vaf)
    if delays:
        share = float(np.abs(predicted - intrinsic).max() / np.abs(intrinsic).max())
        quantities["active_torque_share"] = Quantity(share, "1")
        quantities |= _of_delays(delays, ranges, options)
    gains = parameters[0, len(linear) :].tolist()
    return StandingFit(quantities, curves, count, dict(zip(model.gain_names(muscles), gains, strict=True)))


def of_draws(
    draws: Annotated[np.ndarray, "(1 + draws,)"], unit: str, responses: int, freedom: int
) -> Quantity:
    """An estimate, the first of ``draws`` (``unit``), with the scatter of resampled ones.

    Resampling n responses within each trial underestimates their spread and the tails.
    """
    deviations = np.sqrt(responses / freedom) * (draws[1:] - draws[0])
    tails = scipy.stats.t.ppf(0.975, freedom) / scipy.stats.norm.ppf(0.975)
    low, high = tails * np.percentile(deviations, [2.5, 97.5])
    value, error = float(draws[0]), float(deviations.std())
    return Quantity(value, unit, error, value + float(low), value + float(high), error)


def _check(estimator: StandingEstimator, longest_s: float) -> None:
    """Refuse an unknown model, and a window longer than the responses (s)."""
    known = [name for name, model in ACTIVE.items() if model.regressors is not None]
    if estimator.active not in known:
        raise InputError(
            f"expected an active torque of {', '.join(known)}, found {estimator.active!r}: "
            "correct active in standing.estimators"
        )
    if estimator.window_s > longest_s + 1e-9:
        raise InputError(
            f"expected a window within the responses of {longest_s:g} s, found {estimator.window_s:g} s: "
            "shorten it or lengthen the responses in the configuration"
        )


@dataclass(frozen=True)
class _Regression:
    """Mean responses of all trials in the fitted window, and the model that is fitted to their torque.

    ``torque`` (N·m) has the shape (1 + draws, samples of all trials), ``inside`` selects the window.
    """

    means: list[MeanResponses]
    inside: np.ndarray
    torque: np.ndarray
    linear: tuple[str, ...]
    model: MuscleTorque
    options: ActiveOptions

    def regressors(
        self, delays: dict[str, float], muscles: tuple[str, ...]
    ) -> Annotated[np.ndarray, "(1 + draws, samples of all trials, p)"]:
        """Regressors of the torque."""
        return np.concatenate([self._of(means, delays, muscles) for means in self.means], axis=1)

    def best(
        self, delays: dict[str, float], muscles: tuple[str, ...]
    ) -> tuple[Annotated[np.ndarray, "(p,)"], Annotated[np.ndarray, "(samples of all trials,)", "N·m"]]:
        """Parameters of the responses themselves, without resampling, and their residual torque."""
        columns = self._of(self._themselves, delays, muscles)
        regressors = columns.reshape(-1, columns.shape[-1])
        found = _solve(regressors, self.torque[0], len(self.linear), self.model.by_muscle)
        return found, self.torque[0] - regressors @ found

    def _of(self, means: MeanResponses, delays: dict[str, float], muscles: tuple[str, ...]) -> np.ndarray:
        columns = [means.signals[MOTION[name]] for name in self.linear]
        columns += self.model.regressors(means, delays, self.options, muscles)
        return np.stack([column[:, self.inside] for column in columns], axis=-1)

    @cached_property
    def _themselves(self) -> MeanResponses:
        """The responses themselves, a row for each trial: all delays are tried on them."""
        return MeanResponses.joined([means.of(slice(0, 1)) for means in self.means])

    def curves(self, intrinsic: np.ndarray, predicted: np.ndarray) -> list[dict[str, np.ndarray]]:
        """Torque, its intrinsic and its active part (N·m), and ankle angle (rad), trial by trial."""
        ends = np.cumsum([self.inside.sum()] * len(self.means))[:-1]
        parts = [np.split(x, ends) for x in (self.torque[0], intrinsic, predicted - intrinsic)]
        return [
            {
                "time": means.time[self.inside],
                "torque": torque,
                "intrinsic": passive,
                "active": active,
                "ankle": means.signals["ankle"][0, self.inside],
            }
            for means, torque, passive, active in zip(self.means, *parts, strict=True)
        ]


def _selected_delays(
    regression: _Regression, muscles: tuple[str, ...]
) -> tuple[dict[str, float], dict[str, tuple[float, float]]]:
    """T, L, D (s) with the smallest residuals, and for each the range that its profile does not reject.

    The profile of a delay is the smallest sum of squares S over the others. It rejects a value where S
    exceeds (1 + t^2 / nu) S_min, t Student's 97.5 % quantile at nu = n / (1 + 2 sum rho) - p degrees of
    freedom. rho is the autocorrelation of the residuals, up to its first zero, because neighbouring samples
    of filtered signals, and of model errors, are not independent.
    """
    grid = regression.model.grid(regression.options)
    residuals = [regression.best(delays, muscles)[1] for delays in grid]
    squares = np.array([residual @ residual for residual in residuals])
    best = int(squares.argmin())
    if not grid[best]:
        return grid[best], {}
    parts = np.split(residuals[best], len(regression.means))
    lags = np.sum([np.correlate(x, x, "full")[x.size - 1 :] for x in parts], axis=0)
    ends = np.flatnonzero(lags <= 0.0)
    positive = lags[1 : ends[0] if ends.size else lags.size].sum() / max(lags[0], np.finfo(float).tiny)
    independent = residuals[best].size / (1.0 + 2.0 * positive)
    freedom = max(independent - len(regression.linear) - len(grid[best]), 1.0)
    limit = (1.0 + scipy.special.stdtrit(freedom, 0.975) ** 2 / freedom) * squares[best]
    kept = [delays for delays, s in zip(grid, squares, strict=True) if s <= limit]
    return grid[best], {
        key: (min(delays[key] for delays in kept), max(delays[key] for delays in kept)) for key in grid[best]
    }


def _of_delays(
    delays: dict[str, float], ranges: dict[str, tuple[float, float]], options: ActiveOptions
) -> dict[str, Quantity]:
    """Delays with their ranges; at a bound if only the first or only the last of several is not rejected."""
    found = {}
    for key, value in delays.items():
        (low, high), tried = ranges[key], options.tried[key]
        bound = len(tried) > 1 and low == high and low in (min(tried), max(tried))
        found[DELAYS[key]] = Quantity(value, "s", low=low, high=high, flags=("at-bound",) * bound)
    return found


def _solve(j: np.ndarray, torque: np.ndarray, linear: int, pulling: bool) -> np.ndarray:
    """Least squares; the gains of muscles that only pull are non-negative."""
    if not pulling:
        return np.linalg.lstsq(j, torque, rcond=None)[0]
    # I, B and K may have any sign: each is the difference of two non-negative unknowns
    scale = np.linalg.norm(j, axis=0)
    scale[scale == 0.0] = 1.0
    scaled = j / scale
    both = np.column_stack([scaled, -scaled[:, :linear]])
    unknowns = scipy.optimize.nnls(both, torque)[0]
    solution = unknowns[: j.shape[1]].copy()
    solution[:linear] -= unknowns[j.shape[1] :]
    return solution / scale


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
        stiffness = fit.quantities["K"]
        rows.append([window, stiffness.value, stiffness.low, stiffness.high])
    return np.array(rows).reshape(-1, 4)


def over_sway(responses: StandingEpochs, pathway: str) -> dict[str, float]:
    """Size of the responses relative to unperturbed sway (thesis section 4-2).

    pathway: pathway of the torque.
    Returns: ``angle_over_sway``, ``torque_over_sway``: median over responses of the peak rotation of the
    ankle, and of the peak change of torque, within 0.3 s, relative to the standard deviation in unperturbed
    epochs of the same length. All epochs are relative to their mean just before the onset.
    """
    near = (responses.time >= 0.0) & (responses.time <= 0.3)
    signals = {"angle_over_sway": "ankle", "torque_over_sway": f"torque/{pathway}"}
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

    torques: for the torques that Figure 4-13 shows: as_printed, the pathways of the readings of eq (3-14),
    and recommended, one pathway.
    Returns: arrays of `epochs_result` and the group ``processed`` (in their units).
    """
    signals = {
        f"processed/{key}": (getattr(standing, key).astype(np.float32 if key != "time" else float), unit)
        for key, unit in PROCESSED.items()
    }
    shown = {"recommended": standing.torque[torques["recommended"]]}
    shown["as_printed"] = np.array([standing.torque[pathway] for pathway in torques["as_printed"]])
    for role, torque in shown.items():
        signals[f"processed/torque_{role}"] = (torque.astype(np.float32), "Nm")
    return joined(epochs_result(responses), Result.of(signals, {"torques": torques, "fault": standing.fault}))


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
    signals: dict[str, tuple[np.ndarray, str]] = {}

    def keep(name: str, values: np.ndarray, unit: str) -> None:
        signals[name] = (np.asarray(values, dtype=float), unit)

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
        stiffness, rotation = fit.quantities["K"], fit.quantities["rotation"]
        ends = [stiffness.value, stiffness.low, stiffness.high]
        keep(f"K/{pathway}/{estimator}", np.array(ends), "Nm/rad")
        keep(f"rotation/{pathway}/{estimator}", np.array(rotation.value), "rad")
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
    return Result.of(signals, {**facts, "latencies": onsets})
