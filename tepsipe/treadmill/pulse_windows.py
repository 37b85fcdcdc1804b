"""Mean pulse of a trial, aligned to a fraction of a sample, and the state of bristle friction in it.

The pulses of one trial are alike: the belt follows the same command, and what differs is noise. The mean over
the pulses, aligned to a fraction of a sample, has less noise, which matters for friction with memory:
noise in the velocity would release the bristles. Bristles between belt and deck are deflected by z:

    d z' = w - |w| z / g(w),    g(w) = 1 + u exp(-(w / v_s)^2)

Here w is the velocity of the belt at the friction surface, d the pre-sliding distance, and u the excess of
friction at rest over that in motion, which ends at the speed v_s (Canudas de Wit et al. 1995; Dahl 1968 for
u = 0).

Between pulses the belt rests and the bristles stay as they are: a pulse begins where the last one ended.
"""

from dataclasses import dataclass, replace
from typing import Annotated

import numpy as np
import scipy

from tepsipe.errors import InputError
from tepsipe.signals.perturbations import same_direction
from tepsipe.treadmill.recording import BeltRecording

BEFORE_S, AFTER_S, BACK_S = 0.2, 0.8, 0.4  # window of a pulse, and the ramp back that makes it periodic
MOVING_S = 0.6  # time from its onset in which a pulse moves the belt
# a load that swings after a pulse moves the belt within the pre-sliding distance: the mean is extended
LONGEST_S = 2.2
FINER = 2  # steps of the bristles per sample
ALIGNMENTS = 3
ALIKE = 0.05  # largest deviation of a pulse from the mean of its trial, relative to that mean (rms)


@dataclass(frozen=True)
class Bristles:
    """Constants of the bristles."""

    distance_m: float
    """Pre-sliding distance d."""
    stribeck: float
    """Excess of friction at rest u."""
    stribeck_speed_m_per_s: float


@dataclass(frozen=True)
class Pulses:
    """Motion of the belt in the pulses of one trial."""

    rate_hz: float
    """Sampling rate of the trial."""
    start: Annotated[np.ndarray, "(pulses,)"]
    """First sample of each window (samples)."""
    ramp: Annotated[np.ndarray, "(w,)"]
    """1 inside the window, and then back to 0."""
    velocity: Annotated[np.ndarray, "(pulses, w * FINER)", "m/s"]
    acceleration: Annotated[np.ndarray, "(pulses, w * FINER)", "m/s²"]
    """Unfiltered motion of the belt in steps of 1 / (FINER rate_hz), zero outside the pulse."""


@dataclass(frozen=True)
class PulseWindows:
    """Mean pulse of several trials, each in a periodic window."""

    rate_hz: float
    names: tuple[str, ...]
    """Recordings, in the order of the rows."""
    kg: Annotated[np.ndarray, "(trials,)"]
    count: Annotated[np.ndarray, "(trials,)"]
    """Mass of the weight (kg) and number of pulses."""
    height_m: Annotated[np.ndarray, "(trials,)"]
    """Height of the weight's centre of mass above the belt."""
    velocity: Annotated[np.ndarray, "(trials, n)", "m/s"]
    acceleration: Annotated[np.ndarray, "(trials, n)", "m/s²"]
    """Filtered mean motion of the belt."""
    fine_velocity: Annotated[np.ndarray, "(trials, n * FINER)", "m/s"]
    fine_acceleration: Annotated[np.ndarray, "(trials, n * FINER)", "m/s²"]
    """Unfiltered mean motion."""
    load: dict[str, np.ndarray]
    carried: dict[str, np.ndarray]
    """Component -> mean measured load less the load carried, and load carried (N, N·m), shape (trials, n)."""
    single: dict[str, list[np.ndarray]]
    """Component -> measured load less the load carried of every pulse (N, N·m), shape (pulses, n)."""
    evaluated: Annotated[np.ndarray, "(trials, n)"]
    """Samples that are fitted."""
    lowpass: Annotated[np.ndarray, "(n // 2 + 1,)"]
    """Gain of the recordings' zero-lag filter at the frequencies of the window."""
    ramp: np.ndarray
    """1 inside the window, and then back to 0."""

    @property
    def samples(self) -> int:
        """Length n of a window (samples)."""
        return self.velocity.shape[1]

    @property
    def s(self) -> np.ndarray:
        """Imaginary angular frequencies of a window (rad/s), shape (n // 2 + 1,)."""
        return 2j * np.pi * np.fft.rfftfreq(self.samples, 1.0 / self.rate_hz)


