"""Latency of the response of each muscle to its own stretch, from the responses of several trials.

A muscle is lengthened at the speed s = sum_j w_j phi_j', with w_j the lengthening per rotation of joint j.
Trials are used if the perturbation lengthens the muscle first: if it shortens it first, the later stretch
has no sharp onset. Feet and legs are rigid, so all joints start to rotate when the belt starts to move. This
instant is known to a fraction of a millisecond, more accurately than the onset of any angle, and is the zero
of the latency.
"""

import math
from dataclasses import dataclass
from typing import Annotated

import numpy as np
import scipy

from tepsipe.errors import InputError
from tepsipe.experiments.budgets import rows_of
from tepsipe.experiments.standing.epochs import StandingEpochs
from tepsipe.identification.result import Quantity
from tepsipe.io.estimates import Estimate
from tepsipe.signals.epochs import without_artefact
from tepsipe.signals.onsets import DETECTORS, Onset, OnsetOptions, detect_onset
from tepsipe.statistics.uncertainty import Budget, Source

# baseline before the searched time (s)
BASELINE_S = 0.15


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


def lengthening_speed(
    responses: StandingEpochs, lengthening: dict[str, float]
) -> Annotated[np.ndarray, "(n,)", "rad/s"]:
    """Mean speed at which a muscle is lengthened after the perturbations of a trial.

    lengthening: joint, ankle or knee -> lengthening per angle.
    """
    unknown = [joint for joint in lengthening if joint not in responses.stretch]
    if unknown:
        raise InputError(
            f"expected muscles that are stretched by {' or '.join(responses.stretch)}, found "
            f"{unknown[0]!r}: "
            "correct standing.muscles"
        )
    return sum(weight * responses.stretch[joint].mean(axis=0) for joint, weight in lengthening.items())


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
    stretching = []
    for responses in trials:
        if muscle not in responses.muscles or not responses.count:
            continue
        speed = lengthening_speed(responses, lengthening)
        # until the belt returns
        displacement = np.abs(
            np.cumsum(responses.perturbed["belt_velocity"].mean(axis=0) * (responses.time >= 0.0))
        )
        first = (responses.time >= 0.0) & (np.arange(displacement.size) <= displacement.argmax())
        if speed[first].mean() > 0.0:
            stretching.append(responses)
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
    pooled, sizes = [], []
    for responses in stretching:
        column = responses.muscles.index(muscle)
        usable = responses.usable[:, column]
        emg_of_trial = responses.emg[usable][..., column]
        belt = responses.perturbed["belt_velocity"][usable]
        sizes.append(np.take_along_axis(belt, np.abs(belt).argmax(axis=1)[:, None], axis=1)[:, 0])
        pooled.append(scipy.interpolate.CubicSpline(responses.emg_time, emg_of_trial, axis=1)(time))
    emg = np.concatenate(pooled)
    if emg.shape[0] < 5:
        return f"expected at least 5 responses that stretch {muscle}, found {emg.shape[0]}"
    # the movement artefact of skin and cables is proportional to the perturbation
    emg = without_artefact(emg, np.concatenate(sizes))
    onsets = {
        detector: detect_onset(time, emg, OnsetOptions(**{**vars(options), "detector": detector}), rng)
        for detector in DETECTORS
    }
    return MuscleLatency(muscle, onsets, time, np.abs(emg).mean(axis=0), emg.shape[0])


def latency_estimates(condition: str, latency: MuscleLatency, source: Source | None = None) -> list[Estimate]:
    """Tidy rows: latency (s) by every detector with an onset.

    condition: trial or task.
    source: uncertainty of the start of a perceptible stretch: Type B of every latency.
    Returns: an onset at an end of the searched time has no value, and the flag ``edge-of-search``.
    """
    rows, n = [], latency.responses
    for detector, onset in latency.onsets.items():
        if onset.at_edge or onset.latency_s is not None:
            quantity = _quantity(onset, n, source)
            rows += rows_of(
                ("standing", condition, "emg", detector), {f"latency_{latency.muscle}": quantity}, n
            )
    return rows


def _quantity(onset: Onset, responses: int, source: Source | None) -> Quantity:
    """A latency with the interval of the resampled ensembles, widened by Type B on both sides."""
    value, error, ends = onset.latency_s, onset.standard_error_s, onset.interval_s
    if value is None:
        return Quantity(math.nan, "s", flags=("edge-of-search",))
    if error is None or ends is None:
        return Quantity(value, "s")
    if source is None:
        return Quantity(value, "s", error, *ends, error)
    u_b = source.standard_uncertainty
    budget = Budget(np.array([error]), responses - 1.0, {source.name: np.array([[u_b]])})
    below, above = (abs(end - value) for end in ends)
    half = float(budget.interval(np.zeros(1))[1][0]) - float(
        Budget(budget.type_a, budget.freedom_a).interval(np.zeros(1))[1][0]
    )
    return Quantity(
        value, "s", float(budget.combined[0]), value - below - half, value + above + half, error, u_b
    )
