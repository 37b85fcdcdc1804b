# ruff: noqa: E402
"""Throughput of the batched regression of the noise study, relative to a loop of lstsq over the same windows.

    python benchmarks/noise_sweep.py

The noise is drawn and filtered before, for both; both return the same parameters.
"""

import os

for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ[f"{library}_NUM_THREADS"] = "1"

import sys
import time
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from tepsipe.experiments.noise.filtered_noise import (
    PROCESSINGS,
    cell_generators,
    filtered_trial,
    noise_chunks,
    windowed_trial,
)
from tepsipe.experiments.noise.monte_carlo import predict_angle, sweep
from tepsipe.experiments.noise.trial import SimulatedTrial
from tepsipe.identification.regression.batched import window_parameters
from tepsipe.mechanics.inverse_dynamics import Foot, Leg
from tepsipe.signals.differentiation import derivative

DRAWS = 200
SNR_DB = 20.0
SEED = 20140612
REPETITIONS = 9
CELLS = ("tau", "theta", "both")


def made_up(duration_s: float = 70.0, rate_hz: float = 250.0) -> SimulatedTrial:
    """A linearised dummy (I 0.015, B 0.1, K 10) pushed by a smooth belt every 4 s."""
    leg, foot = Leg(mass_kg=0.4, com_m=0.4485, inertia_kgm2=0.027), Foot(2.1, 0.055)
    n = np.arange(round(duration_s * rate_hz))
    onsets = np.arange(1500, n.size - 2000, 1000)
    pulse = np.arange(26) / 25.0
    velocity = np.zeros(n.size)
    for onset in onsets:
        velocity[onset : onset + 26] = 0.3 * np.sin(2.0 * np.pi * pulse) * np.sin(np.pi * pulse)
    instants = n / rate_hz
    truth = np.array([0.015, 0.1, 10.0])
    theta = predict_angle(leg, truth[None], velocity, rate_hz)[0]
    theta_d = derivative(instants, theta)
    theta_dd, y_dd = derivative(instants, theta_d), derivative(instants, velocity)
    y_leg_dd = y_dd + leg.com_m * theta_dd
    f_y = foot.mass_kg * y_dd + leg.mass_kg * y_leg_dd
    still = np.zeros(n.size)
    position = np.cumsum(velocity) / rate_hz
    return SimulatedTrial(
        "made up",
        instants,
        theta,
        theta_d,
        theta_dd,
        y_leg_dd,
        still,
        position,
        velocity,
        y_dd,
        f_y,
        still,
        still,
        np.stack([onsets - 4, onsets + 29], axis=1),
        leg,
        foot,
        truth,
    )


def loop(regressors: np.ndarray, torque: np.ndarray) -> np.ndarray:
    """I, B, K (Nms2/rad, Nms/rad, Nm/rad) of every window of every draw, one lstsq after another."""
    parameters = np.empty((*torque.shape[:2], 3))
    for draw in range(torque.shape[0]):
        for window in range(torque.shape[1]):
            x, y = regressors[draw, window].T, torque[draw, window]
            parameters[draw, window] = np.linalg.lstsq(x, y, rcond=None)[0]
    return parameters


def main() -> None:
    """Print times (ms), their ratio, how far the parameters differ and the cost of whole cells (ms)."""
    trial = filtered_trial(made_up())
    print(f"{DRAWS} draws of {len(trial.within)} windows, median of {REPETITIONS} repetitions\n")
    print(
        f"{'noise on':>9}{'loop (ms)':>11}{'batch (ms)':>12}{'ratio':>7}{'difference':>12}{'cell (ms)':>11}"
    )
    for noise_on in CELLS:
        windowed = windowed_trial(trial, PROCESSINGS["recommended-regression"], noise_on, SNR_DB)
        chunks = list(noise_chunks(trial, "both", DRAWS, cell_generators(SEED, noise_on)))
        torque = windowed.torque + windowed.torque_noise(np.concatenate([c["tau"] for c in chunks]))
        regressors = windowed.regressors  # the same for all draws
        if noise_on != "tau":
            noise = windowed.regressor_noise(np.concatenate([c["theta"] for c in chunks]))
            regressors = regressors + noise
        times: dict[str, list[float]] = {"loop": [], "batch": [], "cell": []}
        for _ in range(REPETITIONS):  # one after another: what slows the computer down slows all of them
            moments = [time.perf_counter()]
            one_by_one = loop(np.broadcast_to(regressors, (DRAWS, *regressors.shape[-3:])), torque)
            moments.append(time.perf_counter())
            batched = window_parameters(regressors, torque)[0]
            moments.append(time.perf_counter())
            sweep(trial, noise_on, SNR_DB, DRAWS, SEED, ["recommended-regression"])
            moments.append(time.perf_counter())
            for name, spent in zip(times, np.diff(moments), strict=True):
                times[name].append(1e3 * spent)
        ratio = np.median(np.array(times["loop"]) / np.array(times["batch"]))
        difference = np.abs(batched / one_by_one - 1.0).max()
        medians = [np.median(times[name]) for name in times]
        print(
            f"{noise_on:>9}{medians[0]:>11.1f}{medians[1]:>12.2f}{ratio:>7.1f}{difference:>12.1e}{medians[2]:>11.1f}"
        )


if __name__ == "__main__":
    main()
