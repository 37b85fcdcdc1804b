"""Faults of recorded signals: spikes, held and clipped samples, and filters.

At rest, white noise of an instrument has the same power at all frequencies. A signal that was filtered before
has lost it above the cutoff. The ratio of powers at high and low frequencies is compared between the signals.
"""

from typing import Annotated

import numpy as np
import scipy

# a spike exceeds its neighbours by this many standard deviations, and this part of the signal's range; a jump
# after samples that were held exceeds both, too; and clipping cuts off this part
SPIKE_SD, SPIKE_PART, JUMP_SD, JUMP_PART, CLIPPED_PART = 12.0, 0.05, 5.0, 0.05, 0.02
# fewer pairs of equal samples are chance in coarsely quantised signals
FEWEST_PAIRS = 5
# power at high frequencies relative to that at low ones (dB): of a filtered signal, and least difference to
# the other signal
FILTERED_DB, APART_DB = -40.0, 20.0
# the former for a signal that moves, whose power at low frequencies is large
FILTERED_MOVING_DB = -85.0
# low and high frequencies, the latter relative to the sampling rate
LOW_HZ, HIGH_PART = 5.0, (0.35, 0.45)
# middle frequencies relative to the sampling rate, from which the power of a filtered signal falls on (dB)
MIDDLE_PART, FALLS_ON_DB = (0.15, 0.25), -12.0


def of_samples(**signals: np.ndarray) -> tuple[str, ...]:
    """Sentences on spikes, held and clipped samples of recorded signals, shape (n,), by name."""
    found = []
    for name, x in signals.items():
        for count_faults, what, advice in FAULTS.values():
            if count := count_faults(x):
                found.append(f"The {name} has {count} {what}: estimates may be wrong. {advice}.")
    return tuple(found)


def flags_of(
    rate_hz: float, at_rest: Annotated[np.ndarray, "(n,)"] | None, **signals: np.ndarray
) -> tuple[str, ...]:
    """Faults that any of several signals has, names in `tepsipe.flags.FLAGS`.

    rate_hz: rate of the recording.
    at_rest, signals: as for `noise_floors`.
    """
    filtered = ("filtered-signal",) * bool(noise_floors(at_rest, rate_hz, **signals))
    return sample_flags(*signals.values()) + filtered


def sample_flags(*signals: np.ndarray) -> tuple[str, ...]:
    """Spikes, held and clipped samples of any of several signals, names in `tepsipe.flags.FLAGS`."""
    return tuple(name for name, (count, *_) in FAULTS.items() if any(count(x) for x in signals))


def spikes(x: np.ndarray) -> int:
    """Number of samples that lie far from the cubic through their four neighbours, which are close to it."""
    error = _from_neighbours(x)
    size = np.abs(error)
    limit = max(SPIKE_SD * 1.4826 * float(np.median(size)), SPIKE_PART * float(np.ptp(x)))
    # a spike errs by its height, its neighbours by 2/3 of it in the opposite direction, and these are close
    # together, other than in a fast movement
    peak = (size[1:-1] > limit) & (size[1:-1] >= size[:-2]) & (size[1:-1] > size[2:])
    alone = (error[1:-1] * error[:-2] < 0.0) & (error[1:-1] * error[2:] < 0.0)
    beside = np.stack([x[1:-5], x[2:-4], x[4:-2], x[5:-1]])
    return int(np.sum(peak & alone & (np.ptp(beside, axis=0) < 0.5 * size[1:-1])))


def _from_neighbours(x: np.ndarray) -> np.ndarray:
    """Distance of each sample from the cubic through its four neighbours (unit of x), shape (n - 4,)."""
    return x[2:-2] - (4.0 * (x[1:-3] + x[3:-1]) - x[:-4] - x[4:]) / 6.0


def held(x: np.ndarray) -> int:
    """Number of times that a moving signal repeats one value and then jumps.

    Three equal samples and a jump count, or two after and before jumps, of `JUMP_PART` of the range and
    `JUMP_SD` of the noise: rounded noise repeats values, too. The noise is that of samples that differ from
    both neighbours.
    """
    steps = np.diff(x)
    moves = (steps[1:-2] != 0.0) & (steps[2:-1] != 0.0)
    noise = 1.4826 * float(np.median(np.abs(_from_neighbours(x)[moves]))) if moves.any() else 0.0
    jump = max(JUMP_PART * float(np.ptp(x)), JUMP_SD * noise)
    starts = np.concatenate([[0], np.flatnonzero(steps != 0.0) + 1])
    lengths = np.diff(np.concatenate([starts, [x.size]]))
    into = np.abs(np.concatenate([[0.0], steps[starts[1:] - 1]])) > jump
    out = np.concatenate([into[1:], [False]])
    long, pairs = int(np.sum((lengths > 2) & out)), int(np.sum((lengths == 2) & into & out))
    return long + (pairs if pairs >= FEWEST_PAIRS else 0)


