"""Faults of single samples: spikes, held and clipped values."""

import numpy as np

# a spike exceeds its neighbours by this many standard deviations, and this part of the signal's range; a jump
# after samples that were held, this part; and clipping cuts off this part
SPIKE_SD, SPIKE_PART, JUMP_PART, CLIPPED_PART = 12.0, 0.05, 0.05, 0.02
# fewer pairs of equal samples are chance in coarsely quantised signals
FEWEST_PAIRS = 5


def of_samples(**signals: np.ndarray) -> tuple[str, ...]:
    """Sentences on spikes, held and clipped samples of recorded signals, shape (n,), by name."""
    found = []
    for name, x in signals.items():
        for count, what, advice in (
            (spikes(x), "single samples far from their neighbours", "Remove them, and check cables"),
            (held(x), "values that are held and then jump", "Look for lost samples, or a slower clock"),
            (clipped(x), "peaks that are cut off at one value", "Choose a larger range of the instrument"),
        ):
            if count:
                found.append(f"The {name} has {count} {what}: estimates may be wrong. {advice}.")
    return tuple(found)


def spikes(x: np.ndarray) -> int:
    """Number of samples that lie far from the cubic through their four neighbours, which are close to it."""
    error = x[2:-2] - (4.0 * (x[1:-3] + x[3:-1]) - x[:-4] - x[4:]) / 6.0
    size = np.abs(error)
    limit = max(SPIKE_SD * 1.4826 * float(np.median(size)), SPIKE_PART * float(np.ptp(x)))
    # a spike errs by its height, its neighbours by 2/3 of it in the opposite direction, and these are close
    # together, other than in a fast movement
    peak = (size[1:-1] > limit) & (size[1:-1] >= size[:-2]) & (size[1:-1] > size[2:])
    alone = (error[1:-1] * error[:-2] < 0.0) & (error[1:-1] * error[2:] < 0.0)
    beside = np.stack([x[1:-5], x[2:-4], x[4:-2], x[5:-1]])
    return int(np.sum(peak & alone & (np.ptp(beside, axis=0) < 0.5 * size[1:-1])))


def held(x: np.ndarray) -> int:
    """Number of times that a moving signal repeats one value and then jumps.

    Three equal samples and a jump of `JUMP_PART` of the range count, or two after and before such jumps.
    """
    jump = JUMP_PART * float(np.ptp(x))
    steps = np.diff(x)
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
