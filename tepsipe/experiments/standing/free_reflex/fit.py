"""Ankle impedance of a standing person with a reflex torque of unknown shape: generalised least squares.

    tau(t) = B phi'(t) + K phi(t) + r(t) + d(t) + s(t)

for the mean response of every trial. r is the torque of reflexes, free from its earliest instant t_r on: an
integrated Wiener process, whose size grows with the belt's speed. d is the error of the rig's model, a smooth
error of a given share of the torque. s is sway; its covariance is taken from unperturbed standing, after
B phi' + K phi, and divided by the number of responses. The window may then end before or after the first
reflex: K and B depend little on it.

Noise of the cameras in phi and phi' would attenuate B and K (errors in variables). The encoder of the belt
has no such noise, and the belt is what turns the ankle: its velocity and displacement are the instruments of
`tepsipe.identification.regression.generalised`. They remove most of the noise from the regressors. The rest
is subtracted: the mean of n responses has 1 / n of the moments of unperturbed standing. These contain sway as
well, which must go, too: balance relates torque and angle of sway, not B and K, and only the pulse is the
same in all responses.

The covariance of r includes the low-pass of all signals, which spreads a part of r to before t_r.

Type A is the scatter between trials, or between responses if there are fewer than 4 trials, by the jackknife
of the corrected estimate. Type B are the sources of `tepsipe.experiments.standing.free_reflex.free_body`,
draws of the treadmill model's constants, what it leaves under a weight, the choice of window and t_r, and the
part of d that all trials of a person share. The contribution of soft tissue also uses the responses: the
apparent centre of the joint after a pulse less the centre in quiet sway, over the shift that a metre of
tissue motion causes.

Effect of each source of uncertainty on B and K of a fit of mean responses, and on differences of fits.

Effects are of first order, with the weights of the fit kept. Signs, draws and single responses are kept as
well, so that errors common to two fits of the same trials cancel in their difference.
"""

from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated

import numpy as np

from tepsipe.errors import InputError
from tepsipe.experiments.standing.free_reflex.broadband import BroadbandEpochs, by_recording
from tepsipe.experiments.standing.free_reflex.reflex import (
    YIELD,
    YIELD_SHARE,
    Change,
    ReflexEstimate,
    estimate_reflex,
    yielding,
)
from tepsipe.experiments.standing.options import FreeReflexOptions
from tepsipe.identification.consistency import welch
from tepsipe.identification.regression.generalised import (
    GeneralisedFit,
    Record,
    generalised_least_squares,
    integrated_wiener,
    sensitivity,
    squared_exponential,
)
from tepsipe.signals.epochs import between, margin_s
from tepsipe.signals.filters import butterworth_lowpass
from tepsipe.statistics.uncertainty import Budget, Source, root_of_draws

TORQUE, ANKLE, ANKLE_D = range(3)
# signals that B and K multiply
REGRESSORS = [ANKLE_D, ANKLE]
TREADMILL, RESIDUAL = "treadmill_model", "treadmill_residual"


@dataclass(frozen=True)
class FitErrors:
    """Errors of B and K by source."""

    parameters: Annotated[np.ndarray, "(2,)"]
    """B (N·m·s/rad) and K (N·m/rad)."""
    scatter: Annotated[np.ndarray, "(responses, 2)"]
    """Share of every response in the error, scaled so that the sum of squares is the variance."""
    freedom: float
    """Its degrees of freedom."""
    contributions: dict[str, np.ndarray]
    """Source -> root of its covariance, shape (k, 2)."""
    discrepancy: Annotated[np.ndarray, "(trials, n, 2)"]
    """For each trial, root of the covariance by a misfit of the rig's model of the size of its largest
    torque."""

    def minus(self, other: "FitErrors") -> "FitErrors":
        """Errors of the difference from another fit of the same trials and sources."""
        n = max(self.discrepancy.shape[1], other.discrepancy.shape[1])
        nothing = np.zeros((1, 2))
        return FitErrors(
            self.parameters - other.parameters,
            self.scatter - other.scatter,
            self.freedom,
            {
                name: self.contributions.get(name, nothing) - other.contributions.get(name, nothing)
                for name in dict.fromkeys([*self.contributions, *other.contributions])
            },
            _padded(self.discrepancy, n) - _padded(other.discrepancy, n),
        )

    def variance(self, discrepancy: float) -> np.ndarray:
        """Variance by scatter, sources, and a share of misfit that is common to all trials, shape (2,).

        In squared units of B and K.
        """
        rows = [self.scatter, *self.contributions.values(), discrepancy * self.discrepancy.sum(axis=0)]
        return sum((x**2).sum(axis=0) for x in rows)


