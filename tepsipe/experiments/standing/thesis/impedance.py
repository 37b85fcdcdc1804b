"""Ankle impedance of a standing person from responses to perturbations: intrinsic and active torque.

    tau(t) = I phi'' + B phi' + K phi + tau_active(t)

for mean responses relative to unperturbed standing. phi is the ankle angle, tau the torque of both ankles.
In the pre-reflex window, before the first reflex can generate force, tau_active is 0. Later the muscles
contribute; `tepsipe.experiments.standing.muscle_torque` has the models of tau_active, with delays L, D and T.

Linear parameters follow from least squares; L, D and T are selected from a grid. The uncertainty is that of
whole responses: perturbed and unperturbed responses are both resampled, torque and angle of each together.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np
import scipy

from tepsipe.errors import InputError
from tepsipe.experiments.standing.epochs import StandingEpochs
from tepsipe.experiments.standing.muscle_torque import (
    ACTIVE,
    FILTER_WIDTH_S,
    ActiveOptions,
    MeanResponses,
)
from tepsipe.io.estimates import Estimate, flagged
from tepsipe.statistics.uncertainty import Budget


@dataclass(frozen=True)
class StandingEstimator:
    """One estimator of parameters from responses.

    Attributes
    ----------
    window_s : float
        Length of the fitted window from the onset (s).
    inertia : bool
        Whether I is estimated; the torque does not contain the inertia of the feet or of the body.
    active : str
        Model of the delayed torque of the muscles, of `tepsipe.experiments.standing.muscle_torque.ACTIVE`.
    """

    window_s: float
    inertia: bool
    active: str


@dataclass(frozen=True)
class StandingFit:
    """Parameters of the ankles, from one trial or from several together.

    Attributes
    ----------
    names : tuple of str
        I (N·m·s²/rad), B (N·m·s/rad), K (N·m/rad), then gains of the active torque.
    parameters : ndarray, shape (1 + draws, p)
        Estimates from the responses (first row), and from resampled ones.
    delays : dict of str to float
        Selected T, L, D (s).
    vaf : float
        VAF of the mean responses in the window (%).
    rotation_rad : float
        Peak-to-peak mean rotation of the ankle in the window, mean over trials (rad).
    active_peak : float
        Peak active torque relative to the peak intrinsic torque in the window (-).
    curves : list of dict of str to ndarray, shape (n,)
        Per trial: ``time`` (s), ``torque``, ``intrinsic``, ``active`` (N·m), ``ankle`` (rad).
    responses : int
        Number of responses (-).
    delay_ranges : dict of str to (float, float)
        Smallest and largest of the values tried for T, L, D (s) that the responses do not reject.
    delays_at_bound : tuple of str
        Those of T, L and D of which all values but the first, or all but the last, are rejected (no unit).
    budget : Budget or None
        Type A and B of the parameters in their order; None if only their scatter is known.
    flags : tuple of str
        Checks that the parameters failed (no unit).
    windows : ndarray, shape (w, 3), or None
        Window (s), B and K by it, where the estimator tries several.
    """

    names: tuple[str, ...]
    parameters: np.ndarray
    delays: dict[str, float]
    vaf: float
    rotation_rad: float
    active_peak: float
    curves: list[dict[str, np.ndarray]]
    responses: int
    delay_ranges: dict[str, tuple[float, float]] = field(default_factory=dict)
    delays_at_bound: tuple[str, ...] = ()
    budget: Budget | None = None
    flags: tuple[str, ...] = ()
    windows: np.ndarray | None = None

    def interval(self, name: str) -> tuple[float, float, float, float]:
        """Value, standard error, and both ends of the 95 % interval of a parameter (its unit)."""
        if self.budget is not None:
            k = self.names.index(name)
            low, high = self.budget.interval(self.parameters[0])
            return float(self.parameters[0, k]), float(self.budget.combined[k]), float(low[k]), float(high[k])
        draws = self.parameters[:, self.names.index(name)]
        # resampling n responses within each trial underestimates their spread and the tails
        n, freedom = self.responses, self.responses - len(self.curves)
        deviations = np.sqrt(n / freedom) * (draws[1:] - draws[0])
        tails = scipy.stats.t.ppf(0.975, freedom) / scipy.stats.norm.ppf(0.975)
        low, high = tails * np.percentile(deviations, [2.5, 97.5])
        value = float(draws[0])
        return value, float(deviations.std()), value + float(low), value + float(high)


UNITS = {"I": "Nms2/rad", "B": "Nms/rad", "K": "Nm/rad"}
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
        # a resampling without a usable response uses all of them
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

    Parameters
    ----------
    trials : list of StandingEpochs
        Responses (rad, N·m, uV), each with at least two.
    pathway : str
        Torque that is fitted.
    estimator : StandingEstimator
        Window (s) and model.
    options : ActiveOptions
        Delays that are tried (s), and the actions of the muscles.
    draws : int
        Number of resampled sets of responses (-).
    rng : numpy.random.Generator
        Draws them, identically for every estimator with a generator in the same state.

    Returns
    -------
    StandingFit or str
        Parameters, or the reason why this estimator cannot be used for these trials.

    Raises
    ------
    InputError
        If the model is unknown, or the window is longer than the responses.
    """
    known = [name for name, model in ACTIVE.items() if model.regressors is not None]
    if estimator.active not in known:
        raise InputError(
            f"expected an active torque of {', '.join(known)}, found {estimator.active!r}: "
            "correct active in standing.estimators"
        )
    time = trials[0].time
    if estimator.window_s > time[-1] + 1e-9:
        raise InputError(
            f"expected a window within the responses of {time[-1]:g} s, found {estimator.window_s:g} s: "
            "shorten it or lengthen the responses in the configuration"
        )
    model, muscles = ACTIVE[estimator.active], ()
    if model.by_muscle:
        shared = [set(responses.muscles) for responses in trials]
        muscles = tuple(m for m in options.action if all(m in own for own in shared))
        if not muscles:
            return (
                "expected a muscle that acts at the ankle and has a usable channel in every trial, found none"
            )
    means = [_means(responses, pathway, muscles, draws, rng) for responses in trials]
    inside = (time >= -FILTER_WIDTH_S) & (time <= estimator.window_s)
    linear = [name for name in MOTION if name != "I" or estimator.inertia]
    torque = np.concatenate([m.signals[f"torque/{pathway}"][:, inside] for m in means], axis=1)

    def regressors(delays: dict[str, float], rows: slice, kept: tuple[str, ...]) -> np.ndarray:
        """Shape (rows, samples of all trials, p)."""
        parts = []
        for m in means:
            part = MeanResponses(
                m.time,
                {key: x[rows] for key, x in m.signals.items()},
                {key: x[rows] for key, x in m.drive.items()},
            )
            columns = [part.signals[MOTION[name]] for name in linear]
            columns += model.regressors(part, delays, options, kept)
            parts.append(np.stack(columns, axis=-1)[:, inside])
        return np.concatenate(parts, axis=1)

    def left_by(delays: dict[str, float]) -> np.ndarray:
        j = regressors(delays, slice(0, 1), muscles)[0]
        return torque[0] - j @ _solve(j, torque[0], len(linear), model.by_muscle)

    delays, ranges = _selected(model.grid(options), left_by, len(means), len(linear))
    if model.by_muscle:
        first = _solve(regressors(delays, slice(0, 1), muscles)[0], torque[0], len(linear), True)
        # gains at their bound of 0 remain there
        muscles = tuple(m for m, gain in zip(muscles, first[len(linear) :], strict=True) if gain > 0.0)
    j = regressors(delays, slice(None), muscles)
    normal = np.einsum("dnp,dnq->dpq", j, j)
    try:
        parameters = np.linalg.solve(normal, np.einsum("dnp,dn->dp", j, torque)[..., None])[..., 0]
    except np.linalg.LinAlgError:
        return (
            f"expected a window that determines I, B, K and the muscles' gains, found "
            f"{estimator.window_s:g} s, which is too short: lengthen it"
        )
    predicted = j[0] @ parameters[0]
    intrinsic = j[0][:, : len(linear)] @ parameters[0][: len(linear)]
    ends = np.cumsum([inside.sum()] * len(means))[:-1]
    parts = [np.split(x, ends) for x in (torque[0], intrinsic, predicted - intrinsic)]
    angles = [m.signals["ankle"][0, inside] for m in means]
    return StandingFit(
        names=(*linear, *model.gains_of(muscles)),
        parameters=parameters,
        delays=delays,
        vaf=100.0 * (1.0 - float(np.sum((torque[0] - predicted) ** 2) / np.sum(torque[0] ** 2))),
        rotation_rad=float(np.mean([np.ptp(angle) for angle in angles])),
        active_peak=float(np.abs(predicted - intrinsic).max() / np.abs(intrinsic).max()),
        curves=[
            {"time": time[inside], "torque": a, "intrinsic": b, "active": c, "ankle": angle}
            for a, b, c, angle in zip(*parts, angles, strict=True)
        ],
        responses=sum(responses.count for responses in trials),
        delay_ranges=ranges,
        delays_at_bound=_at_bound(ranges, options),
    )


