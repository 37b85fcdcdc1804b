"""Power of the checks of a dummy trial: the size of each fault that nine of ten trials show.

    .venv/bin/python benchmarks/dummy_checks.py > benchmarks/dummy_checks.md

One motion per amplitude; noise, trigger and clocks are drawn for every trial, and the fault is added to
the markers or to the assumptions of the analysis. Sizes grow until nine of ten trials are flagged.
Errors of K at that size are given for the joint likelihood and for `leg`, against the linear joint
nearest to the true one in the windows. The analysis assumes the shipped sources of uncertainty; the rod
of a clean trial bends by a draw from them.
"""

import argparse
from collections import Counter
from dataclasses import replace

import dummy_trials as lab
import numpy as np
import yaml
from joint_likelihood import row
from scipy.signal import lfilter

from tepsipe.experiments.dummy.checks import check_dummy
from tepsipe.experiments.dummy.leg_pathways import analyse_dummy
from tepsipe.experiments.dummy.options import Pathway
from tepsipe.statistics.uncertainty import sources_of

PATHWAYS = {
    "leg": Pathway("leg", "aligned", "windowed-least-squares"),
    "leg-joint-likelihood": Pathway("leg", "aligned", "joint-likelihood"),
}
KNOWN_INERTIA = (0.007, 0.0005)
CONFIG = yaml.safe_load((lab.ROOT / "config/config.yaml").read_text(encoding="utf-8"))
OPTIONS = replace(lab.OPTIONS, sources=sources_of(CONFIG["uncertainty"]["dummy"]))
BELIEVED = OPTIONS.sources["leg_bending_rad_per_m_per_s2"].standard_uncertainty
# from one tried size to the next
STEP = 1.5
FOOT, ANKLE, ON_LEG = slice(0, 3), 3, slice(3, 8)


def wobble(size_m: float, growing: bool):
    """Markers of the leg lag behind the foot's acceleration, 12 Hz with a damping ratio of 0.3.

    ``size_m`` is the largest displacement, of all markers alike or at the top of the leg.
    """

    def broken(positions, motion, rng):
        step, natural = 1.0 / lab.RATE_HZ, 2.0 * np.pi * 12.0
        pole = np.exp((-0.3 + 1j * np.sqrt(1.0 - 0.09)) * natural * step)
        lag = lfilter([1.0], [1.0, -2.0 * pole.real, abs(pole) ** 2], motion.foot_dd)
        lag = -size_m * lag / np.abs(lag).max()
        heights = np.array([row[1] for row in lab.LAYOUT])
        share = heights / heights.max() if growing else np.ones(5)
        positions[:, ON_LEG, 0] += np.outer(lag, share)
        return positions

    return broken


def bend(lag: float):
    """The rod lags behind the acceleration of its foot by an angle (rad per m/s²)."""

    def broken(positions, motion, rng):
        positions[:, ON_LEG, 0] += lag * np.outer(motion.foot_dd, [row[1] for row in lab.LAYOUT])
        return positions

    return broken


def bend_as_believed(positions, motion, rng):
    """The rod bends by an angle from the distribution assumed in the analysis."""
    return bend(BELIEVED * rng.standard_normal())(positions, motion, rng)


def slip(size_m: float, marker: int, same_way: bool):
    """A marker is displaced in every pulse and comes back after it, or stays where a random step takes it."""

    def broken(positions, motion, rng):
        time = np.arange(len(positions)) / lab.RATE_HZ
        for onset in motion.onsets_s:
            since = np.maximum(time - onset, 0.0)
            if same_way:
                positions[:, marker, 0] += size_m * since / 0.05 * np.exp(1.0 - since / 0.05)
            else:
                positions[:, marker, 0] += size_m * rng.standard_normal() * (1.0 - np.exp(-since / 0.02))
        return positions

    return broken


def tilt(size_rad: float):
    """The foot tilts with its acceleration, largest by ``size_rad``; the ankle, 55 mm up, moves with it."""

    def broken(positions, motion, rng):
        angle = size_rad * motion.foot_dd / np.abs(motion.foot_dd).max()
        places = np.array(lab.LAB["dummy"]["markers"]["foot_m"])
        positions[:, FOOT, 0] += np.outer(angle, places[:, 1])
        positions[:, FOOT, 1] -= np.outer(angle, places[:, 0])
        positions[:, ON_LEG, 0] += 0.055 * angle[:, None]
        return positions

    return broken


def skew(size_s: float):
    """Sequential sampling is ignored: every marker is later by ``size_s`` than the one before."""

    def broken(positions, motion, rng):
        rate = np.gradient(positions, 1.0 / lab.RATE_HZ, axis=0)
        return positions + size_s * np.arange(positions.shape[1])[:, None] * rate

    return broken