def _padded(rows: np.ndarray, most: int) -> np.ndarray:
    """Root of a covariance for every trial, shape (trials, n, 2), padded with rows of 0 to ``most`` rows.

    Roots of a process in windows that begin together are Cholesky factors: row k belongs to the same deviate.
    """
    return np.pad(rows, ((0, 0), (0, most - rows.shape[1]), (0, 0)))


def fit_errors(
    trials: list[BroadbandEpochs],
    fit: GeneralisedFit,
    records: list[Record],
    inside: np.ndarray,
    sources: list[Source],
    discrepancy_s: float,
) -> FitErrors:
    """Errors of a fit.

    fit, records: the fit of their means, and what it was fitted to.
    inside: samples of the window.
    sources: uncertain constants; sources that move no signal are ignored.
    discrepancy_s: length of the misfit.
    """
    responses = sum(trial.count for trial in trials)
    freedom = max(1.0, float(responses - len(trials)))
    return FitErrors(
        fit.parameters,
        np.sqrt(responses / freedom) * _of_responses(trials, fit, records, inside),
        freedom,
        _of_signals(trials, fit, records, inside, sources)
        | _of_treadmill(trials, fit, records, inside)
        | _of_misfit(trials, fit, records, inside),
        _of_discrepancy(fit, records, trials[0].time[inside], discrepancy_s),
    )


def _of_responses(
    trials: list[BroadbandEpochs], fit: GeneralisedFit, records: list[Record], inside: np.ndarray
) -> np.ndarray:
    """Change of B and K by every response's deviation from the mean of its trial, shape (responses, 2)."""
    changes = []
    for k, trial in enumerate(trials):
        around = (trial.perturbed[:, inside] - trial.perturbed[:, inside].mean(axis=0)) / trial.count
        target, regressors = (_alone(x, k, trials) for x in (around[..., TORQUE], around[..., REGRESSORS]))
        changes.append(sensitivity(fit, records, target, regressors))
    return np.concatenate(changes)


def _alone(change: np.ndarray, k: int, trials: list) -> list[np.ndarray | None]:
    """Changes of every trial, of which only trial ``k`` changes."""
    return [change if j == k else None for j in range(len(trials))]


def _of_signals(
    trials: list[BroadbandEpochs],
    fit: GeneralisedFit,
    records: list[Record],
    inside: np.ndarray,
    sources: list[Source],
) -> dict[str, np.ndarray]:
    """Signed contributions to B and K of the sources that move the signals, each of shape (1, 2)."""
    contributions = {}
    for source in sources:
        if source.name in trials[0].slopes:
            errors = [source.standard_uncertainty * trial.slopes[source.name][inside] for trial in trials]
            changes = sensitivity(
                fit, records, [m[:, TORQUE] for m in errors], [m[:, REGRESSORS] for m in errors]
            )
            contributions[source.name] = changes[None]
    return contributions


def _of_treadmill(
    trials: list[BroadbandEpochs], fit: GeneralisedFit, records: list[Record], inside: np.ndarray
) -> dict[str, np.ndarray]:
    """Root of the covariance of B and K by the calibration of the treadmill model, if it has draws."""
    shared = min((len(trial.draws) for trial in trials), default=0)
    if shared < 2:
        return {}
    errors = sensitivity(fit, records, [trial.draws[:shared, inside] for trial in trials])
    return {TREADMILL: root_of_draws(errors)}