def _selected(
    grid: list[dict[str, float]], left_by: Callable[[dict[str, float]], np.ndarray], trials: int, linear: int
) -> tuple[dict[str, float], dict[str, tuple[float, float]]]:
    """T, L, D (s) with the smallest residuals, and for each the range that its profile does not reject.

    The profile of a delay is the smallest sum of squares S over the others. It rejects a value where S
    exceeds (1 + t^2 / nu) S_min, t Student's 97.5 % quantile at nu = n / (1 + 2 sum rho) - p degrees of
    freedom. rho is the autocorrelation of the residuals, up to its first zero: neighbouring samples of
    filtered signals, and of what the model lacks, say the same.
    """
    lefts = [left_by(delays) for delays in grid]
    squares = np.array([left @ left for left in lefts])
    best = int(squares.argmin())
    if not grid[best]:
        return grid[best], {}
    parts = np.split(lefts[best], trials)
    lags = np.sum([np.correlate(x, x, "full")[x.size - 1 :] for x in parts], axis=0)
    ends = np.flatnonzero(lags <= 0.0)
    positive = lags[1 : ends[0] if ends.size else lags.size].sum() / max(lags[0], np.finfo(float).tiny)
    freedom = max(lefts[best].size / (1.0 + 2.0 * positive) - linear - len(grid[best]), 1.0)
    limit = (1.0 + scipy.special.stdtrit(freedom, 0.975) ** 2 / freedom) * squares[best]
    kept = [delays for delays, s in zip(grid, squares, strict=True) if s <= limit]
    return grid[best], {
        key: (min(delays[key] for delays in kept), max(delays[key] for delays in kept)) for key in grid[best]
    }


