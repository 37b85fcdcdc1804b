"""Ankle impedance of a standing person with a reflex torque of unknown shape: generalised least squares.

    tau(t) = B phi'(t) + K phi(t) + r(t) + d(t) + s(t)

for the mean response of every trial. r is the torque of reflexes, free from its earliest instant t_r on: an
integrated Wiener process, whose size grows with the belt's speed. d is what the model of the rig leaves, a
smooth error of a given share of the torque. s is sway, whose covariance is that of unperturbed standing,
after B phi' + K phi, divided by the number of responses. The window may then end before or after the first
reflex: K and B depend little on it.

Type A is the scatter between trials, by the jackknife; of a single trial, between responses, by the
bootstrap. Type B are the sources of `tepsipe.experiments.standing.free_body`, draws of the treadmill model's
constants, the choice of window and t_r, and the part of d that all trials of a person share. Soft tissue
counts with what the responses show of it, too: the apparent centre of the joint after a pulse, less that of
quiet sway, over the shift that a metre of tissue motion causes.
"""

from dataclasses import dataclass

import numpy as np

from tepsipe.errors import InputError
from tepsipe.experiments.standing.broadband import BroadbandEpochs
from tepsipe.identification.generalised_least_squares import (
    GeneralisedFit,
    Record,
    generalised_least_squares,
    integrated_wiener,
    sensitivity,
    squared_exponential,
)
from tepsipe.statistics.uncertainty import Budget, Source, root_of_draws

TORQUE, ANKLE, ANKLE_D = range(3)
QUANTITIES = ("B", "K")
# before the onset a zero-lag low-pass of 60 Hz already shows the response (s)
FILTER_WIDTH_S = 0.03
# step between the starts of overlapping stretches of quiet standing (s)
QUIET_STEP_S = 0.02
# covariance of sway and parameters are found in turn
ROUNDS = 3
# fewest trials whose scatter is Type A
FEWEST_TRIALS = 4
# sources that this module adds to those of the signals
TREADMILL, WINDOW, REFLEX_ONSET, DISCREPANCY = (
    "treadmill_model",
    "window_s",
    "reflex_onset_s",
    "model_discrepancy",
)


@dataclass(frozen=True)
class FreeReflexOptions:
    """Choices of the estimator.

    Attributes
    ----------
    lowpass_cutoff_hz : float
        Of all signals (Hz).
    discrepancy, discrepancy_s : float
        Standard deviation of d as a share of the largest torque of the response (-), and its length (s).
    reflex_Nm, reflex_after_s, reflex_speed_m_per_s : float
        Standard deviation of r (N·m) a time after t_r (s), at a speed of the belt (m/s).
    reflex_onset_s : float
        t_r if no latency of an ankle muscle is known (s).
    electromechanical_delay_s : float
        From a muscle's latency to t_r (s).
    windows_s : tuple of float
        Shortest and longest window whose spread counts as an uncertainty (s).
    """

    lowpass_cutoff_hz: float
    discrepancy: float
    discrepancy_s: float
    reflex_Nm: float
    reflex_after_s: float
    reflex_speed_m_per_s: float
    reflex_onset_s: float
    electromechanical_delay_s: float
    windows_s: tuple[float, float]


@dataclass(frozen=True)
class FreeReflexFit:
    """B and K of one trial or of several together.

    Attributes
    ----------
    parameters : ndarray, shape (1 + draws, 2)
        B (N·m·s/rad) and K (N·m/rad); further rows from resampled responses.
    budget : Budget
        Uncertainty of B and K.
    window_s, reflex_onset_s : float
        Window and t_r (s).
    windows : ndarray, shape (w, 3)
        Window (s), B and K by it, within ``windows_s`` of the options.
    curves : list of dict of str to ndarray
        Per trial: ``time`` (s), ``torque``, ``intrinsic``, ``active`` (N·m), ``ankle`` (rad).
    vaf : float
        VAF of the mean responses by B and K alone, before t_r (%).
    """

    parameters: np.ndarray
    budget: Budget
    window_s: float
    reflex_onset_s: float
    windows: np.ndarray
    curves: list[dict[str, np.ndarray]]
    vaf: float