def _of_misfit(
    trials: list[BroadbandEpochs], fit: GeneralisedFit, records: list[Record], inside: np.ndarray
) -> dict[str, np.ndarray]:
    """Effect on B and K of what the treadmill model leaves under a weight, beyond its noise, shape (1, 2)."""
    if any(trial.misfit is None for trial in trials):
        return {}
    shown = [trial.misfit[:, inside] for trial in trials]
    effect = sensitivity(fit, records, [torque[0] for torque in shown])
    noise = 0.0
    for k, torque in enumerate(shown):
        noise = noise + (sensitivity(fit, records, _alone(torque[1:], k, trials)) ** 2).sum(axis=0)
    return {RESIDUAL: (np.sign(effect) * np.sqrt(np.maximum(effect**2 - noise, 0.0)))[None]}


def _of_discrepancy(
    fit: GeneralisedFit, records: list[Record], time: np.ndarray, length_s: float
) -> np.ndarray:
    """Root of the covariance of B and K by a smooth misfit of the largest torque of each trial."""
    smooth = squared_exponential(time, length_s) + 1e-6 * np.eye(time.size)
    shapes = np.linalg.cholesky(smooth).T
    roots = []
    for k, record in enumerate(records):
        peak = record.target[np.abs(record.target).argmax()]
        roots.append(sensitivity(fit, records, _alone(peak * shapes, k, records)))
    return np.stack(roots)


QUANTITIES = ("B", "K")
# before the onset the zero-lag low-pass already shows the response (s)
FILTER_WIDTH_S = 0.03
# step between the starts of overlapping stretches of quiet standing (s)
QUIET_STEP_S = 0.02
# covariance of sway and parameters are estimated in turn
ROUNDS = 3
# margin on both sides of an epoch, beyond which the low-pass has no effect on it (s)
BEYOND_S = 0.1
# fewest trials whose scatter is Type A
FEWEST_TRIALS = 4
# sources that this module adds to the sources of the signals
WINDOW, REFLEX_ONSET, DISCREPANCY = "window_s", "reflex_onset_s", "model_discrepancy"
# error of the rig's model in one trial alone, not common to the others
OWN_DISCREPANCY = "model_discrepancy_of_trial"


@dataclass(frozen=True)
class FreeReflexFit:
    """B and K of one trial or of several together."""

    parameters: Annotated[np.ndarray, "(2,)"]
    """B (N·m·s/rad) and K (N·m/rad)."""
    budget: Budget
    """Uncertainty of B and K."""
    errors: FitErrors
    """Effect of each source on B and K with its sign, for differences from other fits."""
    window_s: float
    reflex_onset_s: float
    windows: Annotated[np.ndarray, "(w, 3)"]
    """Window (s), B and K by it, within ``windows_s`` of the options."""
    windows_chance: Annotated[np.ndarray, "(w, 2)"]
    """Standard uncertainty of their difference from ``parameters`` by scatter and sources."""
    curves: list[dict[str, np.ndarray]]
    """Per trial: ``time`` (s), ``torque``, ``intrinsic``, ``active`` (N·m), ``ankle`` (rad)."""
    vaf: Annotated[float, "%"]
    """VAF of the mean responses by B and K alone, before t_r."""
    noise_share: float
    """Largest share of noise in the information on B and K, which was subtracted."""
    reflex: ReflexEstimate
    """What B and K leave of the whole responses."""
    apart: tuple["ApartFromOthers", ...] = ()
    """Every recording against the others, if there are several."""


