"""Latency of the response of each muscle to its own stretch, from the responses of several trials.

A muscle is lengthened at the speed s = sum_j w_j phi_j', with w_j the lengthening per rotation of joint j.
Trials are used if the perturbation lengthens the muscle first: if it shortens it first, the later stretch
has no sharp onset. Feet and legs are rigid, so all joints start to rotate when the belt starts to move. This
instant is known to a fraction of a millisecond, more accurately than the onset of any angle, and is the zero
of the latency. A reflex whose stretch has a threshold begins later; the interval of the latency then reaches
down to what the stretch allows (`tepsipe.experiments.standing.thesis.stretch_threshold`).
"""

import math
from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
import scipy

from tepsipe.errors import InputError
from tepsipe.experiments.budgets import rows_of
from tepsipe.experiments.standing.epochs import StandingEpochs
from tepsipe.experiments.standing.thesis.stretch_threshold import (
    Lateness,
    Stretch,
    groups_by_amplitude,
    lateness_of,
    rising_stretch,
)
from tepsipe.identification.result import Quantity
from tepsipe.io.estimates import Estimate
from tepsipe.signals.epochs import without_artefact
from tepsipe.signals.onsets import DETECTORS, Onset, OnsetOptions, detect_onset
from tepsipe.statistics.uncertainty import Budget, Source

# baseline before the searched time (s)
BASELINE_S = 0.15
# responses of one amplitude that show an onset, and draws for its error
FEWEST, DRAWS = 5, 100


@dataclass(frozen=True)
class MuscleLatency:
    """Response of a muscle to its stretch."""

    muscle: str
    """Its name."""
    onsets: dict[str, Onset]
    """Detector -> onset, from the start of the stretch, the onset of the belt (s)."""
    time: Annotated[np.ndarray, "(m,)", "s"]
    """Time from the start of the stretch."""
    rectified: Annotated[np.ndarray, "(m,)"]
    """Mean rectified electromyogram (uV)."""
    responses: int
    """Number of responses."""
    late: Lateness | None = None
    """Lateness of the onsets because of a threshold of the stretch; None without the scatter of onsets."""


def lengthening_speed(
    responses: StandingEpochs, lengthening: dict[str, float]
) -> Annotated[np.ndarray, "(responses, n)", "rad/s"]:
    """Speed at which a muscle is lengthened after the perturbations of a trial.

    lengthening: joint, ankle or knee -> lengthening per angle.
    """
    unknown = [joint for joint in lengthening if joint not in responses.stretch]
    if unknown:
        raise InputError(
            f"expected muscles that are stretched by {' or '.join(responses.stretch)}, found "
            f"{unknown[0]!r}: "
            "correct standing.muscles"
        )
    return sum(weight * responses.stretch[joint] for joint, weight in lengthening.items())


def _until_return(responses: StandingEpochs) -> Annotated[np.ndarray, "(n,)"]:
    """Samples from the onset until the belt returns."""
    after = responses.time >= 0.0
    displacement = np.abs(np.cumsum(responses.perturbed["belt_velocity"].mean(axis=0) * after))
    return after & (np.arange(displacement.size) <= displacement.argmax())


def first_stretch(responses: StandingEpochs, lengthening: dict[str, float]) -> float:
    """Mean over greatest speed of a muscle's lengthening until the belt returns, negative if it shortens.

    responses: responses to pulses of one direction.
    lengthening: joint -> lengthening per angle.
    """
    speed = lengthening_speed(responses, lengthening).mean(axis=0)[_until_return(responses)]
    return float(speed.mean() / max(np.abs(speed).max(), 1e-300))