def fit_free_reflex(
    trials: list[BroadbandEpochs],
    window_s: float,
    options: FreeReflexOptions,
    sources: list[Source],
    draws: int,
    rng: np.random.Generator,
    reflex_onset_s: float | None = None,
) -> FreeReflexFit:
    """Fit the responses of one trial, or of several trials with common parameters.

    Parameters
    ----------
    trials : list of BroadbandEpochs
        Responses (rad, N·m).
    window_s : float
        Length of the fitted window from the onset (s).
    options : FreeReflexOptions
        Choices (units in their names).
    sources : list of Source
        What is not known exactly (its unit in its name); those that move no signal of the trials are ignored.
    draws : int
        Number of resampled sets of responses (-).
    rng : numpy.random.Generator
        Draws them.
    reflex_onset_s : float, optional
        t_r (s); that of the options if left out.

    Returns
    -------
    FreeReflexFit
        B, K and their budget.

    Raises
    ------
    InputError
        If the window is longer than the epochs.
    """
    time = trials[0].time
    if not 0.0 < window_s <= time[-1] + 1e-9:
        raise InputError(
            f"expected a window of at most {time[-1]:g} s for a free reflex torque, found {window_s:g} s: "
            "shorten it in standing.estimators"
        )
    onset = options.reflex_onset_s if reflex_onset_s is None else reflex_onset_s
    fit, records = _fitted(trials, window_s, onset, options)
    inside = _inside(time, window_s)
    resampled = _resampled(trials, records, inside, draws, rng)
    tried = _windows(trials, onset, options)
    contributions = _of_signals(trials, fit, records, inside, sources)
    shared = min((len(trial.draws) for trial in trials), default=0)
    if shared > 1:
        moved = sensitivity(fit, records, [trial.draws[:shared, inside] for trial in trials])
        contributions[TREADMILL] = root_of_draws(moved)
    contributions[WINDOW] = (tried[:, 1:] - fit.parameters) / np.sqrt(len(tried))
    for source in sources:
        if source.name == REFLEX_ONSET:
            u = source.standard_uncertainty
            later, earlier = (_fitted(trials, window_s, onset + step, options)[0] for step in (u, -u))
            contributions[REFLEX_ONSET] = 0.5 * (later.parameters - earlier.parameters)[None]
        if source.name == DISCREPANCY:
            share = source.standard_uncertainty
            contributions[DISCREPANCY] = share * _of_discrepancy(fit, records, time[inside], options)
    budget = Budget(
        *_scatter(fit, resampled, sum(trial.count for trial in trials)),
        contributions,
        {source.name: source.freedom for source in sources},
    )
    curves = [_curve(record, fit.parameters, time[inside]) for record in records]
    before = time[inside] <= onset
    return FreeReflexFit(
        parameters=np.vstack([fit.parameters, resampled]),
        budget=budget,
        window_s=window_s,
        reflex_onset_s=onset,
        windows=tried,
        curves=curves,
        vaf=_vaf(curves, before),
    )


def _inside(time: np.ndarray, window_s: float) -> np.ndarray:
    """Samples of the window, with those into which the filter spreads the onset."""
    return (time >= -FILTER_WIDTH_S - 1e-9) & (time <= window_s + 1e-9)


def _sway(trials: list[BroadbandEpochs], inside: np.ndarray) -> np.ndarray:
    """Overlapping stretches of quiet standing as long as the window, baseline-corrected as the responses."""
    time = trials[0].time
    step = time[1] - time[0]
    first, last = np.flatnonzero(inside)[[0, -1]]
    zero = time <= time[0] + 0.1  # of the epoch: as long before the onset as the baseline of the responses
    found = []
    for trial in trials:
        starts = range(0, trial.quiet.shape[1] - last, max(1, round(QUIET_STEP_S / step)))
        for k in starts:
            piece = trial.quiet[:, k : k + last + 1]
            found.append(piece[:, first:] - piece[:, : zero.sum()].mean(axis=1, keepdims=True))
    return np.concatenate(found)


def _fitted(
    trials: list[BroadbandEpochs], window_s: float, onset_s: float, options: FreeReflexOptions
) -> tuple[GeneralisedFit, list[Record]]:
    """Best parameters, and the records with their covariances."""
    inside = _inside(trials[0].time, window_s)
    time = trials[0].time[inside]
    sway = _sway(trials, inside)
    means = [trial.perturbed[:, inside].mean(axis=0) for trial in trials]
    smooth = squared_exponential(time, options.discrepancy_s)
    unit = options.reflex_Nm**2 / (options.reflex_after_s**3 / 3.0)
    free = unit * integrated_wiener(time, onset_s)
    parameters = np.zeros(2)
    for _ in range(ROUNDS):
        left = sway[..., TORQUE] - sway[..., [ANKLE_D, ANKLE]] @ parameters
        covariance = left.T @ left / len(left)
        records = [
            Record(
                target=mean[:, TORQUE],
                regressors=mean[:, [ANKLE_D, ANKLE]],
                covariance=covariance / trial.count
                + _size(mean[:, TORQUE], options) ** 2 * (smooth + 1e-6 * np.eye(time.size))
                + (trial.peak_m_per_s / options.reflex_speed_m_per_s) ** 2 * free,
            )
            for trial, mean in zip(trials, means, strict=True)
        ]
        fit = generalised_least_squares(records)
        parameters = fit.parameters
    return fit, records


def _size(torque: np.ndarray, options: FreeReflexOptions) -> float:
    """Standard deviation of d (N·m)."""
    return options.discrepancy * float(np.abs(torque).max())


