"""Alignment of instruments to a fraction of a sample, from signals that both record.

A trigger aligns two instruments to about one sample, but markers may still be sampled with a
latency. Half a millisecond matters: forces change by a tenth within that time. A belt-fixed marker has
the velocity of the belt, which the treadmill logs, so the delay is measured in every trial.

Two clocks also drift apart. The response of a joint to its torque is the same throughout a trial, so a phase
between both that grows with time is the error of a clock (`clock_error`). Samples whose stamps are wrong at
random deviate from their neighbours in proportion to the rate of the signal (`stamp_jitter`).
"""

from typing import Annotated

import numpy as np

from tepsipe.errors import InputError
from tepsipe.signals.differentiation import derivative
from tepsipe.signals.splines import cubic_spline

LONGEST_S = 0.02
# the belt moves above this part of its largest velocity, and a little before and after (s)
MOVING, AROUND_S = 0.05, 0.1
# largest relative error of a clock that is searched, length of the stretches (s), frequencies (Hz)
LARGEST_CLOCK_ERROR, STRETCH_S, CLOCK_BAND_HZ = 5e-3, 10.0, (0.5, 20.0)


def marker_delay(
    time: Annotated[np.ndarray, "(n,)", "s"],
    position: np.ndarray,
    belt_velocity: Annotated[np.ndarray, "(n,)", "m/s"],
    what: str,
) -> float:
    """Time by which the recorded motion of a belt-fixed marker lags behind the logged belt velocity.

    Gauss-Newton on sum (y'(t + delay) - v(t))^2.

    time: instants of both signals.
    position: position of a belt-fixed marker along the belt (m), filtered like the velocity.
    what: names the trial in messages.
    Returns: delay (s), positive where the marker lags behind.
    """
    delay, velocity = 0.0, derivative(time, position)
    if not np.ptp(velocity) > 0.0 or not np.ptp(belt_velocity) > 0.0:
        raise InputError(
            f"{what}: expected a marker and a belt that move, found one that stands still: check the "
            "belt-fixed markers, and that the belt was perturbed"
        )
    spline = cubic_spline(time, velocity)
    for _ in range(6):
        shifted = np.clip(time + delay, time[0], time[-1])
        difference, slope = spline(shifted) - belt_velocity, spline(shifted, 1)
        delay -= float(difference @ slope / (slope @ slope))
        if abs(delay) > LONGEST_S:
            break
    difference = spline(np.clip(time + delay, time[0], time[-1])) - belt_velocity
    # where the belt rests, the difference is noise of the cameras, whatever the marker does
    moving = np.abs(belt_velocity) > MOVING * np.abs(belt_velocity).max()
    width = 2 * round(AROUND_S * (time.size - 1) / (time[-1] - time[0])) + 1
    difference = difference[np.convolve(moving, np.ones(width), "same") > 0.5]
    if abs(delay) > LONGEST_S or difference @ difference > 0.25 * (belt_velocity @ belt_velocity):
        raise InputError(
            f"{what}: expected a marker that follows the belt within {1e3 * LONGEST_S:g} ms, found one that "
            "does not: check the trigger of the motion capture, the direction of the axes, and that the "
            "body does not slip"
        )
    return delay


def advanced(time: np.ndarray, x: np.ndarray, delay_s: float) -> np.ndarray:
    """``x`` advanced by a delay (s), shape (n, ...), at the instants ``time`` (s); ends are held."""
    return cubic_spline(time, x)(np.clip(time + delay_s, time[0], time[-1]))


def common_signal_delay(
    reference: np.ndarray, signal: np.ndarray, rate_hz: float, longest_s: float
) -> tuple[float, float, float]:
    """Delay of a signal relative to another record of the same quantity, from their correlation.

    For every lag, the correlation coefficient of the samples that overlap; the largest absolute value, where
    at least half of the shorter record overlaps, is refined by a parabola through it and its neighbours.

    reference, signal: the two records, sampled from the same instant on; NaN where a sample is missing.
    longest_s: longest delay that is looked for, in either direction.

    Returns:
        delay_s: time by which ``signal`` is late (s).
        correlation: correlation coefficient at this delay; 0 if one of the two does not change.
        gain: slope of the regression of ``reference`` on ``signal`` there (unit of one per unit of the
        other).
    """
    size = reference.size + signal.size
    length = 1 << (size - 1).bit_length()
    finite = [np.isfinite(x) for x in (reference, signal)]
    middle = [
        float(x[k].mean()) if k.any() else 0.0 for x, k in zip((reference, signal), finite, strict=True)
    ]
    x, y = (np.where(k, v - c, 0.0) for v, k, c in zip((reference, signal), finite, middle, strict=True))
    spectra = {key: np.fft.rfft(v, length) for key, v in (("x", x), ("xx", x * x), ("kx", finite[0] * 1.0))}
    other = {key: np.fft.rfft(v, length) for key, v in (("y", y), ("yy", y * y), ("ky", finite[1] * 1.0))}

    most = min(round(longest_s * rate_hz) + 1, max(reference.size, signal.size) - 1)
    lags = np.arange(-most, most + 1)

    def summed(a: str, b: str) -> np.ndarray:
        """Sum over t of a(t) b(t + lag) for all lags."""
        return np.fft.irfft(np.conj(spectra[a]) * other[b], length)[lags]

    count = np.round(summed("kx", "ky"))
    enough = count >= max(3, 0.5 * min(finite[0].sum(), finite[1].sum()))
    n = np.maximum(count, 1.0)
    sx, sy = summed("x", "ky"), summed("kx", "y")
    covariance = summed("x", "y") - sx * sy / n
    of_x, of_y = summed("xx", "ky") - sx**2 / n, summed("kx", "yy") - sy**2 / n
    floor = 1e-9 * max(float(x @ x), 1e-300), 1e-9 * max(float(y @ y), 1e-300)
    usable = enough & (of_x > floor[0]) & (of_y > floor[1])
    r = np.where(usable, covariance / np.sqrt(np.where(usable, of_x * of_y, 1.0)), 0.0)
    k = int(np.argmax(np.abs(r)))
    if r[k] == 0.0:
        return 0.0, 0.0, 0.0
    shift = 0.0
    if 0 < k < lags.size - 1 and usable[k - 1 : k + 2].all():
        before, at, after = np.abs(r[k - 1 : k + 2])
        bend = before - 2.0 * at + after
        shift = 0.5 * float(before - after) / bend if bend < 0.0 else 0.0
    return float(lags[k] + shift) / rate_hz, float(r[k]), float(covariance[k] / of_y[k])


