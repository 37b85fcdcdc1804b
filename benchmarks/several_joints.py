# ruff: noqa: E402
"""Benchmark of perturbations for the stiffness matrix of ankle, knee and hip: error and coverage.

    export OMP_NUM_THREADS=1
    python benchmarks/several_joints.py --part exact --epochs 40 --seeds 100 > benchmarks/several_joints.md
    python benchmarks/several_joints.py --part tolerance --seeds 26 >> benchmarks/several_joints.md

Every seed is another sway and other noise of the same person (`config/plan/config.yaml`), simulated by
PyBullet: 2 to 3 CPU-seconds.
"""

import argparse
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import yaml

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from tepsipe.experiments.planning.several_joints import (
    EXACT,
    UNKNOWN,
    WITHIN,
    Point,
    Recording,
    epochs_of,
    estimate,
    sets_of,
)
from tepsipe.identification.several_joints.matrices import Limits
from tepsipe.mechanics.segment_chain import Chain
from tepsipe.virtual_lab.standing_chain import STEP_S, ChainPerson, chain_protocol, record_chain

NEGLECTED = "neglected"
THREE, TWO, ONE = ("belt", "thigh", "pelvis"), ("belt", "thigh"), ("belt",)
PUSHES = ("shank", "thigh", "pelvis")
LEAN = (ONE, ("belt", "pelvis"), PUSHES, ("belt", "shank", "thigh"), ("belt", "shank", "pelvis"), THREE)
# name, model, sets (None: all), whether the person is symmetric, part of the seeds
CASES = {
    "exact": (
        ("any matrices, inertia exact", (False, EXACT), None, True, 1.0),
        ("symmetric matrices, inertia exact", (True, EXACT), (ONE, TWO, THREE), True, 1.0),
        ("any matrices, inertia unknown", (False, UNKNOWN), (ONE, TWO, THREE), True, 1.0),
        ("symmetric matrices, inertia unknown", (True, UNKNOWN), (ONE, TWO, THREE), True, 1.0),
        ("any matrices, inertia exact; person not symmetric", (False, EXACT), (THREE,), False, 0.3),
        (
            "symmetric matrices, inertia exact; person not symmetric",
            (True, EXACT),
            (ONE, TWO, THREE),
            False,
            0.3,
        ),
    ),
    "tolerance": (
        ("any matrices, inertia within 2 %", (False, WITHIN), LEAN, True, 1.0),
        ("any matrices, inertia off by 2 % and taken as exact", (False, NEGLECTED), (THREE,), True, 1.0),
    ),
}
HEADER = (
    "| Perturbations | Rank | Quoted (%) | RMS of K (%) | Bias of K (%) | Largest error of K (%) | "
    "All K within 15 % (%) | Coverage K (%) | Coverage B (%) | Rejected at 1 % (%) |"
)
ABOUT = (
    "Errors in per cent of sqrt(K_ii K_jj). Quoted: share of the seeds in which the elements of K have\n"
    "values; all other columns but rank and rejections are of these. Bias: of the element with the\n"
    "largest one. Coverage: of 95 % intervals, pooled over elements and seeds. Rejected: share of the\n"
    "seeds in which chi2 rejects the model."
)


def asymmetric(person):
    """The same person with reflexes across joints that act one way only (N·m/rad, N·m·s/rad)."""
    k, b = np.array(person.stiffness_Nm_per_rad), np.array(person.damping_Nms_per_rad)
    odd = np.array([[0.0, 1.0, 0.0], [-1.0, 0.0, 1.0], [0.0, -1.0, 0.0]])
    return replace(person, stiffness_Nm_per_rad=(k + 80.0 * odd).tolist(), damping_Nms_per_rad=b.tolist())


def recorded(person, protocol, seed: int) -> Recording:
    """One recording (rad, N, m/s²)."""
    record = record_chain(person, protocol, np.random.default_rng(seed))
    before = round(protocol.before_s * protocol.rate_hz)
    return Recording(record.unperturbed, record.angle, record.drive, protocol.rate_hz, 1.0 / STEP_S, before)


