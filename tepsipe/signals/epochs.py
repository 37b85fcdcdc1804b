"""Epochs cut from a regularly sampled signal around events, their ensemble, and unperturbed epochs.

Symbols: x_i(t) response to event i, t time from the event (s), N number of events.

    mean m(t) = sum_i x_i(t) / N
    SD s(t), s(t)^2 = sum_i (x_i(t) - m(t))^2 / (N - 1),   standard error s(t) / sqrt(N)

An artefact w(t) that scales with the size a_i of the perturbation is removed by least squares:

    x_i(t) = a_i w(t) + rest_i(t),   w(t) = sum_i a_i x_i(t) / sum_i a_i^2
"""

from dataclasses import dataclass
from typing import Annotated

import numpy as np
import scipy

from tepsipe.errors import InputError


@dataclass(frozen=True)
class Responses:
    """Epochs on one time axis whose zero is the exact instant of each event."""

    time: Annotated[np.ndarray, "(m,)", "s"]
    """Time from the event."""
    values: Annotated[np.ndarray, "(events, m)"]
    """x_i (unit of the signal)."""
    kept: tuple[int, ...]
    dropped: tuple[int, ...]
    """Indices of the events with an epoch, and of those whose window exceeds the record, from 0."""


@dataclass(frozen=True)
class Ensemble:
    """Mean and spread of responses."""

    mean: Annotated[np.ndarray, "(m,)"]
    sd: Annotated[np.ndarray, "(m,)"]
    standard_error: Annotated[np.ndarray, "(m,)"]
    """m, s and s / sqrt(N) (unit of the responses)."""
    events: int


def margin_s(time: np.ndarray) -> float:
    """Time (s) far below a sample, by which times kept in single precision may differ."""
    return 1e-3 * float(time[1] - time[0])


def between(time: np.ndarray, start_s: float, end_s: float) -> np.ndarray:
    """Samples from a start to an end (s), both included, shape (n,)."""
    margin = margin_s(time)
    return (time >= start_s - margin) & (time <= end_s + margin)


def cut_epochs(
    x: np.ndarray,
    rate_hz: float,
    onsets_s: Annotated[np.ndarray, "(events,)"],
    before_s: float,
    after_s: float,
    start_s: float = 0.0,
    outside: str = "raise",
) -> Responses:
    """Cut epochs around events, aligned to the exact instants of the events.

    A cubic spline is evaluated at the event and at whole sampling intervals around it. It
    interpolates the samples. Its gain is 99.97 % at a tenth of the sampling rate and 93 % at three
    tenths. Rectify after cutting, not before: |x| contains higher frequencies than x.

    x: signal, without NaN.
    onsets_s: instants of the events (s), on the clock of ``start_s``.
    before_s, after_s: window around an event.
    outside: "raise" refuses an event whose window exceeds the record, "drop" omits it and lists it.
    Returns: time, responses (unit of ``x``) and the numbers of events kept and dropped.
    """
    x, onsets = np.asarray(x, dtype=float), np.atleast_1d(np.asarray(onsets_s, dtype=float))
    if outside not in ("raise", "drop"):
        raise InputError(
            f"outside: expected 'raise' or 'drop', found {outside!r}: change it where it is called"
        )
    if x.shape[0] < 4 or not np.isfinite(x).all():
        raise InputError(
            f"signal to cut: expected at least 4 samples without NaN, found {x.shape[0]} samples, "
            f"{np.count_nonzero(~np.isfinite(x))} of the values NaN or infinite: fill or cut them first"
        )
    if onsets.size == 0 or not np.isfinite(onsets).all():
        raise InputError(
            f"events to cut around: expected their instants, found {onsets.size}, "
            f"{np.count_nonzero(~np.isfinite(onsets))} of them not finite: detect the perturbations first"
        )
    grid = start_s + np.arange(x.shape[0]) / rate_hz
    time = np.arange(-round(before_s * rate_hz), round(after_s * rate_hz) + 1) / rate_hz
    tolerance = 1e-6 / rate_hz
    inside = (onsets + time[0] >= grid[0] - tolerance) & (onsets + time[-1] <= grid[-1] + tolerance)
    if not inside.all() and (outside == "raise" or not inside.any()):
        first = int(np.argmin(inside))
        raise InputError(
            f"event {first + 1} of {onsets.size} at {onsets[first]:.3f} s: expected a record from "
            f"{-time[0]:g} s before to {time[-1]:g} s after it, found one from {grid[0]:.3f} s to "
            f"{grid[-1]:.3f} s: leave the event out or shorten the window"
        )
    instants = np.clip(onsets[inside][:, None] + time, grid[0], grid[-1])
    return Responses(
        time=time,
        values=scipy.interpolate.CubicSpline(grid, x)(instants),
        kept=tuple(np.flatnonzero(inside).tolist()),
        dropped=tuple(np.flatnonzero(~inside).tolist()),
    )