MARKER_FAULTS = {
    "rod bends (µrad per m/s²)": (1e-6, bend),
    "wobble of all leg markers alike (mm)": (1e-3, lambda x: wobble(x, False)),
    "wobble growing with height (mm)": (1e-3, lambda x: wobble(x, True)),
    "foot marker slips and returns (mm)": (1e-3, lambda x: slip(x, 0, True)),
    "foot marker slips and stays (mm)": (1e-3, lambda x: slip(x, 0, False)),
    "ankle marker slips and returns (mm)": (1e-3, lambda x: slip(x, ANKLE, True)),
    "ankle marker slips and stays (mm)": (1e-3, lambda x: slip(x, ANKLE, False)),
    "foot tilts (mrad)": (1e-3, tilt),
    "sampling of markers forgotten (ms per marker)": (1e-3, skew),
}
BELIEF_FAULTS = {
    "leg's mass too large (%)": (0.01, lambda x: lab.with_leg(OPTIONS, mass_kg=0.4 * (1.0 + x))),
    "leg's inertia too large (%)": (0.01, lambda x: lab.with_leg(OPTIONS, inertia_kgm2=0.027 * (1.0 + x))),
}


def look(motion: lab.Motion, instruments: lab.Instruments, seed: int, broken=None, options=OPTIONS):
    """Flags of one trial, and errors of K (%) by joint likelihood and by leg."""
    trial = motion.trial(np.random.default_rng([seed, 11]), instruments, broken)
    analysis = analyse_dummy(trial, options, PATHWAYS)
    verdict = check_dummy(trial, options, analysis, ("leg-joint-likelihood", "leg"), KNOWN_INERTIA)
    names = {flag for flags in verdict.flags.values() for flag in flags} - {"noise-biased"}
    truth = motion.at_work(analysis.regressions["leg"].perturbations)[2]
    return names, [100.0 * (analysis.regressions[n].mean[2] / truth - 1.0) for n in reversed(PATHWAYS)]


def detected(motion: lab.Motion, instruments: lab.Instruments, unit: float, fault, count: int, start: float):
    """Smallest size detected in nine of ten trials, its flags, mean errors of K; None if none is."""
    size = start
    while size < 300.0 * start:
        made = fault(size * unit)
        kind = {"options": made} if isinstance(made, type(OPTIONS)) else {"broken": made}
        seen, missed = [], 0
        for seed in range(count):
            seen.append(look(motion, instruments, seed, **kind))
            missed += not seen[-1][0]
            if missed > 0.1 * count:
                break
        else:
            return size, [names for names, _ in seen], np.mean([errors for _, errors in seen], axis=0)
        size *= STEP
    return None


def main() -> None:
    """Write false alarms and power as Markdown to the standard output."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=10, help="trials per size")
    parser.add_argument("--clean", type=int, default=60, help="trials without a fault, per condition")
    parser.add_argument("--noises", type=float, nargs="+", default=[0.0065, 0.1], help="of markers (mm)")
    given = parser.parse_args()
    print("# Checks of a dummy trial: false alarms and power\n")
    print(
        f"`benchmarks/dummy_checks.py`, {given.clean} clean trials a condition, {given.seeds} trials a size\n"
        f"of a fault, sizes in steps of {STEP:g}. The joint's inertia is known to 0.0005 N·m·s²/rad.\n"
        "No row counts `noise-biased`.\n"
    )
    motions = {c: lab.Motion(c) for c in ("sine-0.1", "sine-0.3", "minjerk-0.5")}
    if given.clean:
        print(row("condition", "marker noise (mm)", "clean trials flagged", "by"))
        print("|---" * 4 + "|")
    for condition, motion in motions.items() if given.clean else ():
        for noise in given.noises:
            instruments = lab.Instruments(marker_noise_m=1e-3 * noise)
            names = [
                look(motion, instruments, 1000 + seed, bend_as_believed)[0] for seed in range(given.clean)
            ]
            by = Counter(flag for raised in names for flag in raised)
            count = sum(map(bool, names))
            cells = (f"{count} of {len(names)}", ", ".join(f"{k} {v}" for k, v in by.items()) or "–")
            print(row(condition, f"{noise:g}", *cells), flush=True)
    for noise in given.noises if given.seeds else ():
        instruments = lab.Instruments(marker_noise_m=1e-3 * noise)
        print(f"\n## sine-0.3, marker noise {noise:g} mm\n")
        print(row("fault", "size found in 9 of 10 trials", "error of K, joint likelihood / leg (%)", "by"))
        print("|---" * 4 + "|")
        for name, (unit, fault) in (MARKER_FAULTS | BELIEF_FAULTS).items():
            start = 2.0 if name in BELIEF_FAULTS else 0.3 if fault is bend else 0.01
            detection = detected(motions["sine-0.3"], instruments, unit, fault, given.seeds, start)
            if detection is None:
                print(row(name, "none", "–", "–"), flush=True)
                continue
            size, names, errors = detection
            by = Counter(flag for raised in names for flag in raised)
            flags = ", ".join(k for k, v in by.most_common() if v >= 0.5 * len(names))
            print(row(name, f"{size:.2g}", f"{errors[0]:+.2f} / {errors[1]:+.2f}", flags), flush=True)


if __name__ == "__main__":
    main()
