"""Properties measured from signals alone: pulses and rests, followers of the belt, periods, signs."""

from dataclasses import dataclass

import numpy as np

PULSE_FRACTION = 0.2  # of the peak speed
# a speed above so many standard deviations of noise is a pulse; its peak must be twice as large
CLEAR_SD, CLEARLY = 5.0, 2.0
BEFORE_S, AFTER_S = 0.1, 0.3  # part of a path around the begin of a pulse
NEW_PULSE_S = 0.5  # shortest time between two pulses
SMOOTH_S = 0.02
LONG_S = 0.04
FEWEST = 20  # samples that show a sign
LEAST_WORK = 0.05  # correlation of torque and velocity from which it shows the sign of the torque
FOLLOWS = 0.9  # correlation from which a marker follows the belt


@dataclass(frozen=True)
class Pulses:
    """Pulses of the belt."""

    count: int
    """Number."""
    first_s: float
    last_s: float
    """Begin of the first and end of the last."""
    shortest_s: float
    """Shortest time from one begin to the next (s); NaN for fewer than two."""
    begins_s: np.ndarray
    """Begin of each."""


def pulses_of(velocity: np.ndarray, rate_hz: float) -> Pulses | None:
    """Pulses of a belt that is at rest between them and stand out from noise, or None if there are none."""
    speed = np.abs(averaged(velocity - np.nanmedian(velocity), rate_hz, LONG_S))
    peak, noise = float(np.nanmax(speed)), 1.4826 * float(np.nanmedian(speed))
    least = max(PULSE_FRACTION * peak, CLEAR_SD * noise)
    active = np.flatnonzero(speed > least)
    if not peak > 0.0 or peak < CLEARLY * least or active.size > 0.3 * speed.size:
        return None
    begins = active[np.concatenate(([True], np.diff(active) > NEW_PULSE_S * rate_hz))] / rate_hz
    shortest = float(np.diff(begins).min()) if begins.size > 1 else np.nan
    return Pulses(int(begins.size), float(begins[0]), float(active[-1] / rate_hz), shortest, begins)


def rests(pulses: Pulses, duration_s: float) -> tuple[float, float]:
    """Unperturbed time before the first pulse, and after the decay of the last (s), rounded down to 0.1 s."""
    after = duration_s - pulses.last_s
    decay = min(0.5 * after, pulses.shortest_s if np.isfinite(pulses.shortest_s) else 0.5 * after)
    return (
        max(0.1, np.floor(10.0 * (pulses.first_s - 0.1)) / 10.0),
        max(0.1, np.floor(10.0 * (after - decay)) / 10.0),
    )


