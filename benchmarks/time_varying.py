"""Do the intervals of a changing stiffness cover it? A joint with known K(t), many seeds.

    .venv/bin/python benchmarks/time_varying.py --seeds 200

The angle is imposed and its derivatives are known: sums of sines. The torque is I theta'' + B theta' +
K(t) theta plus coloured noise; nothing here is shared with the estimator. For the three methods of
`tepsipe.identification.time_varying`, prints the coverage of the 95 % intervals, the largest error of the
mean over seeds, and the 95th percentile of the error of one estimate. Results: benchmarks/time_varying.md.
"""

import argparse

import numpy as np
import scipy

from tepsipe.identification.time_varying import (
    MovedJoint,
    impedance_by_schedule,
    impedance_in_windows,
    impedance_of_ensemble,
)

RATE = 250.0
INERTIA, DAMPING = 0.015, 0.8
DRAWS = 400


def imposed_angle(seconds: float, rng: np.random.Generator) -> tuple[np.ndarray, ...]:
    """Time (s), and a random angle with its first and second derivative (rad, rad/s, rad/s²)."""
    time = np.arange(round(seconds * RATE)) / RATE
    frequency = rng.uniform(0.3, 20.0, 80)
    phase = rng.uniform(0.0, 2.0 * np.pi, 80)
    # as from an actuator with a bandwidth of 4 Hz
    size = 0.006 / np.hypot(1.0, frequency / 4.0)
    derivatives = [np.zeros(time.size) for _ in range(3)]
    for f, p, a in zip(frequency, phase, size, strict=True):
        w = 2.0 * np.pi * f
        wave = a * np.exp(1j * (w * time + p))
        for order in range(3):
            derivatives[order] += (wave * (1j * w) ** order).imag
    return time, *derivatives


def voluntary_torque(samples: int, rms: float, rng: np.random.Generator) -> np.ndarray:
    """Noise (N·m): half of its variance below 0.5 Hz, half below 10 Hz."""
    torque = np.zeros(samples)
    for cutoff in (0.5, 10.0):
        sos = scipy.signal.butter(2, cutoff, fs=RATE, output="sos")
        part = scipy.signal.sosfilt(sos, rng.standard_normal(samples + 2500))[2500:]
        torque += part / part.std() * rms / np.sqrt(2.0)
    return torque


def doubling(x: np.ndarray) -> np.ndarray:
    """K (N·m/rad) that doubles from 0 to 1."""
    return 50.0 * (1.0 + x)


def windows(seed: int) -> tuple[np.ndarray, ...]:
    """K doubles over a record of one minute, in windows: truth, estimate, ends of the interval (N·m/rad)."""
    rng = np.random.default_rng(seed)
    time, angle, velocity, acceleration = imposed_angle(60.0, rng)
    torque = INERTIA * acceleration + DAMPING * velocity + doubling(time / 60.0) * angle
    torque = torque + voluntary_torque(time.size, 0.5, rng)
    impedance = impedance_in_windows(
        MovedJoint(angle, torque, RATE), window_s=5.0, step_s=2.5, block_s=2.0, draws=DRAWS, rng=rng
    )
    return doubling(impedance.at / 60.0), impedance.values[:, 2], impedance.low[:, 2], impedance.high[:, 2]


def ensemble(seed: int) -> tuple[np.ndarray, ...]:
    """K doubles within 1 s after each of 40 triggers, over a movement of 0.2 rad (N·m/rad)."""
    rng = np.random.default_rng(seed)
    time, angle, velocity, acceleration = imposed_angle(61.0, rng)
    starts = np.arange(0, 60 * 250, 375)
    phase = (time * RATE % 375) / 250.0
    stiffness = doubling(np.clip(phase, 0.0, 1.0))
    w = 2.0 * np.pi / 1.5
    moved = 0.1 * np.sin(w * time)
    torque = stiffness * angle + DAMPING * velocity + INERTIA * acceleration
    torque = torque + 40.0 * moved**2 + 5.0 * moved + voluntary_torque(time.size, 0.5, rng)
    impedance = impedance_of_ensemble(
        MovedJoint(angle + moved, torque, RATE),
        starts,
        length_s=1.0,
        segment_s=0.2,
        step_s=0.1,
        draws=DRAWS,
        rng=rng,
    )
    return doubling(impedance.at), impedance.values[:, 2], impedance.low[:, 2], impedance.high[:, 2]


def schedule(seed: int) -> tuple[np.ndarray, ...]:
    """K doubles with a target that rises and falls every 20 s (N·m/rad)."""
    rng = np.random.default_rng(seed)
    time, angle, velocity, acceleration = imposed_angle(120.0, rng)
    target = 1.0 - np.abs(time % 20.0 / 10.0 - 1.0)
    torque = INERTIA * acceleration + DAMPING * velocity + doubling(target) * angle
    torque = torque + 10.0 * target + voluntary_torque(time.size, 0.5, rng)
    impedance = impedance_by_schedule(
        MovedJoint(angle, torque, RATE), target, bins=6, piece_s=2.0, draws=DRAWS, rng=rng
    )
    return doubling(impedance.at), impedance.values[:, 2], impedance.low[:, 2], impedance.high[:, 2]


def main() -> None:
    """Print coverage and bias of each method."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=200)
    seeds = parser.parse_args().seeds
    print(
        "method    places  coverage (%)  mean error, largest (%)  error of one estimate, 95th percentile (%)"
    )
    for method in (windows, ensemble, schedule):
        truth, value, low, high = (np.array(part) for part in zip(*map(method, range(seeds)), strict=True))
        held = 100.0 * ((low <= truth) & (truth <= high)).mean(axis=0)
        bias = 100.0 * np.abs((value / truth).mean(axis=0) - 1.0).max()
        spread = 100.0 * np.percentile(np.abs(value / truth - 1.0), 95)
        print(
            f"| {method.__name__} | {truth.shape[1]} | {held.mean():.1f} | {held.min():.1f} | {bias:.2f} | "
            f"{spread:.1f} |"
        )


if __name__ == "__main__":
    main()
