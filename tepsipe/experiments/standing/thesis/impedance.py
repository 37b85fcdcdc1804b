"""Ankle impedance of a standing person from responses to perturbations: intrinsic and active torque.

    tau(t) = I phi'' + B phi' + K phi + tau_active(t)

for mean responses relative to unperturbed standing. phi is the ankle angle, tau the torque of both ankles.
In the pre-reflex window, before the first reflex can generate force, tau_active is 0. Later the muscles
contribute; `tepsipe.experiments.standing.muscle_torque` defines models of tau_active, with delays L, D and T.

Linear parameters follow from least squares; L, D and T are selected from a grid. The bootstrap resamples
whole responses, perturbed and unperturbed, with torque and angle of each kept together.
"""

from dataclasses import dataclass

import numpy as np
import scipy

from tepsipe.errors import InputError
from tepsipe.experiments.standing.epochs import StandingEpochs
from tepsipe.experiments.standing.estimates import StandingFit
from tepsipe.experiments.standing.muscle_torque import (
    ACTIVE,
    FILTER_WIDTH_S,
    ActiveOptions,
    MeanResponses,
    MuscleTorque,
)
from tepsipe.experiments.standing.options import StandingEstimator

# signal of the epochs that each linear parameter multiplies
MOTION = {"I": "ankle_dd", "B": "ankle_d", "K": "ankle"}


def _means(
    responses: StandingEpochs, pathway: str, muscles: tuple[str, ...], draws: int, rng: np.random.Generator
) -> MeanResponses:
    count = responses.count
    quiet = next(iter(responses.unperturbed.values())).shape[0]
    weights = np.vstack([np.ones(count), rng.multinomial(count, np.full(count, 1.0 / count), draws)])
    beside = np.vstack([np.ones(quiet), rng.multinomial(quiet, np.full(quiet, 1.0 / quiet), draws)])

    def parts(drawn: np.ndarray, usable: np.ndarray | float) -> np.ndarray:
        counted = drawn * usable
        # a resampling without any usable response uses all responses
        counted = np.where(counted.sum(axis=1, keepdims=True) > 0.0, counted, counted[:1])
        return counted / counted.sum(axis=1, keepdims=True)

    def mean(
        perturbed: np.ndarray,
        unperturbed: np.ndarray,
        usable: np.ndarray | float = 1.0,
        unperturbed_usable: np.ndarray | float = 1.0,
    ) -> np.ndarray:
        return parts(weights, usable) @ perturbed - parts(beside, unperturbed_usable) @ unperturbed

    wanted = [*MOTION.values(), f"torque/{pathway}"]
    return MeanResponses(
        responses.time,
        {key: mean(responses.perturbed[key], responses.unperturbed[key]) for key in wanted},
        {
            muscle: mean(
                responses.drive[..., k],
                responses.unperturbed_drive[..., k],
                responses.usable[:, k],
                responses.unperturbed_usable[:, k],
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
    means = [_means(responses, pathway, muscles, draws, rng) for responses in trials]
    inside = (time >= -FILTER_WIDTH_S) & (time <= estimator.window_s)
    linear = tuple(name for name in MOTION if name != "I" or estimator.inertia)
    torque = np.concatenate([m.signals[f"torque/{pathway}"][:, inside] for m in means], axis=1)
    regression = _Regression(means, inside, torque, linear, model, options)
    delays, ranges = _selected_delays(regression, muscles)
    if model.by_muscle:
        gains = regression.best(delays, muscles)[len(linear) :]
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
    return StandingFit(
        names=(*linear, *model.gain_names(muscles)),
        parameters=parameters,
        delays=delays,
        vaf=100.0 * (1.0 - float(np.sum((torque[0] - predicted) ** 2) / np.sum(torque[0] ** 2))),
        rotation_rad=float(np.mean([np.ptp(curve["ankle"]) for curve in curves])),
        active_peak=float(np.abs(predicted - intrinsic).max() / np.abs(intrinsic).max()),
        curves=curves,
        responses=sum(responses.count for responses in trials),
        delay_ranges=ranges,
        delays_at_bound=_at_bound(ranges, options),
        flags=flags,
    )


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
        self, delays: dict[str, float], muscles: tuple[str, ...], rows: slice = slice(None)
    ) -> np.ndarray:
        """Regressors of the torque, shape (rows, samples of all trials, p)."""
        parts = []
        for means in self.means:
            part = means.of(rows)
            columns = [part.signals[MOTION[name]] for name in self.linear]
            columns += self.model.regressors(part, delays, self.options, muscles)
            parts.append(np.stack(columns, axis=-1)[:, self.inside])
        return np.concatenate(parts, axis=1)

    def best(self, delays: dict[str, float], muscles: tuple[str, ...]) -> np.ndarray:
        """Parameters of the responses themselves, without resampling, shape (p,)."""
        regressors = self.regressors(delays, muscles, slice(0, 1))[0]
        return _solve(regressors, self.torque[0], len(self.linear), self.model.by_muscle)

    def residual(self, delays: dict[str, float], muscles: tuple[str, ...]) -> np.ndarray:
        """Residual torque of the responses themselves (N·m), shape (samples of all trials,)."""
        regressors = self.regressors(delays, muscles, slice(0, 1))[0]
        return self.torque[0] - regressors @ self.best(delays, muscles)

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
    residuals = [regression.residual(delays, muscles) for delays in grid]
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


def _at_bound(ranges: dict[str, tuple[float, float]], options: ActiveOptions) -> tuple[str, ...]:
    """Parameters among T, L and D of whose values only the first or only the last is not rejected."""
    tried = options.tried
    return tuple(
        key
        for key, (low, high) in ranges.items()
        if len(tried[key]) > 1 and low == high and low in (min(tried[key]), max(tried[key]))
    )


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