def moves_with(
    position: np.ndarray, velocity: np.ndarray, rate_hz: float, pulses: Pulses
) -> tuple[float, float]:
    """Correlation of a marker's path with the belt's in all pulses, and the ratio of the two paths.

    Noise of a position hides a velocity, but not a path of some millimetres.

    position: of the marker along the belt, shape (n,), NaN filled by straight lines (m).
    velocity: of the belt at the same instants (m/s).
    """
    time, finite = np.arange(position.size), np.isfinite(position)
    paths = np.column_stack(
        [np.interp(time, time[finite], position[finite]), np.cumsum(velocity - np.median(velocity)) / rate_hz]
    )
    before, after = round(BEFORE_S * rate_hz), round(AFTER_S * rate_hz)
    starts = np.round(pulses.begins_s * rate_hz).astype(int)
    parts = [paths[k - before : k + after] for k in starts if before <= k <= position.size - after]
    if not parts:
        return 0.0, 0.0
    rest = slice(0, max(1, before // 2))
    of_marker, of_belt = np.concatenate([part - part[rest].mean(axis=0) for part in parts]).T
    both, power = float(of_marker @ of_belt), float(of_belt @ of_belt)
    if not (power > 0.0 and of_marker.any()):
        return 0.0, 0.0
    return both / np.sqrt(power * float(of_marker @ of_marker)), both / power


def smooth_velocity(position: np.ndarray, rate_hz: float) -> np.ndarray:
    """Velocity of a position, shape (n,), NaN filled by straight lines, averaged over `SMOOTH_S` (unit/s)."""
    time = np.arange(position.size)
    finite = np.isfinite(position)
    filled = np.interp(time, time[finite], position[finite])
    return averaged(np.gradient(filled) * rate_hz, rate_hz)


def averaged(values: np.ndarray, rate_hz: float, over_s: float = SMOOTH_S) -> np.ndarray:
    """Moving average over a time (s), in the unit of ``values``."""
    width = max(1, round(over_s * rate_hz))
    return np.convolve(values, np.full(width, 1.0 / width), mode="same")


def at_frames(values: np.ndarray, rate_hz: float, frames: int, frame_rate_hz: float) -> np.ndarray:
    """A channel at the instants of frames, shape (frames,), averaged as `smooth_velocity`."""
    smooth = averaged(values, rate_hz)
    return np.interp(np.arange(frames) / frame_rate_hz, np.arange(values.size) / rate_hz, smooth)


def follows(velocity: np.ndarray, other: np.ndarray) -> tuple[float, float]:
    """Correlation of two signals, and the first per unit of the second (units of both).

    Delays of up to three samples are tried.
    """
    best = (0.0, 0.0)
    for shift in range(-3, 4):
        a = velocity[3 + shift : velocity.size - 3 + shift]
        b = other[3:-3] - np.median(other)
        a = a - np.median(a)
        power = float(b @ b)
        if power > 0.0 and a @ a > 0.0:
            r = float(a @ b / np.sqrt(power * (a @ a)))
            if abs(r) > abs(best[0]):
                best = (r, float(a @ b) / power)
    return best


def scale_of(velocity: np.ndarray, other: np.ndarray, rate_hz: float) -> float:
    """First signal per unit of the second (units of both), at the delay at which they agree best.

    Both are averaged over `LONG_S`, so that the noise of the second biases the ratio little.

    velocity, other: two records of one motion, of any units.
    """
    width = max(1, round(LONG_S * rate_hz))
    kernel = np.full(width, 1.0 / width)
    a, b = (np.convolve(x - np.median(x), kernel, mode="same") for x in (velocity, other))
    time = np.arange(a.size)
    inside = slice(width, -width)
    best = (0.0, 0.0)
    for delay in np.arange(-0.02, 0.0201, 0.0005) * rate_hz:
        c = np.interp(time - delay, time, b)[inside]
        both = float(a[inside] @ c)
        r = both / np.sqrt(float(a[inside] @ a[inside]) * float(c @ c))
        if abs(r) > abs(best[0]):
            best = (r, both / float(c @ c))
    return best[1]


def period_s(values: np.ndarray, rate_hz: float) -> float | None:
    """Period after which a signal repeats itself exactly, or None (s)."""
    n = values.size
    scale = float(np.std(values))
    if not scale > 0.0:
        return None
    centred = values - values.mean()
    spectrum = np.abs(np.fft.rfft(centred, 2 * n)) ** 2
    correlation = np.fft.irfft(spectrum)[:n] / np.arange(n, 0, -1)
    low = round(0.5 * rate_hz)
    candidates = low + np.argsort(correlation[low : n - round(rate_hz) + 1])[::-1][:50]
    for lag in sorted(candidates):
        if np.sqrt(np.mean((values[lag:] - values[:-lag]) ** 2)) < 0.01 * scale:
            return float(lag / rate_hz)
    return None


def resisting_sign(angle: np.ndarray, torque: np.ndarray, rate_hz: float) -> int:
    """Sign of the torque that resists a positive angle: the sign of K in a regression of the torque.

    The torque is regressed on angle, velocity and acceleration, all averaged over `SMOOTH_S`; 1 for too few
    samples.
    """
    finite = np.isfinite(angle) & np.isfinite(torque)
    if finite.sum() < FEWEST:
        return 1
    theta, tau = averaged(angle[finite], rate_hz), averaged(torque[finite], rate_hz)
    velocity = np.gradient(theta)
    design = np.column_stack([theta, velocity, np.gradient(velocity), np.ones_like(theta)])
    edge = slice(5, -5)
    coefficients = np.linalg.lstsq(design[edge], tau[edge], rcond=None)[0]
    return 1 if coefficients[0] >= 0.0 else -1


def driving_sign(angle: np.ndarray, torque: np.ndarray, rate_hz: float) -> int:
    """Sign of the torque that moves a joint whose angle is imposed: it does work on a passive joint.

    Slow torque of a person, which can be larger than that of stiffness, does little work. Where torque and
    velocity are not correlated, it is `resisting_sign`.
    """
    finite = np.isfinite(angle) & np.isfinite(torque)
    if finite.sum() < FEWEST:
        return 1
    velocity = np.gradient(averaged(angle[finite], rate_hz))[5:-5]
    tau = averaged(torque[finite], rate_hz)[5:-5]
    tau = tau - tau.mean()
    work = velocity @ tau / max(np.linalg.norm(velocity) * np.linalg.norm(tau), np.finfo(float).tiny)
    return (1 if work > 0.0 else -1) if abs(work) > LEAST_WORK else resisting_sign(angle, torque, rate_hz)


def is_two_levels(values: np.ndarray) -> bool:
    """Test for a channel that is a digital line: low or high, and rarely anything between."""
    low, high = float(np.nanmin(values)), float(np.nanmax(values))
    if not high > low:
        return False
    level = (values - low) / (high - low)
    return float(np.mean((level > 0.2) & (level < 0.8))) < 0.002