def fit_free_reflex(
    trials: list[BroadbandEpochs],
    window_s: float,
    options: FreeReflexOptions,
    sources: list[Source],
    reflex_onset_s: float | None = None,
) -> FreeReflexFit:
    """Fit the responses of one trial, or of several trials with common parameters.

    window_s: length of the fitted window from the onset.
    sources: uncertain constants (unit in the name); sources that move no signal of the trials are ignored.
    reflex_onset_s: t_r (s); from the options if left out.
    Returns: B, K and their budget.
    """
    time = trials[0].time
    if not 0.0 < window_s <= time[-1] + margin_s(time):
        raise InputError(
            f"expected a window of at most {time[-1]:g} s for a free reflex torque, found {window_s:g} s: "
            "shorten it in standing.estimators"
        )
    onset = options.reflex_onset_s if reflex_onset_s is None else reflex_onset_s
    fit, records, errors = fit_with_errors(trials, window_s, onset, options, sources)
    inside = inside_window(time, window_s)
    by_source = {source.name: source.standard_uncertainty for source in sources}
    contributions = dict(errors.contributions)
    tried, chance, contributions[WINDOW] = _windows(trials, inside, errors, options, sources, onset)
    if DISCREPANCY in by_source:
        contributions[DISCREPANCY] = by_source[DISCREPANCY] * errors.discrepancy.sum(axis=0)
    budget = Budget(
        *_scatter(fit, trials, inside), contributions, {source.name: source.freedom for source in sources}
    )
    between = _between_recordings(fit, trials)
    yielded = _yielded(trials, fit, records, inside) if YIELD in by_source else None
    reflex = estimate_reflex(
        time,
        np.stack([trial.perturbed.mean(axis=0) for trial in trials]),
        fit.parameters,
        [_responses_changed(trials, errors), *([] if between is None else [Change(between)])],
        budget.freedom_a,
        _changed(trials, records, inside, errors, contributions, options, by_source)
        | ({YIELD: yielded.times(by_source[YIELD])} if yielded else {}),
        budget.freedom,
        yielded.times(YIELD_SHARE) if yielded else None,
    )
    apart = compared_recordings(trials, fit, errors, options.discrepancy)
    curves = [_curve(record, fit.parameters, time[inside]) for record in records]
    before = time[inside] <= onset
    return FreeReflexFit(
        parameters=fit.parameters,
        budget=budget,
        errors=errors,
        window_s=window_s,
        reflex_onset_s=onset,
        windows=tried,
        windows_chance=chance,
        curves=curves,
        vaf=_vaf(curves, before),
        noise_share=fit.noise_share,
        reflex=reflex,
        apart=apart,
    )


def inside_window(time: np.ndarray, window_s: float) -> np.ndarray:
    """Samples of the window (s), including those to which the filter spreads the onset, shape (n,)."""
    return between(time, -FILTER_WIDTH_S, window_s)


def _sway(trials: list[BroadbandEpochs], inside: np.ndarray) -> np.ndarray:
    """Overlapping stretches of quiet standing as long as the window, baseline-corrected as the responses."""
    first, last = np.flatnonzero(inside)[[0, -1]].tolist()
    step = max(1, round(QUIET_STEP_S / (trials[0].time[1] - trials[0].time[0])))
    once = [trials[own[0]] for own in by_recording(trials)]  # both directions share their quiet standing
    stretches = [trial.quiet_stretches(first, last, step) for trial in once]
    return stretches[0] if len(stretches) == 1 else np.concatenate(stretches)


def sway_moments(trials: list[BroadbandEpochs], inside: np.ndarray) -> np.ndarray:
    """Moments of sway and noise: mean products of the signals at all pairs of instants, (3, 3, n, n)."""
    sway = _sway(trials, inside)
    flat = np.moveaxis(sway, 2, 1).reshape(len(sway), -1)
    n = sway.shape[1]
    return np.moveaxis((flat.T @ flat / len(sway)).reshape(3, n, 3, n), 2, 1)