def clock_error(
    torque: Annotated[np.ndarray, "(n,)", "N·m"], angle: Annotated[np.ndarray, "(n,)", "rad"], rate_hz: float
) -> float:
    """Relative error of the clock of a response against the clock of its input.

    The clock is right if the cross-spectra of all stretches of the record have the same phase. The delay that
    grows by e per second turns the cross-spectrum of a stretch at t by exp(-2 pi j f e t). The largest

        sum over f of |sum over stretches of C(f, t) exp(2 pi j f e t)|

    is searched on a grid, and refined by a parabola.

    Returns: e, positive if the clock of the response is fast; 0 for a record of less than two stretches.
    """
    length = round(STRETCH_S * rate_hz)
    count = torque.size // length
    if count < 2:
        return 0.0
    frequency = np.fft.rfftfreq(length, 1.0 / rate_hz)
    lines = (frequency >= CLOCK_BAND_HZ[0]) & (frequency <= CLOCK_BAND_HZ[1])
    spectra = [
        np.fft.rfft(x[: count * length].reshape(count, length), axis=1)[:, lines] for x in (torque, angle)
    ]
    cross = spectra[1] * spectra[0].conj()
    # every frequency by its own strength, or the resonance decides alone
    cross /= np.sqrt(np.mean(np.abs(cross) ** 2, axis=0)) + np.finfo(float).tiny
    step = 0.1 / (CLOCK_BAND_HZ[1] * count * STRETCH_S)
    tried = step * np.arange(-round(LARGEST_CLOCK_ERROR / step), round(LARGEST_CLOCK_ERROR / step) + 1)
    turns = 2j * np.pi * np.outer(STRETCH_S * np.arange(count), frequency[lines])
    agreement = np.array([np.abs((cross * np.exp(e * turns)).sum(axis=0)).sum() for e in tried])
    k = int(np.clip(np.argmax(agreement), 1, tried.size - 2))
    before, at, after = agreement[k - 1 : k + 2]
    bend = before - 2.0 * at + after
    return float(tried[k] + (step * 0.5 * (before - after) / bend if bend < 0.0 else 0.0))


def stamp_jitter(time: np.ndarray, x: np.ndarray) -> float:
    """Standard deviation of the errors of time stamps (s).

    Every sample is predicted by the cubic through two samples on either side. Noise of the signal adds the
    same variance everywhere; an error of the stamps adds one in proportion to the squared rate of change.

    time: stamps (s), increasing.
    x: samples, at a rate of several times the frequency of the signal.
    Returns: standard deviation (s), 0 if it does not grow with the rate of change.
    """
    middle = time[2:-2]
    around = np.stack([time[k : time.size - 4 + k] for k in (0, 1, 3, 4)])
    weights = np.ones_like(around)
    for i in range(4):
        for j in set(range(4)) - {i}:
            weights[i] *= (middle - around[j]) / (around[i] - around[j])
    predicted = sum(w * x[k : x.size - 4 + k] for w, k in zip(weights, (0, 1, 3, 4), strict=True))
    gain = 1.0 + (weights**2).sum(axis=0)
    usable = gain < np.median(gain) * 2.0
    squares = ((x[2:-2] - predicted) ** 2 / gain)[usable]
    # over the two samples on either side, whose own errors matter less
    rate = ((x[4:] - x[:-4]) / (time[4:] - time[:-4]))[usable] ** 2
    quick = rate > np.median(rate)
    if not quick.any():
        return 0.0
    # a signal in steps is exact while it rests and errs by their twelfth while it moves
    steps = np.diff(np.unique(x)).min(initial=np.inf)
    rise = np.mean(squares[quick]) - np.mean(squares[~quick]) - steps**2 / 12.0
    spread = np.mean(rate[quick]) - np.mean(rate[~quick])
    return float(np.sqrt(max(rise / spread, 0.0))) if spread > 0.0 else 0.0
