"""The recorder of muscle activity: bipolar electrodes on the skin, its own file and clock.

Channel i lies over muscle i, whose neural drive is d_i (0 at rest, 1 in a maximal contraction). It
records

    u_i = sum_j C_ij A d_j w_j  +  G_i (h * a)  +  H_i (hum)  +  b_i  +  n_i

    w_j  interference pattern of many motor units: white noise with the shape
         W(s) = s / ((s + 2 pi f_l) (s + 2 pi f_h)^2), scaled to a root mean square of 1. The drive multiplies
         it after the shaping, so that a burst starts when its drive starts.
    A    root mean square at full drive
    C    cross-talk: 1 for the muscle under the electrodes, a small share for the muscle next to it
    a    acceleration of the belt; skin and cables follow it as h = 1 / (1 + T s)^2, which passes what is slow
         and is over within 4 T to 5 T
    G_i  gain of that artefact, of either sign
    H_i  amplitude of the mains' hum, f_m and its third harmonic, each with a phase of its own
    b_i  baseline, which wanders as white noise through 1 / (1 + T_b s)^2
    n_i  white noise of electrodes and amplifier

The converter clips u at its limit and rounds it to whole steps of limit / 32767, so that the 16 bits of an
EDF file hold exactly what it found. The recorder samples on its own clock: its first sample falls anywhere
in the first sampling interval of the laboratory's clock, and it runs for whole seconds.
"""

from dataclasses import dataclass
from datetime import date
from pathlib import Path
from typing import Annotated

import numpy as np
import scipy

from tepsipe.quantities import Frequency, NotNegative, Pair, Positive, Rate, Time

MUSCLES = ("TA", "SOL", "GAS", "BF", "RF")
CHANNELS = tuple(f"EMG {muscle}" for muscle in MUSCLES)
# adjacent muscles in the shank and in the thigh
NEIGHBOURS = (("TA", "SOL"), ("SOL", "GAS"), ("BF", "RF"))
TRIGGER = "Trigger"
TRIGGER_V = 5.0
# the largest number of 16 bits whose negative is one too, so that 0 uV is a whole number of steps
STEPS = 32767


@dataclass(frozen=True)
class EmgTruth:
    """The recorder of muscle activity."""

    rate_hz: Rate
    """Rate, a whole number."""
    band_hz: Pair[Frequency]  # f_l, f_h
    """Corner frequencies of the spectrum of muscle activity."""
    full_drive_uV: Positive  # A
    """Root mean square at full drive."""
    cross_talk: NotNegative
    """Fraction of a neighbouring muscle's signal."""
    artefact_uV_per_m_per_s2: float  # G
    """Artefact of a constant belt acceleration."""
    artefact_s: Time  # T
    """Time constant of skin and cables."""
    hum_uV: NotNegative
    """Mains hum: amplitude."""
    hum_hz: Frequency
    """Its frequency."""
    hum_third: NotNegative
    """Its relative third harmonic."""
    channel_spread: NotNegative
    """Variation of artefact and hum between channels (standard deviation of the logarithm)."""
    baseline_uV: NotNegative
    """Baseline drift: standard deviation."""
    baseline_s: Time  # T_b
    """Its correlation time."""
    noise_uV: NotNegative
    """Standard deviation of the white noise of electrodes and amplifier."""
    limit_uV: Positive
    """Largest voltage of the converter."""


def record_emg(
    truth: EmgTruth,
    time: Annotated[np.ndarray, "(n,)", "s"],
    drive: Annotated[np.ndarray, "(n, 5)"],
    belt_acceleration: Annotated[np.ndarray, "(n,)", "m/s²"],
    ends_s: float,
    rng: np.random.Generator,
) -> tuple[np.ndarray, np.ndarray]:
    """Voltages of the five channels, from the start of the laboratory's clock on.

    After the grid's last point the drive stays as it is and the belt rests.

    time: regular grid of the arrays below.
    drive: neural drive of MUSCLES, not negative.
    belt_acceleration: acceleration of the belt under the subject.
    ends_s: instant that the recording must reach (s); the recorder stops at the end of a whole second.

    Returns:
        signals: voltages in whole steps of the converter (uV). Shape (k, 5).
        instants: sampling instants, on the laboratory's clock (s). Shape (k,).
    """
    of_pattern, of_artefact, of_hum, of_baseline, of_noise = rng.spawn(5)
    samples = round(np.ceil(ends_s - time[0]) * truth.rate_hz)
    instants = time[0] + (rng.random() + np.arange(samples)) / truth.rate_hz
    shape = (samples, len(MUSCLES))
    low, high = (2.0 * np.pi * corner for corner in truth.band_hz)
    pattern = ([1.0, 0.0], np.poly([-low, -high, -high]))
    muscle = truth.full_drive_uV * _shaped_noise(pattern, shape, truth.rate_hz, of_pattern)
    muscle *= np.column_stack([np.interp(instants, time, d) for d in drive.T])
    volts = muscle @ _cross_talk(truth).T
    volts += _artefact(truth, time, belt_acceleration, instants, of_artefact)
    volts += _hum(truth, instants, of_hum)
    wander = ([1.0], np.poly([-1.0 / truth.baseline_s] * 2))
    volts += truth.baseline_uV * _shaped_noise(wander, shape, truth.rate_hz, of_baseline)
    volts += truth.noise_uV * of_noise.standard_normal(shape)
    steps = np.clip(np.round(volts / truth.limit_uV * STEPS), -STEPS, STEPS)
    return truth.limit_uV * (steps / STEPS), instants