def pulse_windows(trials: list[dict[str, BeltRecording]], *, whole: bool = False) -> PulseWindows:
    """Mean pulse of every trial.

    trials: for each trial component Fy or Mx -> its recording, all with the same zero-lag filter.
    whole: whether the windows last until the next pulse, or as long as a fit needs.
    """
    first = trials[0]["Fy"]
    rate = first.rate_hz
    after_s = min(longest_window(trial["Fy"]) for trial in trials) if whole else AFTER_S
    samples, ramp = _ramp(rate, after_s)
    if first.lowpass is None or not first.lowpass.zero_lag:
        raise InputError(
            f"{first.name}: expected signals filtered forward and backward, found {first.lowpass}: use a "
            "zero-lag low-pass"
        )
    sections = scipy.signal.butter(first.lowpass.order // 2, first.lowpass.cutoff_hz, fs=rate, output="sos")
    frequencies = np.fft.rfftfreq(samples, 1.0 / rate)
    gain = np.abs(scipy.signal.sosfreqz(sections, worN=frequencies, fs=rate)[1]) ** 2
    rows: dict[str, list] = {
        key: [] for key in ("velocity", "acceleration", "Fy", "Mx", "carried Fy", "carried Mx")
    }
    fine, single, evaluated = [], {"Fy": [], "Mx": []}, []
    for trial in trials:
        force = trial["Fy"]
        at = _window_samples(force, samples)
        delays = _delays(force.velocity[at] * ramp)
        moving = {"velocity": force.velocity, "acceleration": force.acceleration}
        loads = {c: r.load for c, r in trial.items()} | {f"carried {c}": r.carried for c, r in trial.items()}
        for key, x in (moving | loads).items():
            parts = x[at]
            if key not in moving:
                parts = parts - parts[:, : round(0.8 * BEFORE_S * rate)].mean(axis=1, keepdims=True)
            parts = _shifted(parts * ramp, delays)
            rows[key].append(parts.mean(axis=0))
            if key in single:
                single[key].append(parts)
        mean = _shifted(force.raw_velocity[at] * ramp, delays).mean(axis=0)
        fine.append(_fine(mean[None, :], rate, after_s if whole else MOVING_S))
        evaluated.append(force.evaluated[at[0]])
    return PulseWindows(
        rate_hz=rate,
        names=tuple(t["Fy"].name for t in trials),
        kg=np.array([t["Fy"].carried_kg for t in trials]),
        count=np.array([float(len(t["Fy"].onsets)) for t in trials]),
        height_m=np.array([t["Fy"].rigid_height_m for t in trials]),
        velocity=np.array(rows["velocity"]),
        acceleration=np.array(rows["acceleration"]),
        fine_velocity=np.concatenate([v for v, _ in fine]),
        fine_acceleration=np.concatenate([a for _, a in fine]),
        load={c: np.array(rows[c]) for c in single},
        carried={c: np.array(rows[f"carried {c}"]) for c in single},
        single=single,
        evaluated=np.array(evaluated),
        lowpass=gain,
        ramp=ramp,
    )


def by_direction(trials: list[dict[str, BeltRecording]]) -> list[dict[str, BeltRecording]]:
    """Trials with the pulses of each direction of the belt apart, whose means would cancel (N, N·m).

    trials: for each trial component Fy or Mx -> recording.
    Returns: trials of one direction as they are, in the same order.
    """
    parts = []
    for trial in trials:
        force = trial["Fy"]
        alike = same_direction(force.velocity[_window_samples(force, round(MOVING_S * force.rate_hz))])
        if alike.all():
            parts.append(trial)
            continue
        for kept, way in ((alike, ""), (~alike, ", opposite")):
            onsets = tuple(np.array(force.onsets)[kept].tolist())
            parts.append({c: replace(r, name=f"{r.name}{way}", onsets=onsets) for c, r in trial.items()})
    return parts


def longest_window(recording: BeltRecording) -> float:
    """Longest time from the onset that belongs to a pulse, at most until the next pulse (s)."""
    ends = [*recording.onsets, recording.load.size]
    apart_s = np.diff(ends).min(initial=recording.load.size) / recording.rate_hz
    return float(np.clip(apart_s - 2.0 * BEFORE_S, MOVING_S, LONGEST_S))


def pulses_of(recording: BeltRecording) -> Pulses:
    """Motion of the belt in the pulses of a trial: their mean, or each pulse if they are not alike."""
    rate = recording.rate_hz
    after_s = longest_window(recording)
    samples, ramp = _ramp(rate, after_s)
    at = _window_samples(recording, samples)
    core = _ramp(rate, MOVING_S)
    pulse = recording.velocity[at[:, : core[0]]] * core[1]
    delays = _delays(pulse)
    aligned = _shifted(pulse, delays)
    mean = aligned.mean(axis=0)
    alike = np.sqrt(np.mean((aligned - mean) ** 2)) < ALIKE * np.sqrt(np.mean(mean**2))
    raw = recording.raw_velocity[at] * ramp
    if alike:
        raw = _shifted(np.tile(_shifted(raw, delays).mean(axis=0), (raw.shape[0], 1)), -delays)
    return Pulses(rate, at[:, 0], ramp, *_fine(raw, rate, after_s if alike else MOVING_S))


def bent(
    velocity: Annotated[np.ndarray, "(pulses, n)", "m/s"], bristles: Bristles, rate_hz: float
) -> tuple[np.ndarray, np.ndarray]:
    """State of the bristles from a given motion, exact for a velocity that is constant within each step.

    Returns: fraction of the initial state that is left, and the state from an initial state of 0.
    """
    speed = np.abs(velocity)
    most = 1.0 + bristles.stribeck * np.exp(-((speed / bristles.stribeck_speed_m_per_s) ** 2))
    decay = np.exp(-speed / (rate_hz * bristles.distance_m * most))
    pushed = np.sign(velocity) * most * (1.0 - decay)
    # z_k = decay_k z_k-1 + pushed_k of all pulses, one after the other, as one system of equations with two
    # diagonals: it is solved by this very recursion, but not step by step in Python
    below = -decay
    below[:, 0] = 0.0
    n = velocity.size
    *_, z, _ = scipy.linalg.lapack.dgtsv(below.ravel()[1:], np.ones(n), np.zeros(n - 1), pushed.ravel())
    return np.cumprod(decay, axis=1), z.reshape(velocity.shape)


def mean_state(
    windows: PulseWindows, velocity: Annotated[np.ndarray, "(trials, n * FINER)", "m/s"], bristles: Bristles
) -> Annotated[np.ndarray, "(trials, n * FINER)"]:
    """State of the bristles, mean over the pulses of each trial, relative to the state before the pulse."""
    kept, z = bent(velocity, bristles, windows.rate_hz * FINER)
    before, total = np.zeros(z.shape[0]), np.zeros(z.shape[0])
    for k in range(int(windows.count.max())):
        total += np.where(k < windows.count, before, 0.0)
        before = kept[:, -1] * before + z[:, -1]
    return z + (kept - 1.0) * (total / windows.count)[:, None]


def coarse_spectrum(
    windows: PulseWindows, x: Annotated[np.ndarray, "(trials, n * FINER)"]
) -> Annotated[np.ndarray, "(trials, n // 2 + 1)"]:
    """Spectrum of a signal at the fine rate, filtered like the recordings, shape (trials, n // 2 + 1).

    Returns: spectrum at the recordings' rate (unit of ``x``).
    """
    return _coarse(x, windows.ramp) * windows.lowpass


def held(
    recording: BeltRecording,
    pulses: Pulses,
    x: Annotated[np.ndarray, "(pulses, w * FINER)"],
    last: Annotated[np.ndarray, "(pulses,)"],
) -> np.ndarray:
    """A signal of the whole trial from its windows, constant in between, filtered like the recording.

    last: its value from the end of each window to the next window (unit of ``x``).
    Returns: the signal (unit of ``x``).
    """
    n = recording.load.size
    body = int(np.argmin(pulses.ramp == 1.0))
    signal = np.zeros(n)
    parts = np.fft.irfft(_coarse(x, pulses.ramp), x.shape[1] // FINER, axis=1)
    for start, part, value in zip(pulses.start, parts, last, strict=True):
        signal[start:] = value
        signal[start : start + body] = part[: min(body, n - start)]
    return recording.through_lowpass(signal)


def bent_in_turn(pulses: Pulses, w: np.ndarray, bristles: Bristles) -> tuple[np.ndarray, np.ndarray]:
    """State of the bristles in every pulse, shape (pulses, n), and at its end, shape (pulses,)."""
    kept, z = bent(w, bristles, FINER * pulses.rate_hz)
    last, before = np.empty(z.shape[0]), 0.0
    for k in range(z.shape[0]):
        z[k] += kept[k] * before
        last[k] = before = z[k, -1]
    return z, last


def over_line(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Spectrum of ``x``, shape (n,), less a line between its ends, and the line (unit of ``x``).

    The ends differ where bristles stay bent; the line between them is passed on unchanged.
    """
    line = np.linspace(x[0], x[-1], x.size)
    return np.fft.rfft(x - line), line


def from_each_pulse(recording: BeltRecording, x: np.ndarray) -> np.ndarray:
    """``x`` less its value before the last pulse that has begun, shape (n,) (unit of ``x``)."""
    relative = x.copy()
    before = round(0.1 * recording.rate_hz)
    ends = [*recording.onsets[1:], x.size]
    for onset, end in zip(recording.onsets, ends, strict=True):
        relative[onset:end] -= x[max(0, onset - before)]
    return relative


def _coarse(x: np.ndarray, ramp: np.ndarray) -> np.ndarray:
    """Spectrum of windows at the fine rate up to half the recordings' rate, unit of ``x``."""
    return np.fft.rfft(x * np.repeat(ramp, FINER), axis=1)[:, : ramp.size // 2 + 1] / FINER


def _ramp(rate_hz: float, after_s: float) -> tuple[int, np.ndarray]:
    """Length of a window (samples) and the factor that leads its end back to 0, shape (n,)."""
    body = round((BEFORE_S + after_s) * rate_hz)
    samples = scipy.fft.next_fast_len(body + round(BACK_S * rate_hz), real=True)
    samples += samples % 2
    back = (np.arange(samples - body) + 1.0) / (samples - body)
    return samples, np.concatenate([np.ones(body), 0.5 + 0.5 * np.cos(np.pi * back)])


def _window_samples(recording: BeltRecording, samples: int) -> np.ndarray:
    """Samples of the window of every pulse, shape (pulses, n)."""
    if not recording.onsets:
        raise InputError(
            f"{recording.name}: expected separate pulses of the belt, found a continuously perturbed belt: "
            "use another model"
        )
    first = np.array(recording.onsets) - round(BEFORE_S * recording.rate_hz)
    return np.clip(first[:, None] + np.arange(samples), 0, recording.load.size - 1)


def _delays(velocity: np.ndarray) -> np.ndarray:
    """Delay of every pulse relative to their mean (samples), shape (pulses,), by Gauss-Newton."""
    n = velocity.shape[1]
    omega = 2j * np.pi * np.fft.rfftfreq(n)
    spectra, delays = np.fft.rfft(velocity, axis=1), np.zeros(velocity.shape[0])
    for _ in range(ALIGNMENTS):
        aligned = spectra * np.exp(np.outer(delays, omega))
        mean = aligned.mean(axis=0)
        slope = np.fft.irfft(mean * omega, n)
        delays -= np.fft.irfft(aligned - mean, n, axis=1) @ slope / (slope @ slope)
        delays -= delays.mean()
    return delays


def _shifted(x: np.ndarray, samples: np.ndarray) -> np.ndarray:
    """Rows of ``x``, periodic, each advanced by a number of samples, shape (pulses, n) (unit of ``x``)."""
    n = x.shape[1]
    turn = np.exp(np.outer(samples, 2j * np.pi * np.fft.rfftfreq(n)))
    return np.fft.irfft(np.fft.rfft(x, axis=1) * turn, n, axis=1)


def _fine(velocity: np.ndarray, rate_hz: float, moving_s: float) -> tuple[np.ndarray, np.ndarray]:
    """Velocity and acceleration at the fine rate, zero outside the pulse, shape (pulses, n * FINER)."""
    n = velocity.shape[1]
    onset, few = round(BEFORE_S * rate_hz), max(2, round(0.02 * rate_hz))
    moves = np.zeros(n)
    moves[onset - 2 * few : onset + round(moving_s * rate_hz)] = 1.0
    moves = np.convolve(moves, np.ones(few) / few, "same")
    spline = scipy.interpolate.CubicSpline(np.arange(n) / rate_hz, (velocity * moves).T)
    time = np.arange(n * FINER) / (rate_hz * FINER)
    return spline(time).T, spline(time, 1).T