def _fitted(
    trials: list[BroadbandEpochs],
    inside: np.ndarray,
    moments: np.ndarray,
    onset_s: float,
    options: FreeReflexOptions,
) -> tuple[GeneralisedFit, list[Record]]:
    """Best B and K in a window, for an onset of reflexes, and the records; ``moments`` of `sway_moments`."""
    time = trials[0].time[inside]
    means = [trial.perturbed[:, inside].mean(axis=0) for trial in trials]
    smooth = squared_exponential(time, options.discrepancy_s)
    unit = options.reflex_Nm**2 / (options.reflex_after_s**3 / 3.0)
    first = trials[0]
    free = unit * reflex_covariance(first.time, onset_s, first.cutoff_hz, first.order)
    free = free[np.ix_(inside, inside)]
    # what does not change with the parameters, of every trial: misfit, reflex, noise
    smooth += 1e-6 * np.eye(time.size)
    misfits = [_size(mean[:, TORQUE], options) ** 2 * smooth for mean in means]
    reflexes = [(trial.peak_m_per_s / options.reflex_speed_m_per_s) ** 2 * free for trial in trials]
    noise = {count: noise_of_mean(moments, count) for count in {trial.count for trial in trials}}
    parameters = np.zeros(2)
    for _ in range(ROUNDS):
        combination = np.zeros(3)
        combination[[TORQUE, ANKLE_D, ANKLE]] = 1.0, *-parameters
        covariance = np.tensordot(np.outer(combination, combination), moments, 2)
        records = [
            Record(
                target=mean[:, TORQUE],
                regressors=mean[:, REGRESSORS],
                covariance=covariance / trial.count + misfit + reflex,
                instruments=trial.belt[inside],
                noise=noise[trial.count],
            )
            for trial, mean, misfit, reflex in zip(trials, means, misfits, reflexes, strict=True)
        ]
        fit = generalised_least_squares(records)
        parameters = fit.parameters
    return fit, records


def noise_of_mean(
    moments: Annotated[np.ndarray, "(3, 3, n, n)"], responses: float
) -> tuple[np.ndarray, np.ndarray]:
    """Moments of the noise in a mean of so many responses, for `Record`.

    moments: moments of single responses, from `sway_moments` (products of N·m, rad, rad/s).
    Returns: moments of the regressors, and of the regressors with the torque.
    """
    return moments[np.ix_(REGRESSORS, REGRESSORS)] / responses, moments[REGRESSORS, TORQUE] / responses


def reflex_covariance(
    time: Annotated[np.ndarray, "(n,)", "s"], onset_s: float, cutoff_hz: float, order: int
) -> Annotated[np.ndarray, "(n, n)", "s³"]:
    """Covariance of a reflex torque of unit intensity behind a zero-lag low-pass; do not modify it.

    time: regular instants.
    """
    rate_hz = float(round(1.0 / np.diff(time).mean(), 6))
    return _reflex_covariance(float(time[0]), time.size, rate_hz, onset_s, cutoff_hz, order)


# all windows of all fits have the same
@lru_cache(maxsize=64)
def _reflex_covariance(
    start_s: float, samples: int, rate_hz: float, onset_s: float, cutoff_hz: float, order: int
) -> np.ndarray:
    margin = round(BEYOND_S * rate_hz)
    wide = start_s + np.arange(-margin, samples + margin) / rate_hz
    # the low-pass as a matrix
    passed = butterworth_lowpass(np.eye(wide.size), rate_hz, cutoff_hz, order)[margin:-margin]
    return passed @ integrated_wiener(wide, onset_s) @ passed.T


def _size(torque: np.ndarray, options: FreeReflexOptions) -> float:
    """Standard deviation of d (N·m)."""
    return options.discrepancy * float(np.abs(torque).max())


def fit_with_errors(
    trials: list[BroadbandEpochs],
    window_s: float,
    onset_s: float,
    options: FreeReflexOptions,
    sources: list[Source],
) -> tuple[GeneralisedFit, list[Record], FitErrors]:
    """Best B and K (N·m·s/rad, N·m/rad) in a window (s) for an onset of reflexes (s), records, and errors."""
    inside = inside_window(trials[0].time, window_s)
    moments = sway_moments(trials, inside)
    fit, records = _fitted(trials, inside, moments, onset_s, options)
    errors = fit_errors(trials, fit, records, inside, sources, options.discrepancy_s)
    for source in sources:
        if source.name == REFLEX_ONSET:
            u = source.standard_uncertainty
            later, earlier = (
                _fitted(trials, inside, moments, onset_s + step, options)[0].parameters for step in (u, -u)
            )
            errors.contributions[REFLEX_ONSET] = 0.5 * (later - earlier)[None]
    return fit, records, errors


