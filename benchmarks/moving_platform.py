"""Bias, coverage and refusals of the impedance of ankle and hip on a moving platform, by simulated persons.

    python benchmarks/moving_platform.py --seeds 100 > benchmarks/moving_platform.md     # a minute
    python benchmarks/moving_platform.py --table FILE [--reflex] [--push N]       # one person as a table

Every seed is another motion of the platform, another sway and other noise, of the same person.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

from tepsipe.identification.several_joints.closed_loop import MultiJointOptions, banded_spectra, fit_row
from tepsipe.identification.several_joints.quantities import joint_quantities, slow_mode
from tepsipe.virtual_lab.platform_person import PlatformPerson, PlatformProtocol, record_platform

OPTIONS = MultiJointOptions(
    band_hz=(0.05, 5.0), averaged_bins=20, taper_fraction=0.02, delays_s=(0.04, 0.3), delay_step_s=0.02
)
JOINTS = ("ankle", "hip")
PUSH_N = 30.0
ABOUT = (
    "300 s of a simulated person,\n"
    f"own torque of 8 and 4 N·m, push of {PUSH_N:g} N. Identified: share of the seeds in which the\n"
    "quantity is quoted. Median and spread (standard deviation) of the quoted values, coverage of\n"
    "their 95 % intervals. Regression: median of ordinary least squares of the same model. Rejected:\n"
    "share of the seeds in which the model is rejected at 1 %."
)
HEADER = "| Quantity | Truth | Identified (%) | Median | Spread | Coverage (%) | Regression | Rejected (%) |"
INTRINSIC, REFLEX = PlatformPerson(), PlatformPerson().with_reflex()
# person, push (N), model, and part of the seeds: fits of delays take longer
CASES = (
    ("no reflexes, platform only", INTRINSIC, 0.0, "intrinsic", 1.0),
    ("no reflexes, platform only", INTRINSIC, 0.0, "all-reflex", 0.06),
    ("reflexes, platform only", REFLEX, 0.0, "intrinsic", 0.06),
    ("reflexes, platform only", REFLEX, 0.0, "own-reflex", 0.2),
    ("reflexes, platform only", REFLEX, 0.0, "all-reflex", 0.06),
    ("reflexes, platform and push", REFLEX, PUSH_N, "all-reflex", 0.2),
)


def truth_of(person: PlatformPerson, mode: np.ndarray) -> dict[str, float]:
    """True value of every quantity, with the slow mode of the record."""
    at_once = np.array(person.stiffness_Nm_per_rad)
    reflex = np.array(person.reflex_stiffness_Nm_per_rad)
    tables = {
        "K": at_once,
        "B": np.array(person.damping_Nms_per_rad),
        "K_reflex": reflex,
        "B_reflex": np.array(person.reflex_damping_Nms_per_rad),
        "K_static": at_once + reflex,
    }
    truth = {
        f"{kind}_{torque}_{angle}": float(table[i, j])
        for kind, table in tables.items()
        for i, torque in enumerate(JOINTS)
        for j, angle in enumerate(JOINTS)
    }
    for i, joint in enumerate(JOINTS):
        truth[f"K_mode_{joint}"] = float((at_once + reflex)[i] @ mode)
        truth[f"delay_{joint}"] = person.delay_s[i]
    return truth


def one_seed(person: PlatformPerson, push: float, model: str, seed: int) -> dict:
    """Truth, value, interval, regression (units of the quantities) of every quantity, and rejection."""
    record = record_platform(person, PlatformProtocol(push_N=push, step_s=0.01), np.random.default_rng(seed))
    u = np.column_stack([record.platform, record.push]) if push else record.platform
    spectra = banded_spectra(u, record.angle, record.torque, 50.0, OPTIONS)
    truth = truth_of(person, slow_mode(spectra, 0.5))
    scores = {}
    for joint in range(2):
        fit = fit_row(spectra, joint, model, OPTIONS)
        quantities = joint_quantities(fit, spectra, joint, JOINTS, 0.1, 0.5)
        for k, (name, quantity) in enumerate(quantities.items()):
            direct = fit.direct[k] if k < len(fit.terms) else np.nan
            scores[name] = (
                truth[name],
                quantity.value,
                quantity.low,
                quantity.high,
                direct,
                fit.p_value < 0.01,
            )
    return scores


def report(seeds: int, cases) -> None:
    """Print the tables of some cases."""
    print("# Impedance of ankle and hip on a moving platform\n")
    print(f"*By `python benchmarks/moving_platform.py --seeds {seeds}`: {ABOUT}*")
    for name, person, push, model, part in cases:
        used = round(part * seeds)
        done = [one_seed(person, push, model, seed) for seed in range(used)]
        print(f"\n## {name}, model {model}, {used} seeds\n")
        print(HEADER)
        print("|---" * 8 + "|")
        for quantity in done[0]:
            print(_line(quantity, np.array([of[quantity] for of in done], dtype=float)))


def _line(quantity: str, rows: np.ndarray) -> str:
    truth, value, low, high, direct, rejected = rows.T
    there = np.isfinite(value)
    cells = [quantity, f"{np.median(truth):.4g}", f"{100 * there.mean():.0f}"]
    if there.any():
        covered = (low <= truth) & (truth <= high)
        cells += [f"{np.median(value[there]):.4g}", f"{value[there].std():.2g}"]
        cells.append(f"{100 * covered[there].mean():.0f}")
    else:
        cells += ["–", "–", "–"]
    cells.append(f"{np.median(direct):.4g}" if np.isfinite(direct).all() else "–")
    return "| " + " | ".join([*cells, f"{100 * rejected.mean():.0f}"]) + " |"


def write_table(path: Path, person: PlatformPerson, push: float, seed: int) -> None:
    """Write one person of 310 s as a table that the experiment platform reads."""
    record = record_platform(
        person, PlatformProtocol(duration_s=310.0, push_N=push), np.random.default_rng(seed)
    )
    columns = [record.time, record.platform, record.angle, record.torque, record.push]
    path.parent.mkdir(parents=True, exist_ok=True)
    header = "time_s,platform_m,ankle_angle_rad,hip_angle_rad,ankle_torque_Nm,hip_torque_Nm,push_N"
    np.savetxt(path, np.column_stack(columns), delimiter=",", header=header, comments="", fmt="%.9g")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=100)
    parser.add_argument("--case", type=int, help="number of a case, from 0, in place of all")
    parser.add_argument("--table", type=Path)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--reflex", action="store_true", help="a person with reflexes")
    parser.add_argument("--push", type=float, default=0.0, help="standard deviation of a push at the hip (N)")
    chosen = parser.parse_args()
    if chosen.table is None:
        report(chosen.seeds, CASES if chosen.case is None else CASES[chosen.case : chosen.case + 1])
    else:
        write_table(chosen.table, REFLEX if chosen.reflex else INTRINSIC, chosen.push, chosen.seed)
    sys.exit(0)