def clipped(x: np.ndarray) -> int:
    """Number of times that a signal stays at its own maximum or minimum although it approaches it fast.

    It would have gone on by about half the time there times its slope: by `CLIPPED_PART` of its range.
    """
    count, steps = 0, np.abs(np.diff(x))
    quantum = float(steps[steps > 0.0].min(initial=np.inf))
    for limit in (x.max(), x.min()):
        at = np.concatenate([[False], x == limit, [False]]).astype(int)
        edges = np.flatnonzero(np.diff(at))
        for start, stop in zip(edges[::2], edges[1::2], strict=True):
            if stop - start > 2 and start > 1:
                slope = abs(x[start - 1] - x[start - 2]) - 4.0 * quantum
                count += slope * (stop - start) > 2.0 * CLIPPED_PART * np.ptp(x)
    return int(count)


def noise_floors(
    at_rest: Annotated[np.ndarray, "(n,)"] | None, rate_hz: float, **signals: np.ndarray
) -> tuple[str, ...]:
    """Names of signals that were probably filtered before, while another one was not.

    at_rest: samples at rest; None for a record of continuous movement, in which an ``angle`` is never named.
    signals: by name, as recorded, shape (n,).
    """
    still = np.ones(len(next(iter(signals.values()))), dtype=bool) if at_rest is None else at_rest
    edges = np.flatnonzero(np.diff(np.concatenate([[False], still, [False]]).astype(int)))
    start, stop = max(zip(edges[::2], edges[1::2], strict=True), key=lambda span: span[1] - span[0])
    length = min(stop - start, round(rate_hz))
    if stop - start < rate_hz or HIGH_PART[0] * rate_hz < 3.0 * LOW_HZ:
        return ()
    falls, slopes = {}, {}
    for name, x in signals.items():
        # the quietest second counts, because a joint that still moves has power at low frequencies
        frequency, _, power = scipy.signal.spectrogram(
            x[start:stop], rate_hz, "blackmanharris", length, length // 2, detrend="linear"
        )
        low = (frequency >= 2.0) & (frequency <= LOW_HZ)
        high = (frequency >= HIGH_PART[0] * rate_hz) & (frequency <= HIGH_PART[1] * rate_hz)
        middle = (frequency >= MIDDLE_PART[0] * rate_hz) & (frequency <= MIDDLE_PART[1] * rate_hz)
        of_low, of_middle, of_high = (np.median(power[band], axis=0) for band in (low, middle, high))
        if not of_low.min() > 0.0 or not of_middle.min() > 0.0:
            return ()
        quietest = int(np.argmin(of_low))
        falls[name] = 10.0 * np.log10(of_high[quietest] / of_low[quietest] + 1e-30)
        # white noise has the same power at middle frequencies, however much the joint moves at low ones
        slopes[name] = 10.0 * np.log10(of_high[quietest] / of_middle[quietest] + 1e-30)
        if slopes[name] > FALLS_ON_DB:
            falls[name] = max(falls[name], FILTERED_DB)
    most, limit = max(falls.values()), FILTERED_MOVING_DB if at_rest is None else FILTERED_DB
    found = {name for name, fall in falls.items() if fall < limit and fall < most - APART_DB}
    if at_rest is None:
        # where both signals move alike, the filtered one falls on and the other does not
        flattest = max(slopes.values())
        steep = {name for name, slope in slopes.items() if slope < min(FALLS_ON_DB, flattest + FALLS_ON_DB)}
        found |= {name for name in steep if falls[name] < FILTERED_DB and flattest > FALLS_ON_DB}
        # a movement that a machine imposes may itself vanish at high frequencies
        found.discard("angle")
    return tuple(name for name in falls if name in found)


# flag -> function that counts a fault, its meaning, and what to do
FAULTS = {
    "spikes": (spikes, "single samples far from their neighbours", "Remove them, and check cables"),
    "held-samples": (held, "values that are held and then jump", "Look for lost samples, or a slower clock"),
    "clipped": (clipped, "peaks that are cut off at one value", "Choose a larger range of the instrument"),
}
