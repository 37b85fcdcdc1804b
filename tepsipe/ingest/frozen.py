"""Stretches in which a channel repeats itself although it should be noisy.

A channel whose median step is hardly larger than its smallest one is quantised: identical neighbours are
common in it. In all other channels noise changes every sample. In public C3D files the longest run of
one position in all coordinates is 20 ms; the longest run of one value in a force channel, exact zeros
excluded, is 39 ms.
"""

from typing import Annotated

import numpy as np

from tepsipe.signals.resampling import runs_of

# a channel is quantised if the median of its steps is at most this many times the smallest
QUANTISED_STEPS = 3.0
# smallest change of a signal while another one is held, as a fraction of its whole range
MOVING_RANGE = 0.2
# a held signal changes by less than this fraction of its whole range
HELD_RANGE = 1e-6


def frozen_stretch(
    values: Annotated[np.ndarray, "(n, c)"],
    rate_hz: float,
    longest_s: float,
    ignored: np.ndarray | None = None,
) -> tuple[int, int] | None:
    """Longest stretch of identical samples, if it is implausible for a noisy channel.

    values: components of one channel; a sample is repeated if all of them are.
    longest_s: longest stretch that is accepted.
    ignored: samples that were not measured.
    Returns: first sample and the first after it (samples); None if there is no such stretch, or if all
    components are quantised.
    """
    steps = np.abs(np.diff(values, axis=0))
    repeated = (steps == 0.0).all(axis=1)
    if ignored is not None:
        repeated &= ~(ignored[1:] | ignored[:-1])
    runs = runs_of(repeated)
    if not runs:
        return None
    start, stop = max(runs, key=lambda run: run[1] - run[0])
    if stop + 1 - start < max(3, round(longest_s * rate_hz)) or all(map(_quantised, steps.T)):
        return None
    return start, stop + 1


def _quantised(steps: np.ndarray) -> bool:
    """Test for a component whose median step is about as small as its smallest."""
    taken = steps[steps > 0.0]
    return bool(taken.size and np.median(taken) <= QUANTISED_STEPS * taken.min())


def held_while_moving(
    values: np.ndarray, others: np.ndarray, rate_hz: float, longest_s: float
) -> tuple[int, int] | None:
    """First stretch in which one signal is held although another one moves.

    values, others: signal that may be held, and the one that moves it.
    longest_s: longest stretch that is accepted.
    Returns: first sample and the first after it (samples), or None.
    """
    size, other = float(np.ptp(values)), float(np.ptp(others))
    held = np.abs(np.diff(values)) <= HELD_RANGE * size
    for start, stop in runs_of(held):
        long_enough = stop + 1 - start >= max(3, round(longest_s * rate_hz))
        if long_enough and np.ptp(others[start : stop + 1]) > MOVING_RANGE * other:
            return start, stop + 1
    return None
