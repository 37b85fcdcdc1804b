"""Coverage of the intervals of the public fits on simulated records with white noise.

    .venv/bin/python benchmarks/public_fits.py --draws 400 200 > benchmarks/public_fits.md

Each record has a linear joint of known I, B, K, so that intervals can fail only by their statistics: they are
Type A. Noise is drawn again for every record. Cells: coverage (%), bias over the spread of the estimates, and
mean half width over their spread, of I, B, K. `human_joint_coverage.py` does the same for
`fit_parallel_cascade`, `time_varying.py` and `several_joints.py` for estimators of experiments.
"""

import argparse
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import scipy

sys.path.insert(0, str(Path(__file__).parents[1]))

from tepsipe import (
    ImpedanceFit,
    Leg,
    SegmentMarkers,
    find_perturbations,
    fit_admittance,
    fit_impedance,
    fit_joint_likelihood,
    fit_output_error,
    frequency_response,
    segment_motion,
    simulate_joint,
)

# the joint of examples/simulate_and_estimate.py
LEG = Leg(mass_kg=0.4, com_m=0.4485, inertia_kgm2=0.027)
JOINT = np.array([0.002, 0.1, 10.0])
# a joint with its handle in a torque-controlled manipulator
HELD = np.array([0.015, 0.1, 10.0])
PARAMETERS = ("I", "B", "K")
BETWEEN_S, FIRST_S, LAST_S = 4.0, 3.0, 5.0
COUNTS, RATES_HZ = (6, 14, 30), (250.0, 1000.0)
# time before the first perturbation, as by default; 1 s at the start; 0.5 s at the start and 1 s at the end
RESTS = (None, (1.0, 0.0), (0.5, 1.0))
NOISES = (0.01, 0.1)
LAYOUT_M = np.array([[0.0, 0.0], [-0.012, 0.87], [0.012, 0.69], [-0.012, 0.39], [0.012, 0.21]])
LABELS = ("foot1", "foot2", "foot3", "ankle", "leg1", "leg2", "leg3", "leg4")
MARKERS = SegmentMarkers(LABELS[3:], LAYOUT_M)
MARKER_NOISE_M, LOG_NOISE_M_PER_S = 1e-4, 1e-3


