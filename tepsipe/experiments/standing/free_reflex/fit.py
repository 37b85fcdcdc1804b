"""Ankle impedance of a standing person with a reflex torque of unknown shape: generalised least squares.

    tau(t) = B phi'(t) + K phi(t) + r(t) + d(t) + s(t)

for the mean response of every trial. r is the torque of reflexes, free from its earliest instant t_r on: an
integrated Wiener process, whose size grows with the belt's speed. d is the error of the rig's model, a smooth
error of a given share of the torque. s is sway; its covariance is taken from unperturbed standing, after
B phi' + K phi, and divided by the number of responses. The window may then end before or after the first
reflex: K and B depend little on it.

Type A is the scatter between trials, by the jackknife; of a single trial, between responses, by the
bootstrap. Type B are the sources of `tepsipe.experiments.standing.free_reflex.free_body`, draws of the
treadmill model's constants, the choice of window and t_r, and the part of d that all trials of a person
share. The contribution of soft tissue also uses the responses: the apparent centre of the joint after a pulse
less the centre in quiet sway, over the shift that a metre of tissue motion causes.
"""

from dataclasses import dataclass

import numpy as np

from tepsipe.errors import InputError
from tepsipe.experiments.standing.free_reflex.broadband import BroadbandEpochs
from tepsipe.experiments.standing.free_reflex.fit_errors import ANKLE, ANKLE_D, TORQUE, FitErrors, fit_errors
from tepsipe.identification.regression.generalised import (
    GeneralisedFit,
    Record,
    generalised_least_squares,
    integrated_wiener,
    squared_exponential,
)
from tepsipe.statistics.uncertainty import Budget, Source

QUANTITIES = ("B", "K")
# before the onset a zero-lag low-pass of 60 Hz already shows the response (s)
FILTER_WIDTH_S = 0.03
# step between the starts of overlapping stretches of quiet standing (s)
QUIET_STEP_S = 0.02
# covariance of sway and parameters are estimated in turn
ROUNDS = 3
# fewest trials whose scatter is Type A
FEWEST_TRIALS = 4
# sources that this module adds to the sources of the signals
WINDOW, REFLEX_ONSET, DISCREPANCY = "window_s", "reflex_onset_s", "model_discrepancy"


@dataclass(frozen=True)
class FreeReflexOptions:
    """Choices of the estimator.

    Attributes
    ----------
    lowpass_cutoff_hz : float
        Cutoff of the low-pass of all signals (Hz).
    discrepancy, discrepancy_s : float
        Standard deviation of d as a share of the largest torque of the response, and its length (s).
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
    errors : FitErrors
        Effect of each source on B and K with its sign, for differences from other fits.
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
    errors: FitErrors
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
        Options of the analysis.
    sources : list of Source
        Uncertain constants (unit in the name); sources that move no signal of the trials are ignored.
    draws : int
        Number of resampled sets of responses.
    rng : numpy.random.Generator
        Draws them.
    reflex_onset_s : float, optional
        t_r (s); from the options if left out.

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
    fit, records, errors = fit_with_errors(trials, window_s, onset, options, sources)
    inside = inside_window(time, window_s)
    resampled = _resampled(trials, records, inside, draws, rng)
    by_source = {source.name: source.standard_uncertainty for source in sources}
    contributions = dict(errors.contributions)
    tried, contributions[WINDOW] = _windows(trials, errors, options, sources, onset)
    if DISCREPANCY in by_source:
        contributions[DISCREPANCY] = by_source[DISCREPANCY] * errors.discrepancy.sum(axis=0)
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
        errors=errors,
        window_s=window_s,
        reflex_onset_s=onset,
        windows=tried,
        curves=curves,
        vaf=_vaf(curves, before),
    )


def inside_window(time: np.ndarray, window_s: float) -> np.ndarray:
    """Samples of the window (s), including those to which the filter spreads the onset, shape (n,)."""
    return (time >= -FILTER_WIDTH_S - 1e-9) & (time <= window_s + 1e-9)


def _sway(trials: list[BroadbandEpochs], inside: np.ndarray) -> np.ndarray:
    """Overlapping stretches of quiet standing as long as the window, baseline-corrected as the responses."""
    first, last = np.flatnonzero(inside)[[0, -1]].tolist()
    step = max(1, round(QUIET_STEP_S / (trials[0].time[1] - trials[0].time[0])))
    stretches = [trial.quiet_stretches(first, last, step) for trial in trials]
    return stretches[0] if len(stretches) == 1 else np.concatenate(stretches)


def _sway_moments(trials: list[BroadbandEpochs], inside: np.ndarray) -> np.ndarray:
    """Mean products of the signals of sway at all pairs of instants, shape (3, 3, n, n)."""
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
    """Best B and K in a window, with the moments of sway in it, for an onset of reflexes, and the records."""
    time = trials[0].time[inside]
    means = [trial.perturbed[:, inside].mean(axis=0) for trial in trials]
    smooth = squared_exponential(time, options.discrepancy_s)
    unit = options.reflex_Nm**2 / (options.reflex_after_s**3 / 3.0)
    free = unit * integrated_wiener(time, onset_s)
    parameters = np.zeros(2)
    for _ in range(ROUNDS):
        combination = np.zeros(3)
        combination[[TORQUE, ANKLE_D, ANKLE]] = 1.0, *-parameters
        covariance = np.tensordot(np.outer(combination, combination), moments, 2)
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


def fit_with_errors(
    trials: list[BroadbandEpochs],
    window_s: float,
    onset_s: float,
    options: FreeReflexOptions,
    sources: list[Source],
) -> tuple[GeneralisedFit, list[Record], FitErrors]:
    """Best B and K (N·m·s/rad, N·m/rad) in a window (s) for an onset of reflexes (s), records, and errors."""
    inside = inside_window(trials[0].time, window_s)
    moments = _sway_moments(trials, inside)
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
    chosen: FitErrors,
    options: FreeReflexOptions,
    sources: list[Source],
    onset_s: float,
) -> tuple[np.ndarray, np.ndarray]:
    """Window, B and K every 10 ms, shape (w, 3), and root of the covariance by the window, shape (w, 2).

    Scatter and the other sources also make windows differ, and are counted there. Only the spread beyond
    them counts as the effect of the window.
    """
    low, high = options.windows_s
    lengths = np.linspace(low, high, max(2, round((high - low) / 0.01) + 1)).tolist()
    by_length = [fit_with_errors(trials, w, onset_s, options, sources)[2] for w in lengths]
    differences = np.array([errors.parameters for errors in by_length]) - chosen.parameters
    shared = sum(source.standard_uncertainty for source in sources if source.name == DISCREPANCY)
    expected = sum(errors.minus(chosen).variance(shared) for errors in by_length)
    seen = np.maximum((differences**2).sum(axis=0), 1e-300)
    beyond = np.sqrt(np.maximum(0.0, 1.0 - expected / seen))
    tried = np.array([[w, *errors.parameters] for w, errors in zip(lengths, by_length, strict=True)])
    return tried, differences * beyond / np.sqrt(len(lengths))


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
    """Type A of B and K, and its degrees of freedom."""
    trials = len(fit.information)
    if trials >= FEWEST_TRIALS:
        left_out = fit.without_each()
        around = left_out - left_out.mean(axis=0)
        return np.sqrt((trials - 1.0) / trials * (around**2).sum(axis=0)), trials - 1.0
    freedom = max(1.0, float(responses - trials))
    # resampling n responses underestimates their spread
    return np.sqrt(responses / freedom) * resampled.std(axis=0), freedom


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