def _at_bound(ranges: dict[str, tuple[float, float]], options: ActiveOptions) -> tuple[str, ...]:
    """Those of T, L and D of which only the first or the last of several values tried is not rejected."""
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
    found = scipy.optimize.nnls(both, torque)[0]
    solution = found[: j.shape[1]].copy()
    solution[:linear] -= found[j.shape[1] :]
    return solution / scale


def standing_estimates(
    condition: str, pathway: str, estimator: str, fit: StandingFit, critical_stiffness: float
) -> list[Estimate]:
    """Tidy rows: I, B, K, K over m g h, rotation, VAF, and the selected delays (units in the rows).

    ``critical_stiffness`` is m g h (N·m/rad).
    """
    about = ("standing", condition, pathway, estimator)
    n = fit.responses
    names = {"T": "twitch_time", "L": "reflex_delay", "D": "balance_delay"}
    rows = []

    def row(quantity: str, unit: str, name: str, scale: float) -> Estimate:
        value, error, low, high = (scale * x for x in fit.interval(name))
        found = Estimate(*about, quantity, unit, value, error, low, high, n_perturbations=n)
        if fit.budget is not None:
            k = fit.names.index(name)
            u_a, u_b = scale * float(fit.budget.type_a[k]), scale * float(fit.budget.type_b[k])
            found = replace(found, u_type_a=u_a, u_type_b=u_b)
        return flagged([found], *fit.flags)[0]

    for name in fit.names:
        if name in UNITS:
            rows.append(row(name, UNITS[name], name, 1.0))
        if name == "K":
            rows.append(row("K_over_mgh", "1", name, 1.0 / critical_stiffness))
    plain = {
        "rotation": ("rad", fit.rotation_rad),
        "VAF_response": ("%", fit.vaf),
    }
    if fit.delays:
        plain["active_torque_share"] = ("1", fit.active_peak)
    rows += [Estimate(*about, key, unit, float(v), n_perturbations=n) for key, (unit, v) in plain.items()]
    for key, value in fit.delays.items():
        low, high = fit.delay_ranges[key]
        own = Estimate(*about, names[key], "s", value, ci_low=low, ci_high=high, n_perturbations=n)
        rows += flagged([own], *["at-bound"] * (key in fit.delays_at_bound))
    return rows