class Trial:
    """Exact motion of the leg on a belt with pulses of 0.3 m/s, 4 s apart."""

    def __init__(self, count: int, rate_hz: float):
        self.time = np.arange(0.0, FIRST_S + BETWEEN_S * count + LAST_S, 1.0 / rate_hz)
        self.velocity = np.zeros_like(self.time)
        for onset_s in FIRST_S + BETWEEN_S * np.arange(count):
            pulse = (self.time >= onset_s) & (self.time < onset_s + 0.1)
            self.velocity[pulse] = 0.3 * np.sin(20.0 * np.pi * (self.time[pulse] - onset_s))
        names = dict(zip(PARAMETERS, JOINT, strict=True))
        self.motion = simulate_joint(self.time, self.velocity, LEG, **names)
        self.perturbations = find_perturbations(self.time, self.velocity)
        assert len(self.perturbations) == count

    def signals(self, rng: np.random.Generator, noise: float) -> tuple[np.ndarray, ...]:
        """Time (s), angle (rad) and torque (N·m) with noise relative to their standard deviations."""
        clean = self.motion.theta, self.motion.torque
        return self.time, *(x + noise * x.std() * rng.standard_normal(x.size) for x in clean)

    def markers(self, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
        """Positions y, z (m), shape (n, 8, 2), and logged velocity of the belt (m/s)."""
        across, along = np.vstack([np.zeros((3, 2)), LAYOUT_M]).T
        cosine, sine = np.cos(self.motion.theta), np.sin(self.motion.theta)
        y = self.motion.foot_y[:, None] + np.outer(cosine, across) + np.outer(sine, along)
        z = np.outer(cosine, along) - np.outer(sine, across)
        positions = np.stack([y, z], axis=2)
        positions = positions + MARKER_NOISE_M * rng.standard_normal(positions.shape)
        return positions, self.velocity + LOG_NOISE_M_PER_S * rng.standard_normal(self.time.size)


Simulated = Callable[[np.random.Generator], ImpedanceFit]


def windows(trial: Trial, noise: float, rest) -> Simulated:
    """`fit_impedance` with perturbations."""

    def fit(rng):
        signals = trial.signals(rng, noise)
        return fit_impedance(*signals, perturbations=trial.perturbations, rest=rest)

    return fit


def record(trial: Trial, noise: float) -> Simulated:
    """`fit_impedance` without perturbations: the torque alone is noisy."""

    def fit(rng):
        time, _, torque = trial.signals(rng, noise)
        return fit_impedance(time, trial.motion.theta, torque, seed=int(rng.integers(2**31)))

    return fit


def output_error(trial: Trial) -> Simulated:
    """`fit_output_error` from markers."""

    def fit(rng):
        positions, log = trial.markers(rng)
        motion = segment_motion(trial.time, positions, MARKERS, LEG.com_m, labels=LABELS)
        foot = positions[:, :4, 0].mean(axis=1)
        return fit_output_error(motion, foot, log, LEG, perturbations=trial.perturbations)

    return fit


def likelihood(trial: Trial, softening: bool) -> Simulated:
    """`fit_joint_likelihood` from markers and log."""

    def fit(rng):
        positions, log = trial.markers(rng)
        return fit_joint_likelihood(
            trial.time,
            positions,
            MARKERS,
            LEG,
            labels=LABELS,
            belt_fixed=LABELS[:4],
            perturbations=trial.perturbations,
            belt_velocity=log,
            softening=softening,
        )

    return fit


def admittance(periodic: bool, noise: float, **how) -> Simulated:
    """`fit_admittance` of a response to a multisine with a period of 10 s, or to a random torque."""
    rate_hz, count = 250.0, 15000
    time = np.arange(count) / rate_hz

    def fit(rng):
        if periodic:
            lines, size = np.arange(10, 201), round(10.0 * rate_hz)
            spectrum = np.zeros(size // 2 + 1, dtype=complex)
            spectrum[lines] = np.exp(2j * np.pi * rng.uniform(size=lines.size))
            w = 2.0 * np.pi * np.arange(spectrum.size) / 10.0
            response = 1.0 / (HELD[2] - HELD[0] * w**2 + 1j * HELD[1] * w)
            torque, angle = (np.resize(np.fft.irfft(x, size), count) for x in (spectrum, spectrum * response))
        else:
            longer = count + round(20.0 * rate_hz)
            lowpass = scipy.signal.butter(2, 15.0, fs=rate_hz, output="sos")
            torque = scipy.signal.sosfilt(lowpass, rng.standard_normal(longer))
            angle = scipy.signal.lsim(([1.0], HELD), torque, np.arange(longer) / rate_hz)[1]
            torque, angle = torque[-count:], angle[-count:]
        angle = angle + noise * angle.std() * rng.standard_normal(count)
        return fit_admittance(frequency_response(time, torque, angle, band_hz=(1.0, 9.0), **how))

    return fit


def coverage(fit: Simulated, truth: np.ndarray, draws: int, seed: int, names=PARAMETERS) -> np.ndarray:
    """Coverage (%), bias over spread and half width over spread of each name, shape (3, names)."""
    values, ends = [], []
    for draw in range(draws):
        found = fit(np.random.default_rng([seed, draw]))
        values.append([found.quantities[name].value for name in names])
        ends.append([found.intervals[name] for name in names])
    values, (low, high) = np.array(values), np.moveaxis(np.array(ends), -1, 0)
    spread = values.std(axis=0, ddof=1)
    held = (low <= truth) & (truth <= high)
    return np.array(
        [
            100.0 * held.mean(axis=0),
            (values.mean(axis=0) - truth) / spread,
            0.5 * (high - low).mean(axis=0) / spread,
        ]
    )


def cells(found: np.ndarray) -> str:
    """Three cells of a table: coverage, bias and half width of I, B, K."""
    return " | ".join(
        " ".join(f"{x:.{digits}f}" for x in row) for row, digits in zip(found, (1, 2, 2), strict=True)
    )


def others() -> Iterator[tuple[str, Simulated, np.ndarray, tuple[str, ...]]]:
    """Name, fit, truth and quantities of the public fits beside `fit_impedance` with perturbations."""
    trial = Trial(14, 250.0)
    for noise in NOISES:
        yield f"`fit_impedance`, no perturbations, {noise:g}", record(trial, noise), JOINT, PARAMETERS
    yield "`fit_output_error`", output_error(trial), JOINT, PARAMETERS
    yield "`fit_joint_likelihood`, linear", likelihood(trial, False), JOINT, PARAMETERS
    small = tuple(f"{name}_small" for name in PARAMETERS)
    yield "`fit_joint_likelihood`", likelihood(trial, True), JOINT, PARAMETERS
    yield "`fit_joint_likelihood`, small movements", likelihood(trial, True), JOINT, small
    spectra = {
        "averaged bins": (False, {}),
        "multitaper": (False, {"averaged_bins": None}),
        "whole periods": (True, {"period_s": 10.0}),
    }
    for name, (periodic, how) in spectra.items():
        for noise in (0.02, 0.2):
            fit = admittance(periodic, noise, **how)
            yield f"`fit_admittance`, {name}, {noise:g}", fit, HELD, PARAMETERS


def main() -> None:
    """Print both tables as Markdown."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument(
        "--draws", type=int, nargs=2, default=(400, 200), help="records per cell, in each table"
    )
    draws = parser.parse_args().draws
    print("# Coverage of the public fits\n")
    print(f"`benchmarks/public_fits.py --draws {draws[0]} {draws[1]}`. Three numbers in a cell: I, B, K.\n")
    print("## `fit_impedance` with perturbations\n")
    print("| Perturbations | Rate (Hz) | Rest | Noise | Coverage (%) | Bias / spread | Half width / spread |")
    print("|---|---|---|---|---|---|---|")
    every = []
    for count in COUNTS:
        for rate_hz in RATES_HZ:
            trial = Trial(count, rate_hz)
            for rest in RESTS:
                for noise in NOISES:
                    found = coverage(windows(trial, noise, rest), JOINT, draws[0], count)
                    every.append(found[0])
                    shown = "before the first" if rest is None else f"{rest[0]:g} s + {rest[1]:g} s"
                    print(f"| {count} | {rate_hz:g} | {shown} | {noise:g} | {cells(found)} |", flush=True)
    print(f"\nMean coverage: {np.mean(every):.1f} % ({np.min(every):.1f} to {np.max(every):.1f} %).\n")
    print("## Other public fits\n")
    print("| Fit | Coverage (%) | Bias / spread | Half width / spread |")
    print("|---|---|---|---|")
    for name, fit, truth, names in others():
        print(f"| {name} | {cells(coverage(fit, truth, draws[1], 7, names))} |", flush=True)


if __name__ == "__main__":
    main()