def ensemble(responses: Annotated[np.ndarray, "(events, m)"]) -> Ensemble:
    """Mean, standard deviation and standard error over events.

    Returns: m, s and s / sqrt (unit of the responses).
    """
    events = responses.shape[0]
    if events < 2:
        raise InputError(
            f"ensemble of responses: expected at least 2 events, found {events}: record more perturbations"
        )
    sd = responses.std(axis=0, ddof=1)
    return Ensemble(responses.mean(axis=0), sd, sd / np.sqrt(events), events)


def without_artefact(
    responses: Annotated[np.ndarray, "(events, m)"], sizes: Annotated[np.ndarray, "(events,)"] | None = None
) -> np.ndarray:
    """Remove the component that all responses share in proportion to the sizes of the perturbations.

    The movement artefact of electrodes and cables is the same after every perturbation; the
    interference pattern of a muscle is not. An unrectified electromyogram therefore loses only a fraction
    1/N of its power. The part of a reflex that repeats wave by wave is removed with the artefact.

    responses: x_i, not rectified.
    sizes: a_i, signed, for example peak belt velocities; 1 by default.
    Returns: responses without the artefact (unit of the responses).
    """
    events = responses.shape[0]
    a = np.ones(events) if sizes is None else np.asarray(sizes, dtype=float)
    if events < 2 or a.shape != (events,) or not (np.isfinite(a).all() and a.any()):
        raise InputError(
            f"artefact of perturbations: expected at least 2 responses and a size for each, found {events} "
            f"responses and {np.count_nonzero(a)} sizes other than 0: pass one size per response"
        )
    w = np.tensordot(a, responses, axes=1) / (a @ a)
    return responses - np.multiply.outer(a, w)


def unperturbed_onsets(
    duration_s: float,
    perturbed_s: Annotated[np.ndarray, "(perturbations, 2)"],
    guard_s: float,
    before_s: float,
    after_s: float,
    count: int | None,
    rng: np.random.Generator | None = None,
) -> Annotated[np.ndarray, "(count,)"]:
    """Instants whose surrounding window holds no perturbation, for unperturbed epochs.

    The windows do not overlap. Each stretch of unperturbed time is filled with as many windows as
    fit; ``count`` of them are taken.

    duration_s: the record lasts from 0 to the instant of its last sample.
    perturbed_s: start and end of each perturbation.
    guard_s: time after a perturbation that still counts as perturbed.
    before_s, after_s: window around each instant.
    count: number of instants wanted; None for as many as fit.
    Returns: instants (s), increasing.
    """
    length = before_s + after_s
    if not length > 0.0 or (count is not None and count < 1):
        raise InputError(
            f"unperturbed windows: expected a positive length and number, found {length:g} s and {count}: "
            "change before_s and after_s of standing.analysis"
        )
    perturbed = np.asarray(perturbed_s, dtype=float).reshape(-1, 2)
    perturbed = perturbed[np.argsort(perturbed[:, 0])]
    starts = np.concatenate([[0.0], np.maximum.accumulate(perturbed[:, 1] + guard_s)])
    free = np.minimum(np.append(perturbed[:, 0], duration_s), duration_s) - starts
    fitting = np.maximum(0, np.floor(free / length + 1e-9)).astype(int)
    count = max(1, int(fitting.sum())) if count is None else count
    if fitting.sum() < count:
        raise InputError(
            f"unperturbed time: expected {count} windows of {length:g} s, from {guard_s:g} s after each "
            f"perturbation on, found room for {fitting.sum()}: shorten the window or ask for fewer"
        )
    places = []
    for start, slack, fit in zip(starts, free - fitting * length, fitting, strict=True):
        parts = (np.arange(fit) + 0.5) / max(fit, 1) if rng is None else np.sort(rng.uniform(size=fit))
        places.append(start + before_s + np.arange(fit) * length + parts * max(slack, 0.0))
    onsets = np.concatenate(places)
    if rng is None:
        return onsets[((np.arange(count) + 0.5) * onsets.size / count).astype(int)]
    return onsets[np.sort(rng.choice(onsets.size, count, replace=False))]