def row(chosen, drawn, person) -> str:
    """A line of the table."""
    truth = np.concatenate([np.ravel(x) for x in (person.stiffness_Nm_per_rad, person.damping_Nms_per_rad)])
    root = np.sqrt(np.diag(np.array(person.stiffness_Nm_per_rad)))
    ranks = [one.known.rank for one in drawn]
    unknowns = drawn[0].known.unknowns
    span = str(min(ranks)) if min(ranks) == max(ranks) else f"{min(ranks)} to {max(ranks)}"
    values = np.array([[e.value for e in one.entries] for one in drawn])
    halves = np.array([[e.half_width for e in one.entries] for one in drawn])
    quoted = np.isfinite(values)
    wrong = 100.0 * np.mean([one.fit.p_value < 0.01 for one in drawn])
    cells = [" + ".join(chosen), f"{span} of {unknowns}", f"{100.0 * quoted[:, :9].mean():.0f}"]
    if quoted[:, :9].any():
        errors = 100.0 * (values - truth)[:, :9] / np.outer(root, root).ravel()
        held = np.abs(values - truth) <= halves
        common = quoted[:, :9].mean(axis=0) > 0.5
        bias = np.nanmean(errors[:, common], axis=0) if common.any() else np.array([np.nan])
        any_quoted = quoted[:, :9].any(axis=1)
        cells += [
            f"{np.sqrt(np.nanmean(errors**2)):.1f}",
            f"{bias[np.abs(bias).argmax()]:.1f}" if common.any() else "–",
            f"{np.nanmax(np.abs(errors)):.1f}",
            f"{100.0 * np.mean(np.nanmax(np.abs(errors[any_quoted]), axis=1) <= 15.0):.0f}",
            f"{100.0 * held[:, :9][quoted[:, :9]].mean():.1f}",
            f"{100.0 * held[:, 9:][quoted[:, 9:]].mean():.1f}" if quoted[:, 9:].any() else "–",
        ]
    else:
        cells += ["–"] * 6
    return f"| {' | '.join([*cells, f'{wrong:.0f}'])} |"


def _part(seeds: int, part: float) -> int:
    return max(1, round(seeds * part))


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=100)
    parser.add_argument("--part", choices=CASES, default="tolerance")
    parser.add_argument("--epochs", type=int, default=None)
    given = parser.parse_args()
    seeds, chosen_cases = given.seeds, CASES[given.part]
    plan = yaml.safe_load((ROOT / "config/plan/config.yaml").read_text(encoding="utf-8"))["plan"]
    joints = plan["several_joints"]
    person = ChainPerson(**joints["person"])
    protocol = chain_protocol(joints["perturbations"], joints["protocol"], "auto")
    if given.epochs is not None:
        protocol = replace(protocol, epochs=given.epochs)
    chain, limits = Chain.from_settings(joints["person"]), Limits(**joints["limits"])
    points = {name: Point.from_settings(one) for name, one in joints["perturbations"].items()}
    tolerance = 0.01 * joints["inertia_percent"]
    estimates = {(case[0], chosen): [] for case in chosen_cases for chosen in case[2] or sets_of(points)}
    for symmetric, of_person in ((True, person), (False, asymmetric(person))):
        cases = [case for case in chosen_cases if case[3] == symmetric]
        for seed in range(_part(seeds, max(case[4] for case in cases)) if cases else 0):
            recording = recorded(of_person, protocol, seed)
            measured = chain.drawn(np.random.default_rng([seed, 3]), tolerance)
            for name, (symmetry, inertia), sets, _, part in cases:
                if seed >= _part(seeds, part):
                    continue
                used = measured if inertia in (WITHIN, NEGLECTED) else chain
                model = (symmetry, EXACT if inertia == NEGLECTED else inertia)
                epochs = epochs_of(recording, used, points, model, tolerance)
                for chosen in sets or sets_of(points):
                    estimates[name, chosen].append(estimate(epochs, chosen, limits))
            print(seed, end=" ", flush=True, file=sys.stderr)
    if given.part == "exact":
        print(f"# Stiffness matrix of ankle, knee and hip\n\n{ABOUT}")
    command = f"benchmarks/several_joints.py --part {given.part} --epochs {protocol.epochs} --seeds {seeds}"
    print(f"\n*By `{command}`,\n{protocol.epochs} epochs of each perturbation, 250 ms after the onset:*")
    for name, _, sets, symmetric, part in chosen_cases:
        print(f"\n## {name[0].upper()}{name[1:]}, {_part(seeds, part)} seeds\n\n{HEADER}")
        print("|---|" + "---|" * (HEADER.count("|") - 2))
        for chosen in sets or sets_of(points):
            print(row(chosen, estimates[name, chosen], person if symmetric else asymmetric(person)))


if __name__ == "__main__":
    main()
