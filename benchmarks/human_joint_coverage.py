"""Human joint under imposed movement with known parts: bias of the estimates, and what their intervals hold.

    .venv/bin/python benchmarks/human_joint_coverage.py --seeds 200 > benchmarks/human_joint_coverage.md

The joint is not built from the equations of the model: short-range stiffness is a Dahl element, whose force
approaches its limit exponentially, or a Maxwell element, whose force relaxes; the reflex is the torque of a
second-order muscle, integrated at 1 kHz, behind a delay of 43 ms and a velocity threshold of 0.15 rad/s that
are on no grid; slow torque is an Ornstein-Uhlenbeck process; angle and torque have white noise. Prints a
table.

    .venv/bin/python benchmarks/human_joint_coverage.py --cost 6 60

prints what a fit costs instead: CPU time without its limit of one thread over that with it, for a record of
a minute, and CPU time and memory for records of 6 and 60 minutes.
"""

import argparse
import inspect
import multiprocessing
import resource
import sys
import time as clock
from pathlib import Path

import numpy as np
import scipy

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from tepsipe import fit_parallel_cascade  # noqa: E402

RATE, SECONDS = 1000.0, 60.0
INERTIA, DAMPING, STIFFNESS = 0.014, 0.7, 60.0
SHORT_RANGE, LIMIT_RAD, RELAXATION_S = 25.0, 0.005, 0.07
GAIN, DELAY_S, THRESHOLD, FREQUENCY_HZ, ZETA = 10.0, 0.043, 0.15, 2.2, 0.9
DRAWS = 300
TURNS = 5
SLOW_SD, SLOW_S, TORQUE_NOISE, ANGLE_NOISE = 0.25, 1.0, 0.05, 2e-5
JOINTS = {
    "no short-range stiffness": {"short_range": None, "gain": GAIN},
    "short-range stiffness (Dahl)": {"short_range": "dahl", "gain": GAIN},
    "short-range stiffness (Maxwell)": {"short_range": "maxwell", "gain": GAIN},
    "no reflex": {"short_range": None, "gain": 0.0},
    "no reflex, short-range stiffness (Dahl)": {"short_range": "dahl", "gain": 0.0},
}


def imposed_angle(rng: np.random.Generator, amplitude: float = 0.03, seconds=SECONDS) -> np.ndarray:
    """Random steps every 0.1 to 0.4 s as an actuator of 18 Hz follows them (rad), shape (n,)."""
    count = int(seconds * RATE)
    holds = rng.uniform(0.1, 0.4, int(seconds / 0.1))
    at = np.searchsorted(np.cumsum(holds), np.arange(count) / RATE)
    levels = amplitude * rng.uniform(-1.0, 1.0, holds.size + 1)
    w = 2.0 * np.pi * 18.0
    follower = scipy.signal.cont2discrete(([w**2], [1.0, 1.6 * w, w**2]), 1.0 / RATE)
    return scipy.signal.lfilter(np.ravel(follower[0]), follower[1], levels[at])


def short_range_torque(angle: np.ndarray, kind: str | None) -> np.ndarray:
    """Torque of a Dahl or a Maxwell element of stiffness ``SHORT_RANGE`` (N·m), shape (n,)."""
    if kind is None:
        return np.zeros(angle.size)
    if kind == "maxwell":
        keep = np.exp(-1.0 / (RATE * RELAXATION_S))
        return scipy.signal.lfilter([SHORT_RANGE], [1.0, -keep], np.diff(angle, prepend=angle[:1]))
    deflection, deflections = 0.0, []
    for step in np.diff(angle, prepend=angle[:1]).tolist():
        # dz = dtheta (1 - z / limit sign(dtheta)), its exact solution over a step
        end = LIMIT_RAD if step > 0.0 else -LIMIT_RAD
        deflection = end + (deflection - end) * np.exp(-abs(step) / LIMIT_RAD)
        deflections.append(deflection)
    return SHORT_RANGE * np.array(deflections)


def make_joint(
    seed: int, short_range: str | None, gain: float, slow_sd: float = SLOW_SD, amplitude=0.03, seconds=SECONDS
):
    """Time (s), angle (rad) and torque (N·m) of one record, and its working stiffness (N·m/rad)."""
    rng = np.random.default_rng(seed)
    angle = imposed_angle(rng, amplitude, seconds)
    time = np.arange(angle.size) / RATE
    # central differences would make the acceleration 0.4 % too small, and so the inertia
    path = scipy.interpolate.make_interp_spline(time, angle, 5)
    velocity, acceleration = path.derivative(1)(time), path.derivative(2)(time)
    short = short_range_torque(angle, short_range)
    motion = np.column_stack([acceleration, velocity, angle, np.ones_like(angle)])
    working = STIFFNESS + np.linalg.lstsq(motion, short, rcond=None)[0][2]
    late = np.roll(velocity, round(DELAY_S * RATE))
    late[: round(DELAY_S * RATE)] = 0.0
    w = 2.0 * np.pi * FREQUENCY_HZ
    muscle = scipy.signal.cont2discrete(([w**2], [1.0, 2.0 * ZETA * w, w**2]), 1.0 / RATE)
    reflex = scipy.signal.lfilter(np.ravel(muscle[0]), muscle[1], np.maximum(late - THRESHOLD, 0.0))
    keep = np.exp(-1.0 / (SLOW_S * RATE))
    drive = slow_sd * np.sqrt(1.0 - keep**2) * rng.standard_normal(angle.size)
    slow = scipy.signal.lfilter([1.0], [1.0, -keep], drive)
    torque = INERTIA * acceleration + DAMPING * velocity + STIFFNESS * angle + short + gain * reflex + slow
    torque += 5.0 + TORQUE_NOISE * rng.standard_normal(angle.size)
    return time, angle + 0.1 + ANGLE_NOISE * rng.standard_normal(angle.size), torque, working