def _windows(
    trials: list[BroadbandEpochs],
    inside: np.ndarray,
    chosen: FitErrors,
    options: FreeReflexOptions,
    sources: list[Source],
    onset_s: float,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """B and K by the window, and what makes them differ.

    inside, chosen: samples of the chosen window, and its errors.
    Returns window, B and K every 10 ms, shape (w, 3), the standard uncertainty of their differences from the
    chosen window by chance, shape (w, 2), and the root of the covariance by the choice of the window, (w, 2).
    """
    low, high = options.windows_s
    lengths = np.linspace(low, high, max(2, round((high - low) / 0.01) + 1)).tolist()
    by_length = [
        chosen
        if np.array_equal(inside_window(trials[0].time, w), inside)
        else fit_with_errors(trials, w, onset_s, options, sources)[2]
        for w in lengths
    ]
    differences = np.array([errors.parameters for errors in by_length]) - chosen.parameters
    shared = sum(source.standard_uncertainty for source in sources if source.name == DISCREPANCY)
    variances = np.array([errors.minus(chosen).variance(shared) for errors in by_length])
    tried = np.array([[w, *errors.parameters] for w, errors in zip(lengths, by_length, strict=True)])
    return tried, np.sqrt(variances), effect_of_window(differences, variances, chosen.variance(shared))


def effect_of_window(
    differences: Annotated[np.ndarray, "(w, 2)"],
    variances: Annotated[np.ndarray, "(w, 2)"],
    whole: Annotated[np.ndarray, "(2,)"],
) -> Annotated[np.ndarray, "(w, 2)"]:
    """Root of the covariance of B and K by the choice of the window.

    Scatter and the other sources also make windows differ, and are counted there. For each parameter, let d_w
    be the difference from the chosen window, v_w its variance by them, and V the variance of the estimate. A
    window counts by its precision, q_w = V / (V + v_w), because a window of mostly noise would not be chosen.
    The weighted mean squares D of d_w and E of v_w then give the effect of the window: the differences times
    D / (D + E). For differences by chance alone its variance is on average as large as that of
    max(0, D - E), but it does not jump where D = E.

    differences, variances: d_w and v_w, in units of B and K and their squares.
    whole: V.
    """
    counts = whole / np.maximum(whole + variances, 1e-300)
    counts /= np.maximum(counts.sum(axis=0), 1e-300)
    seen, expected = ((counts * x).sum(axis=0) for x in (differences**2, variances))
    return np.sqrt(counts) * differences * seen / np.maximum(seen + expected, 1e-300)


def _responses_changed(trials: list[BroadbandEpochs], errors: FitErrors) -> Change:
    """Share of every response in the error of B and K, and of the mean response of its trial."""
    responses = sum(trial.count for trial in trials)
    signals, first = np.zeros((responses, len(trials), *trials[0].perturbed.shape[1:])), 0
    for k, trial in enumerate(trials):
        around = (trial.perturbed - trial.perturbed.mean(axis=0)) / trial.count
        signals[first : first + trial.count, k] = np.sqrt(responses / errors.freedom) * around
        first += trial.count
    return Change(errors.scatter, signals)


def _between_recordings(fit: GeneralisedFit, trials: list[BroadbandEpochs]) -> np.ndarray | None:
    """Root of the covariance of B and K by the jackknife over trials, shape (trials, 2); None for a few."""
    recordings = by_recording(trials)
    if len(recordings) < FEWEST_TRIALS:
        return None
    left_out, k = fit.without_each(recordings), len(recordings)
    return np.sqrt((k - 1.0) / k) * (left_out - left_out.mean(axis=0))


def _changed(
    trials: list[BroadbandEpochs],
    records: list[Record],
    inside: np.ndarray,
    errors: FitErrors,
    contributions: dict[str, np.ndarray],
    options: FreeReflexOptions,
    by_source: dict[str, float],
) -> dict[str, Change]:
    """Source -> changes of B and K by ``contributions``, and those of the whole responses with them."""
    changes = {name: Change(rows) for name, rows in contributions.items()}
    for name in contributions.keys() & trials[0].slopes.keys():
        moved = np.stack([by_source[name] * trial.slopes[name] for trial in trials])
        changes[name] = Change(contributions[name], moved[None])
    shape = len(trials), *trials[0].perturbed.shape[1:]
    if TREADMILL in contributions:
        shared = len(contributions[TREADMILL])
        drawn = np.zeros((shared, *shape))
        for k, trial in enumerate(trials):
            drawn[:, k, :, TORQUE] = root_of_draws(trial.draws[:shared])
        changes[TREADMILL] = Change(contributions[TREADMILL], drawn)
    # the misfit of the window goes on after it: the first rows of a Cholesky factor remain the same
    first = int(inside.argmax())
    later = trials[0].time[first:]
    smooth = squared_exponential(later, options.discrepancy_s) + 1e-6 * np.eye(later.size)
    shapes = np.linalg.cholesky(smooth).T
    misfit = np.zeros((len(trials), later.size, *shape))
    for k, record in enumerate(records):
        peak = record.target[np.abs(record.target).argmax()]
        misfit[k, :, k, first:, TORQUE] = peak * shapes
    rows = _padded(errors.discrepancy, later.size)
    changes[OWN_DISCREPANCY] = Change(
        options.discrepancy * rows.reshape(-1, 2), options.discrepancy * misfit.reshape(-1, *shape)
    )
    if DISCREPANCY in by_source:
        size = by_source[DISCREPANCY]
        changes[DISCREPANCY] = Change(size * rows.sum(axis=0), size * misfit.sum(axis=0))
    return changes


def _yielded(
    trials: list[BroadbandEpochs], fit: GeneralisedFit, records: list[Record], inside: np.ndarray
) -> Change:
    """Change by a joint that yields as much as it can: B and K follow its torque in the window."""
    angles = np.stack([trial.perturbed[..., ANKLE].mean(axis=0) for trial in trials])
    signals = np.zeros((1, len(trials), *trials[0].perturbed.shape[1:]))
    signals[0, ..., TORQUE] = yielding(angles, float(fit.parameters[1]))
    return Change(sensitivity(fit, records, list(signals[0, ..., TORQUE][:, inside]))[None], signals)


def _scatter(
    fit: GeneralisedFit, trials: list[BroadbandEpochs], inside: np.ndarray
) -> tuple[np.ndarray, float]:
    """Type A of B and K, and its degrees of freedom."""
    recordings = by_recording(trials)  # both directions of one trial have the same drift and sway
    if len(recordings) >= FEWEST_TRIALS:
        return np.sqrt(jackknife(fit.without_each(recordings))), len(recordings) - 1.0
    variance = sum(jackknife(x) for x in _without_each_response(fit, trials, inside))
    return np.sqrt(variance), max(1.0, float(sum(trial.count for trial in trials) - len(trials)))


@dataclass(frozen=True)
class ApartFromOthers:
    """B and K of one recording less those of the others."""

    recording: str
    """Its name; empty if unknown."""
    own: Annotated[np.ndarray, "(2,)"]
    others: Annotated[np.ndarray, "(2,)"]
    """B (N·m·s/rad) and K (N·m/rad), in the window and with the covariance of the common fit."""
    chance: Annotated[np.ndarray, "(2,)"]
    """Probability of so large a difference by the scatter of responses and the misfit of the rig's model."""

    @property
    def size(self) -> np.ndarray:
        """Relative differences of B and K, shape (2,)."""
        return np.abs(self.own - self.others) / np.abs(self.others)


def compared_recordings(
    trials: list[BroadbandEpochs], fit: GeneralisedFit, errors: FitErrors, discrepancy: float
) -> tuple[ApartFromOthers, ...]:
    """B and K of every recording against the others, from the normal equations of the common fit.

    The information N_j of a recording j and its moments m_j give its own parameters N_j^-1 m_j; a change d of
    the common ones by its data is N_j^-1 N d there, and not present in the others, whose changes are likewise
    (N - N_j)^-1 N d. Sources that all recordings share cancel.
    """
    recordings = by_recording(trials)
    if len(recordings) < 2:
        return ()
    total, moments = fit.information.sum(axis=0), fit.moments.sum(axis=0)
    owner = np.repeat(np.arange(len(trials)), [trial.count for trial in trials])
    found = []
    for own in recordings:
        n, m = fit.information[own].sum(axis=0), fit.moments[own].sum(axis=0)
        ours = np.isin(owner, own)
        apart = np.isin(np.arange(len(trials)), own)
        changes = []
        for information, responses, kept in ((n, ours, apart), (total - n, ~ours, ~apart)):
            per_common = np.linalg.solve(information, total)
            rows = np.concatenate(
                [errors.scatter[responses], discrepancy * errors.discrepancy[kept].reshape(-1, 2)]
            )
            error = np.linalg.norm(rows @ per_common.T, axis=0)
            changes.append((error, max(1.0, float(responses.sum() - kept.sum()))))
        parameters = np.linalg.solve(n, m), np.linalg.solve(total - n, moments - m)
        found.append(ApartFromOthers(trials[own[0]].recording, *parameters, welch(*parameters, *changes)[0]))
    return tuple(found)


def jackknife(left_out: np.ndarray) -> np.ndarray:
    """Variance of estimates from the estimates without each of k parts, shape (k, p)."""
    k = len(left_out)
    return (k - 1.0) / k * ((left_out - left_out.mean(axis=0)) ** 2).sum(axis=0)


def _without_each_response(
    fit: GeneralisedFit, trials: list[BroadbandEpochs], inside: np.ndarray
) -> list[np.ndarray]:
    """B and K without each response, shape (responses, 2), for each trial with several."""
    information, moments = fit.information.sum(axis=0), fit.moments.sum(axis=0)
    estimates = []
    for k, trial in enumerate(trials):
        n = trial.count
        if n < 2:
            continue
        responses = trial.perturbed[:, inside]
        means = (responses.sum(axis=0) - responses) / (n - 1.0)
        x, y = means[..., REGRESSORS], means[..., TORQUE]
        weighted = np.swapaxes(x, -1, -2) @ fit.weights[k]
        more = n / (n - 1.0)  # noise of a mean of fewer responses
        changed = weighted @ x - more * fit.noise_information[k]
        changed_moments = (weighted @ y[..., None])[..., 0] - more * fit.noise_moments[k]
        left = information - fit.information[k] + changed
        right = moments - fit.moments[k] + changed_moments
        estimates.append(np.linalg.solve(left, right[..., None])[..., 0])
    return estimates


def _curve(record: Record, parameters: np.ndarray, time: np.ndarray) -> dict[str, np.ndarray]:
    """Mean response of a trial, and its parts."""
    intrinsic = record.regressors @ parameters
    return {
        "time": time,
        "torque": record.target,
        "intrinsic": intrinsic,
        "active": record.target - intrinsic,
        "ankle": record.regressors[:, 1],
    }


def _vaf(curves: list[dict[str, np.ndarray]], before: np.ndarray) -> float:
    """VAF of B phi' + K phi before the reflex (%)."""
    torque = np.concatenate([curve["torque"][before] for curve in curves])
    residual = np.concatenate([curve["active"][before] for curve in curves])
    return 100.0 * (1.0 - float(residual @ residual) / float(torque @ torque))
