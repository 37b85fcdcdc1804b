"""Human joint under imposed movement with known parts: bias of the estimates, and what their intervals hold.

    .venv/bin/python benchmarks/human_joint_coverage.py --seeds 200 > benchmarks/human_joint_coverage.md

The joint is not built from the equations of the model (`tepsipe.virtual_lab.human_joint`). Its delay of 43 ms
and its velocity threshold of 0.15 rad/s are on no grid. Angle and torque have white noise. Prints a table.

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

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from tepsipe import fit_parallel_cascade  # noqa: E402
from tepsipe.virtual_lab.human_joint import HumanJoint, move_human_joint  # noqa: E402

SECONDS = 60.0
DRAWS = 300
TURNS = 5
TORQUE_NOISE, ANGLE_NOISE = 0.05, 2e-5
JOINTS = {
    "no short-range stiffness": HumanJoint(),
    "short-range stiffness (Dahl)": HumanJoint(short_range="dahl"),
    "short-range stiffness (Maxwell)": HumanJoint(short_range="maxwell"),
    "no reflex": HumanJoint(reflex_gain_Nms_per_rad=0.0),
    "no reflex, short-range stiffness (Dahl)": HumanJoint(short_range="dahl", reflex_gain_Nms_per_rad=0.0),
}


def make_joint(seed: int, joint: HumanJoint, seconds=SECONDS):
    """Time (s), angle (rad) and torque (N·m) of one record, and its working stiffness (N·m/rad)."""
    rng = np.random.default_rng(seed)
    record = move_human_joint(joint, seconds, rng)
    torque = record.torque + 5.0 + TORQUE_NOISE * rng.standard_normal(record.time.size)
    angle = record.angle + 0.1 + ANGLE_NOISE * rng.standard_normal(record.time.size)
    return record.time, angle, torque, record.linear[2]


def scored(seed: int, joint: HumanJoint) -> dict:
    """Quantity -> (truth, value, low, high) in its unit, and which terms were found."""
    time, angle, torque, working = make_joint(seed, joint)
    fit = fit_parallel_cascade(time, angle, torque, bootstrap_draws=DRAWS, seed=seed)
    structure = fit.details.structure
    stiffness, gain = joint.stiffness_Nm_per_rad, joint.reflex_gain_Nms_per_rad
    truth = {"I": joint.inertia_kgm2, "B": joint.damping_Nms_per_rad, "K": stiffness}
    truth |= {"K_working": working, "reflex_gain": gain}
    # a Dahl element is stiffer after a reversal than from rest: no single true value
    short = {None: 0.0, "maxwell": joint.short_range_Nm_per_rad}.get(joint.short_range)
    if short is not None:
        truth["K_short_range"] = stiffness + short
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
    record = make_joint(1, joint)[:3]
    ways = inspect.unwrap(fit_parallel_cascade), fit_parallel_cascade
    # in turns, so that other work of the computer slows both; the first loads what a fit needs
    turns = [[cpu_s(fit, record) for fit in ways] for _ in range(TURNS + 1)][1:]
    ratio = np.median([without / limited for without, limited in turns])
    print(f"{SECONDS:g} s: {ratio:.1f} times the CPU time without the limit of one thread", flush=True)
    last = None
    for length in sorted(minutes):
        # the record is made by another process, whose memory does not count
        with multiprocessing.get_context("spawn").Pool(1) as other:
            record = other.apply(make_joint, (1, joint, 60.0 * length))[:3]
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
        f"{HumanJoint().slow_torque_Nm:g} N·m (standard deviation).\n"
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
            unit = 100.0 / (truth.mean() or HumanJoint().reflex_gain_Nms_per_rad)
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