def scored(seed: int, joint: dict) -> dict:
    """Quantity -> (truth, value, low, high) in its unit, and which terms were found."""
    time, angle, torque, working = make_joint(seed, **joint)
    fit = fit_parallel_cascade(time, angle, torque, bootstrap_draws=DRAWS, seed=seed)
    structure = fit.details.structure
    truth = {"I": INERTIA, "B": DAMPING, "K": STIFFNESS, "K_working": working, "reflex_gain": joint["gain"]}
    # a Dahl element is stiffer after a reversal than from rest: no single true value
    short = {None: 0.0, "maxwell": SHORT_RANGE}.get(joint["short_range"])
    if short is not None:
        truth["K_short_range"] = STIFFNESS + short
    rows = {}
    for name, value in truth.items():
        quantity = fit.quantities.get(name)
        rows[name] = (
            (value, quantity.value, quantity.low, quantity.high) if quantity else (value, 0.0, 0.0, 0.0)
        )
    return {
        "rows": rows,
        "reflex": structure.direction != 0,
        "short-range stiffness": structure.stops,
        "relaxation": structure.relaxing,
        "unloading": structure.unloading,
    }


def cpu_s(fit, record) -> float:
    """CPU time of a fit (s)."""
    start = clock.process_time()
    fit(*record)
    return clock.process_time() - start


def print_cost(minutes: list[int]) -> None:
    """Print ratios of CPU times, and CPU time (s) and most memory (MB) of records of some lengths (min)."""
    joint = JOINTS["short-range stiffness (Dahl)"]
    record = make_joint(1, **joint)[:3]
    ways = inspect.unwrap(fit_parallel_cascade), fit_parallel_cascade
    # in turns, so that other work of the computer slows both; the first loads what a fit needs
    turns = [[cpu_s(fit, record) for fit in ways] for _ in range(TURNS + 1)][1:]
    ratio = np.median([without / limited for without, limited in turns])
    print(f"{SECONDS:g} s: {ratio:.1f} times the CPU time without the limit of one thread", flush=True)
    last = None
    for length in sorted(minutes):
        # the record is made by another process, whose memory does not count
        with multiprocessing.get_context("spawn").Pool(1) as other:
            record = other.apply(make_joint, (1,), {**joint, "seconds": 60.0 * length})[:3]
        taken = cpu_s(fit_parallel_cascade, record)
        most = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
        times = f", {taken / last[1]:.1f} times that of {last[0]} min" if last else ""
        print(f"{length} min: {most:.0f} MB, {taken:.1f} CPU-s{times}", flush=True)
        last = length, taken


def main() -> None:
    """Fit all joints and print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=200)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--joint", choices=JOINTS, action="append")
    parser.add_argument("--cost", type=int, nargs="+", metavar="MINUTES")
    chosen = parser.parse_args()
    if chosen.cost:
        print_cost(chosen.cost)
        return
    print("# Human joint: bias and coverage\n")
    print(
        f"{chosen.seeds} records of {SECONDS:g} s per joint, half of each fitted. Slow torque:\n"
        f"{SLOW_SD:g} N·m (standard deviation).\n"
    )
    print(
        "| Joint | Quantity | Truth | Bias (%) | Spread (%) | Half width (%) | Held |\n"
        "|---|---|---|---|---|---|---|"
    )
    notes = []
    for name in chosen.joint or JOINTS:
        trials = [scored(seed, JOINTS[name]) for seed in range(chosen.first, chosen.first + chosen.seeds)]
        for quantity in trials[0]["rows"]:
            table = np.array([trial["rows"][quantity] for trial in trials])
            truth, value, low, high = table.T
            unit = 100.0 / (truth.mean() or GAIN)
            held = np.mean((low <= truth) & (truth <= high))
            print(
                f"| {name} | {quantity} | {truth.mean():.4g} | {unit * np.mean(value - truth):.2f} | "
                f"{unit * np.std(value - truth):.2f} | {unit * np.mean(high - low) / 2.0:.2f} | {held:.3f} |",
                flush=True,
            )
        shares = {
            key: 100.0 * np.mean([trial[key] for trial in trials]) for key in trials[0] if key != "rows"
        }
        notes.append(f"- {name}: found " + ", ".join(f"{key} {share:.1f} %" for key, share in shares.items()))
    print("\n" + "\n".join(notes))


if __name__ == "__main__":
    main()
