"""Recordings of an accelerated belt whose load is known, made without the library's formulas."""

from dataclasses import replace

import numpy as np
from scipy import signal

from tepsipe.treadmill.options import RippleOptions
from tepsipe.treadmill.recording import BeltRecording
from tepsipe.treadmill.registry import FamilyOptions

RATE_HZ = 100.0
RIPPLE = RippleOptions(most_orders=12, line_to_floor=30.0, memory_s=20.0)
OPTIONS = FamilyOptions(
    hnat2014_evaluations=200,
    output_error_order=2,
    fir_lead_s=0.05,
    fir_lag_s=0.2,
    spectral_segment_s=2.56,
    ripple=RIPPLE,
    shortest_s=20.0,
)


def belt_recording(velocity, acceleration, load, rate_hz=RATE_HZ, **changes):
    """A recording that is evaluated everywhere, of an empty belt (m/s, m/s2, Nm)."""
    base = BeltRecording(
        name="trial 1",
        condition="random",
        rate_hz=rate_hz,
        velocity=velocity,
        acceleration=acceleration,
        raw_velocity=velocity,
        load=load,
        carried=np.zeros(load.size),
        carried_kg=0.0,
        unit="Nm",
        evaluated=np.ones(load.size, dtype=bool),
    )
    return replace(base, **changes)


def restless_belt(load, rng, seconds=60.0, **changes):
    """A belt of 1.2 m/s under white acceleration (2 m/s2); ``load`` is a function of v and a."""
    acceleration = 2.0 * rng.standard_normal(round(seconds * RATE_HZ))
    velocity = 1.2 + np.cumsum(acceleration - acceleration.mean()) / RATE_HZ
    return belt_recording(velocity, acceleration, load(velocity, acceleration), **changes)


def swaying_belt(load, rng, seconds=60.0, **changes):
    """A belt of 1.2 m/s with a random multisine up to 5 Hz; ``load`` is a function of x, v, a.

    Distance, velocity and acceleration are one another's exact derivatives.
    """
    time = np.arange(round(seconds * RATE_HZ)) / RATE_HZ
    omega = 2.0 * np.pi * np.arange(0.25, 5.0, 0.05)
    phase = rng.uniform(0.0, 2.0 * np.pi, omega.size)
    size = 0.5 * rng.uniform(0.5, 1.5, omega.size) / omega.size**0.5
    angle = np.outer(time, omega) + phase
    x = 1.2 * time + np.sin(angle) @ (size / omega) - np.sum(np.sin(phase) * size / omega)
    v = 1.2 + np.cos(angle) @ size
    a = -np.sin(angle) @ (size * omega)
    return belt_recording(v, a, load(x, v, a), **changes)


def pulsed_evaluated(samples, onsets, length):
    """True for ``length`` samples from every onset on."""
    evaluated = np.zeros(samples, dtype=bool)
    for onset in onsets:
        evaluated[onset : onset + length] = True
    return evaluated


def framed(force, rate_hz, damping_s, slowness_s2, share=0.0, mount_s=1.0, damper=False):
    """Force of a frame's springs under a force from rest, both at ``rate_hz`` (unit of the force).

    The mount passes F - k (F - q), where q follows F within the time t: t q' + q = F. The frame then answers
    with x: e x'' + d x' + x = what the mount passes; springs and damper together hold x + d x'. All are
    integrated exactly for a force that is straight between its samples, so it should be sampled densely.
    """

    def answer(denominator, x, numerator=(1.0,)):
        b, f, _ = signal.cont2discrete((list(numerator), denominator), 1.0 / rate_hz, "foh")
        return signal.lfilter(b.ravel(), f, x)

    passed = force - share * (force - answer([mount_s, 1.0], force))
    return answer([slowness_s2, damping_s, 1.0], passed, (damping_s, 1.0) if damper else (1.0,))


def belt_table(path, seed, sign=1.0, still=False):
    """A treadmill's load (Nm) and belt velocity (m/s) as its log has them, 40 s at 100 Hz."""
    rng = np.random.default_rng(seed)
    time = np.arange(4000) / 100.0
    velocity = 1.2 + 0.1 * np.convolve(rng.standard_normal(4000), np.hanning(40) / 4.5, "same")
    load = sign * (5.0 * np.gradient(velocity, 0.01) + 0.3 * rng.standard_normal(4000))
    table = np.column_stack([time, load, np.full(4000, 1.2) if still else velocity])
    np.savetxt(path, table, delimiter="\t", header="t\tMx (Nm)\tv (m/s)", comments="", fmt="%.6g")
