"""Markers that do not move with the body they sit on: a leg that bends or wobbles, and tape that gives."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated

import numpy as np
import scipy

from tepsipe.quantities import Frequency, Height, NotNegative, Time
from tepsipe.virtual_lab.motion_capture import MarkerPath

Shift = Callable[[np.ndarray], np.ndarray]


@dataclass(frozen=True)
class Wobble:
    """Hidden constants of a mass that lags behind an accelerated leg, d'' + 2 z w d' + w² d = -a."""

    hz: Annotated[Frequency, "Hz"]  # w / 2 pi
    """Natural frequency."""
    damping: NotNegative  # z
    """Damping ratio."""
    common: float
    """Fraction of the mass's displacement by which all markers of the leg move; 0 in both is a rigid leg."""
    growing_per_m: Annotated[float, "1/m"]
    """The same per distance from the joint."""


@dataclass(frozen=True)
class Slip:
    """The tape of a marker gives in every pulse, by a random step that stays."""

    foot_m: Height
    """Standard deviation of the step of the markers on the foot; 0 is a marker that holds."""
    ankle_m: Height
    """The same of the marker on the ankle."""
    settling_s: Time
    """Time constant of a step."""


def wobbling(wobble: Wobble, time: np.ndarray, acceleration: np.ndarray) -> np.ndarray:
    """Lag d of a wobbling mass behind an accelerated body.

    time, acceleration: regular instants (s) and acceleration of the body (m/s²).
    Returns: d (m), 0 at first.
    """
    natural = 2.0 * np.pi * wobble.hz
    mass = ([-1.0], [1.0, 2.0 * wobble.damping * natural, natural**2])
    numerator, denominator, _ = scipy.signal.cont2discrete(mass, time[1] - time[0], method="bilinear")
    return scipy.signal.lfilter(np.ravel(numerator), denominator, acceleration)


def slipping(
    step_m: float, settling_s: float, onsets_s: Annotated[np.ndarray, "(k,)"], rng: np.random.Generator
) -> Shift:
    """Steps of one marker, a random one at each onset.

    step_m, settling_s: standard deviation of a step (m) and its time constant (s).
    onsets_s: onsets of the pulses.
    Returns: displacement, shape (n,), at instants, shape (n,).
    """
    steps = step_m * rng.standard_normal(onsets_s.size)

    def shift(instant: np.ndarray) -> np.ndarray:
        since = np.maximum(instant[:, None] - onsets_s, 0.0) / settling_s
        return (1.0 - np.exp(-since)) @ steps

    return shift


def shifted(path: MarkerPath, shift: Shift) -> MarkerPath:
    """The path, moved forwards by a displacement (m) at every instant (s)."""

    def moved_path(instant: np.ndarray) -> np.ndarray:
        positions = path(instant)
        positions[:, 1] += shift(instant)
        return positions

    return moved_path