def muscle_latency(
    trials: list[StandingEpochs],
    muscle: str,
    lengthening: dict[str, float],
    options: OnsetOptions,
    rng: np.random.Generator,
) -> MuscleLatency | str:
    """Latency of one muscle from all trials in which it is stretched first, by every detector.

    lengthening: joint -> lengthening per angle.
    options: Choices; every detector is applied.
    Returns: onsets (s), or the reason why there are none.
    """
    usable = [responses for responses in trials if muscle in responses.muscles and responses.count]
    stretching = [responses for responses in usable if first_stretch(responses, lengthening) > 0.0]
    if not stretching:
        return f"expected trials that stretch {muscle} first and have a usable channel for it, found none"
    step = stretching[0].emg_time[1] - stretching[0].emg_time[0]
    first = min(options.baseline_until_s, options.search_s[0]) - BASELINE_S
    last = options.search_s[1] + 0.02
    time = np.arange(round(first / step), round(last / step) + 1) * step
    recorded = stretching[0].emg_time
    if time[0] < recorded[0] - 1e-9 or time[-1] > recorded[-1] + 1e-9:
        raise InputError(
            f"latency of {muscle}: expected responses from {time[0]:g} s to {time[-1]:g} s from the onset, "
            f"found {recorded[0]:g} s to {recorded[-1]:g} s: cut longer epochs or search elsewhere"
        )
    pooled, sizes, speeds = [], [], []
    for responses in stretching:
        column = responses.muscles.index(muscle)
        usable = responses.usable[:, column]
        emg_of_trial = responses.emg[usable][..., column]
        belt = responses.perturbed["belt_velocity"][usable]
        speeds.append(lengthening_speed(responses, lengthening)[usable])
        sizes.append(np.take_along_axis(belt, np.abs(belt).argmax(axis=1)[:, None], axis=1)[:, 0])
        pooled.append(scipy.interpolate.CubicSpline(responses.emg_time, emg_of_trial, axis=1)(time))
    emg = np.concatenate(pooled)
    if emg.shape[0] < 5:
        return f"expected at least 5 responses that stretch {muscle}, found {emg.shape[0]}"
    # the movement artefact of skin and cables is proportional to the perturbation
    size = np.concatenate(sizes)
    emg = without_artefact(emg, size)
    onsets = {
        detector: detect_onset(time, emg, OnsetOptions(**{**vars(options), "detector": detector}), rng)
        for detector in DETECTORS
    }
    late = None
    if options.bootstrap_draws:
        turns_s = max(float(responses.time[_until_return(responses)][-1]) for responses in stretching)
        stretch = stretching[0].time, np.concatenate(speeds), turns_s
        late = _lateness(time, emg, size, stretch, onsets["changepoint"], options, rng)
    return MuscleLatency(muscle, onsets, time, np.abs(emg).mean(axis=0), emg.shape[0], late)


def _lateness(
    time: np.ndarray,
    emg: np.ndarray,
    sizes: np.ndarray,
    stretch: tuple[np.ndarray, np.ndarray, float],
    onset: Onset,
    options: OnsetOptions,
    rng: np.random.Generator,
) -> Lateness:
    """Lateness of an onset, from the onsets after pulses of each amplitude.

    stretch: time (s), speed of the stretch in each response (rad/s), and the end of the first stretch (s).
    """
    choices = replace(options, detector="changepoint", bootstrap_draws=min(options.bootstrap_draws, DRAWS))
    clock, speed, until_s = stretch
    groups = [group for group in groups_by_amplitude(sizes) if group.size >= FEWEST]
    stretches = []
    for group in groups:
        own = onset if group.size == len(emg) else detect_onset(time, emg[group], choices, rng)
        if own.latency_s is not None and own.standard_error_s is not None:
            rising = rising_stretch(clock, speed[group].mean(axis=0), until_s)
            stretches.append(Stretch(own.latency_s, own.standard_error_s, *rising))
    together = Stretch(0.0, 0.0, *rising_stretch(clock, speed.mean(axis=0), until_s))
    return lateness_of(onset, stretches, together)


def latency_estimates(condition: str, latency: MuscleLatency, source: Source | None = None) -> list[Estimate]:
    """Tidy rows: latency (s) by every detector with an onset.

    condition: trial or task.
    source: uncertainty of the start of a perceptible stretch: Type B of every latency.
    Returns: an onset at an end of the searched time has no value, and the flag ``edge-of-search``.
    """
    rows, n = [], latency.responses
    for detector, onset in latency.onsets.items():
        if onset.at_edge or onset.latency_s is not None:
            quantity = _quantity(onset, n, source, latency.late)
            rows += rows_of(
                ("standing", condition, "emg", detector), {f"latency_{latency.muscle}": quantity}, n
            )
    return rows


def _quantity(onset: Onset, responses: int, source: Source | None, late: Lateness | None) -> Quantity:
    """A latency with the interval of the resampled ensembles, widened by Type B.

    The source widens both sides, and the lateness the lower one only.
    """
    value, error, ends = onset.latency_s, onset.standard_error_s, onset.interval_s
    if value is None:
        return Quantity(math.nan, "s", flags=("edge-of-search",))
    if error is None or ends is None:
        return Quantity(value, "s")
    u_b = 0.0 if source is None else source.standard_uncertainty
    below, above = (abs(end - value) for end in ends)
    if source is not None:
        budget = Budget(np.array([error]), responses - 1.0, {source.name: np.array([[u_b]])})
        half = float(budget.interval(np.zeros(1))[1][0]) - float(
            Budget(budget.type_a, budget.freedom_a).interval(np.zeros(1))[1][0]
        )
        below, above = below + half, above + half
    if late is not None:
        below = late.median_s + math.hypot(below, late.most_s - late.median_s)
        u_b = math.hypot(u_b, late.rms_s)
    flags = () if late is None else late.flags
    if source is None and late is None:
        return Quantity(value, "s", error, value - below, value + above, error)
    return Quantity(value, "s", math.hypot(error, u_b), value - below, value + above, error, u_b, flags=flags)