def _windows(trials: list[BroadbandEpochs], onset_s: float, options: FreeReflexOptions) -> np.ndarray:
    """Window, B and K by windows every 10 ms, shape (w, 3) (s, N·m·s/rad, N·m/rad)."""
    low, high = options.windows_s
    lengths = np.linspace(low, high, max(2, round((high - low) / 0.01) + 1))
    return np.array([[w, *_fitted(trials, w, onset_s, options)[0].parameters] for w in lengths.tolist()])


def _resampled(
    trials: list[BroadbandEpochs],
    records: list[Record],
    inside: np.ndarray,
    draws: int,
    rng: np.random.Generator,
) -> np.ndarray:
    """Parameters from responses drawn again within every trial, shape (draws, 2)."""
    drawn = []
    for trial, record in zip(trials, records, strict=True):
        n = trial.count
        weights = rng.multinomial(n, np.full(n, 1.0 / n), draws) / n
        means = np.einsum("dr,rnc->dnc", weights, trial.perturbed[:, inside])
        drawn.append(Record(means[..., TORQUE], means[..., [ANKLE_D, ANKLE]], record.covariance))
    return generalised_least_squares(drawn).parameters


def _scatter(fit: GeneralisedFit, resampled: np.ndarray, responses: int) -> tuple[np.ndarray, float]:
    """Type A of B and K, and its degrees of freedom (-)."""
    trials = len(fit.information)
    if trials >= FEWEST_TRIALS:
        left_out = fit.without_each()
        around = left_out - left_out.mean(axis=0)
        return np.sqrt((trials - 1.0) / trials * (around**2).sum(axis=0)), trials - 1.0
    freedom = max(1.0, float(responses - trials))
    # resampling n responses underestimates their spread
    return np.sqrt(responses / freedom) * resampled.std(axis=0), freedom


def _of_signals(
    trials: list[BroadbandEpochs],
    fit: GeneralisedFit,
    records: list[Record],
    inside: np.ndarray,
    sources: list[Source],
) -> dict[str, np.ndarray]:
    """Signed contributions of the sources that move the signals, each of shape (1, 2)."""
    found = {}
    for source in sources:
        if source.name in trials[0].slopes:
            moved = [source.standard_uncertainty * trial.slopes[source.name][inside] for trial in trials]
            changes = sensitivity(
                fit, records, [m[:, TORQUE] for m in moved], [m[:, [ANKLE_D, ANKLE]] for m in moved]
            )
            found[source.name] = changes[None]
    return found


def _of_discrepancy(
    fit: GeneralisedFit, records: list[Record], time: np.ndarray, options: FreeReflexOptions
) -> np.ndarray:
    """Root of the covariance of B and K by d of unit size, if all trials share it."""
    smooth = squared_exponential(time, options.discrepancy_s) + 1e-6 * np.eye(time.size)
    shapes = np.linalg.cholesky(smooth).T
    peaks = [record.target[np.abs(record.target).argmax()] for record in records]
    return sensitivity(fit, records, [peak * shapes for peak in peaks])


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
    left = np.concatenate([curve["active"][before] for curve in curves])
    return 100.0 * (1.0 - float(left @ left) / float(torque @ torque))


def difference_from_window(
    trials: list[BroadbandEpochs],
    fit: FreeReflexFit,
    window_s: float,
    options: FreeReflexOptions,
    sources: list[Source],
) -> Budget:
    """Budget of the difference between B and K by least squares in a short window and those of a fit.

    Parameters
    ----------
    trials : list of BroadbandEpochs
        The trials of both.
    fit : FreeReflexFit
        The fit.
    window_s : float
        Length of the short window (s).
    options : FreeReflexOptions
        Choices (units in their names).
    sources : list of Source
        What is not known exactly (units in their names); of both estimates alike.

    Returns
    -------
    Budget
        Of B and K (N·m·s/rad, N·m/rad). Its Type A is the scatter of the difference between trials.
    """
    inside = _inside(trials[0].time, window_s)
    plain = [
        Record(mean[:, TORQUE], mean[:, [ANKLE_D, ANKLE]], np.eye(int(inside.sum())))
        for mean in (trial.perturbed[:, inside].mean(axis=0) for trial in trials)
    ]
    short = generalised_least_squares(plain)
    contributions = _of_signals(trials, short, plain, inside, sources)
    # what only one of the two estimates has, or has of its own kind, is not common to both
    kept = {name: own for name, own in fit.budget.contributions.items() if name not in (WINDOW, TREADMILL)}
    difference = Budget(np.zeros(2), np.inf, contributions).minus(Budget(np.zeros(2), np.inf, kept))
    if len(trials) >= FEWEST_TRIALS:
        best, _ = _fitted(trials, fit.window_s, fit.reflex_onset_s, options)
        around = short.without_each() - best.without_each()
        around = around - around.mean(axis=0)
        trials_less = len(trials) - 1.0
        type_a = np.sqrt(trials_less / len(trials) * (around**2).sum(axis=0))
        return Budget(type_a, trials_less, difference.contributions, difference.freedom)
    return Budget(fit.budget.type_a, fit.budget.freedom_a, difference.contributions, difference.freedom)