def sample_trigger(
    instants: Annotated[np.ndarray, "(k,)", "s"], trigger_s: float, duration_s: float
) -> Annotated[np.ndarray, "(k,)", "V"]:
    """Trigger line as the recorder samples it.

    instants: from `record_emg`.
    trigger_s, duration_s: trigger's edge on the laboratory's clock, and how long the trigger is high.
    Returns: 0 or 5.
    """
    high = (instants >= trigger_s) & (instants < trigger_s + duration_s)
    return np.where(high, TRIGGER_V, 0.0)


def write_emg(
    path: Path,
    labels: tuple[str, ...],
    signals: Annotated[np.ndarray, "(k, channels)"],
    trigger: Annotated[np.ndarray, "(k,)", "V"],
    rate_hz: float,
    limit: float,
) -> None:
    """Write a recording as EDF+, in records of 1 s, the trigger as its last channel.

    signals: voltages within the limit (uV), for whole seconds.
    trigger: trigger line.
    limit: largest voltage that the file can hold (uV), of at most seven characters: the header has no more.
    """
    from edfio import Edf, EdfSignal, Patient, Recording  # only who makes such a recording needs it

    channels = [(label, "uV", limit, column) for label, column in zip(labels, signals.T, strict=True)]
    channels.append((TRIGGER, "V", TRIGGER_V, trigger))
    file = Edf(
        [
            EdfSignal(
                data,
                rate_hz,
                label=label,
                transducer_type="trigger line" if label == TRIGGER else "bipolar surface electrodes",
                physical_dimension=unit,
                physical_range=(-largest, largest),
                digital_range=(-STEPS, STEPS),
            )
            for label, unit, largest, data in channels
        ],
        patient=Patient(),
        # a placeholder date: the same study must give the same bytes
        recording=Recording(startdate=date(1985, 1, 1), equipment_code="EMG-recorder"),
        data_record_duration=1.0,
        annotations=(),  # makes it EDF+
    )
    file.write(path)


def _cross_talk(truth: EmgTruth) -> np.ndarray:
    """Share of every muscle (column) in every channel (row), shape (5, 5)."""
    share = np.eye(len(MUSCLES))
    for one, other in NEIGHBOURS:
        i, j = MUSCLES.index(one), MUSCLES.index(other)
        share[i, j] = share[j, i] = truth.cross_talk
    return share


def _artefact(
    truth: EmgTruth,
    time: np.ndarray,
    belt_acceleration: np.ndarray,
    instants: np.ndarray,
    rng: np.random.Generator,
) -> np.ndarray:
    """Artefacts of skin and cables (uV), shape (k, 5)."""
    spread = np.exp(truth.channel_spread * rng.standard_normal(len(MUSCLES)))
    sign = rng.choice((-1.0, 1.0), len(MUSCLES))
    follow = ([1.0], np.polymul([truth.artefact_s, 1.0], [truth.artefact_s, 1.0]))
    grid_rate_hz = (time.size - 1) / (time[-1] - time[0])
    moving = _filtered(follow, belt_acceleration, grid_rate_hz)
    # beyond the grid the belt rests
    followed = np.interp(instants, time, moving, right=0.0)
    return truth.artefact_uV_per_m_per_s2 * np.outer(followed, sign * spread)


def _hum(truth: EmgTruth, instants: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Interference of the mains (uV), shape (k, 5)."""
    spread = np.exp(truth.channel_spread * rng.standard_normal(len(MUSCLES)))
    first, third = 2.0 * np.pi * rng.random((2, len(MUSCLES)))
    angle = 2.0 * np.pi * truth.hum_hz * instants[:, None]
    wave = np.sin(angle + first) + truth.hum_third * np.sin(3.0 * angle + third)
    return truth.hum_uV * spread * wave


def _shaped_noise(
    transfer: tuple[list, np.ndarray], shape: tuple[int, int], rate_hz: float, rng: np.random.Generator
) -> np.ndarray:
    """White noise through a transfer function, stationary, root mean square 1, columns independent."""
    slowest = np.abs(np.roots(transfer[1])).min()
    before = round(20.0 * rate_hz / slowest)  # until it has forgotten that it started at rest
    impulse = np.zeros(before)
    impulse[0] = 1.0
    scale = np.linalg.norm(_filtered(transfer, impulse, rate_hz))
    noise = rng.standard_normal((before + shape[0], shape[1]))
    return _filtered(transfer, noise, rate_hz)[before:] / scale


def _filtered(transfer: tuple[list, np.ndarray], x: np.ndarray, rate_hz: float) -> np.ndarray:
    """Output of a linear system (numerator, denominator in s) that starts at rest, along the first axis."""
    numerator, denominator, _ = scipy.signal.cont2discrete(transfer, 1.0 / rate_hz, method="bilinear")
    return scipy.signal.lfilter(np.ravel(numerator), denominator, x, axis=0)
