"""K and B of the ankle in walking against the truth, on resampled real strides with simulated responses.

    OMP_NUM_THREADS=1 .venv/bin/python benchmarks/walking.py [FOLDER] [--seeds 100]

FOLDER holds UnpertPre_data.csv.gz and UnpertPre__event.csv.gz (Moore, Hnat & van den Bogert 2015, PeerJ
3:e918), by default ``walking`` in the folder that TEPSIPE_REAL_DATA names. The results stand in
benchmarks/walking.md.
"""

import argparse
import os
import time
from dataclasses import replace
from pathlib import Path

import numpy as np

from tepsipe.experiments.walking.analysis import analyse_walking
from tepsipe.experiments.walking.files import read_events, read_recording
from tepsipe.experiments.walking.options import WalkingOptions
from tepsipe.experiments.walking.strides import agreement, ankle_moment, bandwidth_hz, segment_strides
from tepsipe.virtual_lab.walker import Joint, Walk, perturb, resample_walk

COLUMNS = {
    "time": "time",
    "angle": "LeftAnklePlantarFlexionAngle",
    "vertical": "LeftGRF_y",
    "anterior": "LeftGRF_x",
    "cop": "LeftCOP_x",
    "ankle_x": "LeftFoot_x",
    "ankle_y": "LeftFoot_y",
    "other_vertical": "RightGRF_y",
    "supplied_moment": "LeftAnklePlantarFlexionMoment",
    "knee": "LeftKneeFlexionAngle",
    "hip": "LeftHipFlexionAngle",
    "com": "COM_x",
}
RAMP_S, NOISE_RAD, STRIDES = 0.06, np.deg2rad(0.05), 460
LOOP = {
    "A": (1.5, {40.0: 50, 60.0: 50, 80.0: 50}),
    "B": (2.0, {20.0: 82, 40.0: 30, 60.0: 15, 80.0: 23}),
    "P": (2.0, {20.0: 115, 40.0: 15, 60.0: 10, 80.0: 10}),  # as tables/needed.csv divides 150 strides
}


def real_walk(folder):
    """The recording, its strides after 8 s, and both as a walk that can be resampled."""
    recording = read_recording(folder / "UnpertPre_data.csv.gz", COLUMNS, 100.0, 0.15)
    events = read_events(folder / "UnpertPre__event.csv.gz", {"heel_strike": "lhs", "toe_off": "lto"})
    strides = segment_strides(events["heel_strike"], events["toe_off"], from_s=8.0)
    signals = {
        name: getattr(recording, name)
        for name in ("angle", "vertical", "anterior", "cop", "ankle_x", "ankle_y", "other_vertical")
    }
    heel = np.append(strides.start, strides.end[-1])
    return recording, strides, Walk(100.0, signals | recording.state, heel, strides.start + strides.stance)


def one(base, recording, seed, degrees, counts, *, gain=25.0, options=None):
    """One simulated experiment and its analysis."""
    rng = np.random.default_rng(seed)
    walk = resample_walk(base, STRIDES, rng)
    slots = rng.permutation(np.arange(2, STRIDES - 2, 3))[: sum(counts.values())]
    phases = rng.permutation(np.repeat(list(counts), list(counts.values())))
    joint = Joint(reflex_Nms_per_rad=gain)
    pulses = dict(zip(slots.tolist(), phases.tolist(), strict=True))
    walk = perturb(walk, joint, pulses, np.deg2rad(degrees), RAMP_S, NOISE_RAD, rng)
    replaced = {name: values for name, values in walk.signals.items() if name not in recording.state}
    simulated = replace(
        recording,
        name=f"seed {seed}",
        time=np.arange(walk.signals["angle"].size) / walk.rate_hz,
        state={name: walk.signals[name] for name in recording.state},
        supplied_moment=None,
        **replaced,
    )
    strides = segment_strides(walk.heel_strikes, walk.toe_offs)
    return analyse_walking(simulated, strides, walk.onsets, options or WalkingOptions()), joint


def stiffness_at(impedance, percent):
    """K (N·m/rad) at a phase (%), on the line through the nearest two."""
    usable = [phase for phase, fit in impedance.phases.items() if not fit.flags]
    near = sorted(usable, key=lambda phase: abs(impedance.at_percent[phase] - percent))[:2]
    if len(near) < 2:
        return float("nan")
    (a, b), (first, second) = ([x[p] for p in near] for x in (impedance.at_percent, impedance.phases))
    share = (percent - a) / (b - a)
    return float((1.0 - share) * first.values[2] + share * second.values[2])


def scenario(base, recording, seeds, degrees, counts, **choices):
    """Per seed and phase: phase, K, truth, covered, B, truth, covered, K there, truth, flag, its phase."""
    rows = []
    for seed in range(seeds):
        impedance, joint = one(base, recording, seed, degrees, counts, **choices)
        for phase, fit in impedance.phases.items():
            at = impedance.at_percent[phase]
            truth_k, truth_b = float(joint.stiffness(at)), float(joint.damping(at))
            nominal = stiffness_at(impedance, phase)
            rows.append(
                (
                    phase,
                    fit.values[2],
                    truth_k,
                    fit.low[2] <= truth_k <= fit.high[2],
                    fit.values[1],
                    truth_b,
                    fit.low[1] <= truth_b <= fit.high[1],
                    nominal,
                    float(joint.stiffness(phase)),
                    bool(fit.flags),
                    at,
                )
            )
    return np.array(rows, dtype=float)


def show(title, rows, counts):
    """Print a table of one scenario."""
    print(f"\n{title}\n")
    columns = (
        "phase %",
        "strides",
        "K belongs to %",
        "bias of K %",
        "RMS of K %",
        "covered K %",
        "at the phase: RMS of K %",
        "B found (true)",
        "RMS of B %",
        "covered B %",
    )
    print("|", " | ".join(columns), "|")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for phase in counts:
        x = rows[rows[:, 0] == phase]
        k, b, nominal = (x[:, i] / x[:, i + 1] - 1.0 for i in (1, 4, 7))
        print(
            f"| {phase:g} | {counts[phase]} | {x[:, 10].mean():.0f} | {100 * k.mean():+.1f} | "
            f"{100 * np.sqrt(np.mean(k**2)):.1f} | {100 * x[:, 3].mean():.0f} | "
            f"{100 * np.sqrt(np.mean(nominal**2)):.1f} | {x[:, 4].mean():.2f} ({x[:, 5].mean():.2f}) | "
            f"{100 * np.sqrt(np.mean(b**2)):.0f} | {100 * x[:, 6].mean():.0f} |"
        )
    print(f"\nPooled coverage: K {100 * rows[:, 3].mean():.1f} %, B {100 * rows[:, 6].mean():.1f} %.")


def main():
    """Print all tables."""
    parser = argparse.ArgumentParser(description=__doc__)
    default = Path(os.environ.get("TEPSIPE_REAL_DATA", "recordings")) / "walking"
    parser.add_argument("folder", nargs="?", type=Path, default=default)
    parser.add_argument("--seeds", type=int, default=100)
    parser.add_argument("--parts", default="ABPermz")
    chosen = parser.parse_args()
    recording, strides, base = real_walk(chosen.folder)
    rebuilt = ankle_moment(recording)
    print(
        f"{len(strides)} strides; bandwidth of the supplied moment "
        f"{bandwidth_hz(recording.supplied_moment, rebuilt, 100.0):.1f} Hz; rebuilt moment differs by "
        f"{agreement(recording, strides.in_stance(recording.time)):.2f} N m RMS below 6 Hz"
    )
    began, kept = time.process_time(), {}
    for name in ("A", "B"):
        degrees, counts = LOOP[name]
        if name in chosen.parts or "r" in chosen.parts:
            kept[name] = scenario(base, recording, chosen.seeds, degrees, counts)
            show(f"{degrees:g} degrees", kept[name], counts)
        if "r" in chosen.parts:
            doubled = scenario(base, recording, chosen.seeds, degrees, counts, gain=50.0)
            shift = doubled[:, 1] / kept[name][:, 1] - 1.0
            means = [f"{p:g} %: {100 * shift[doubled[:, 0] == p].mean():+.2f} %" for p in counts]
            print(f"\nK moves with twice the reflex gain: {', '.join(means)}.")
    if "P" in chosen.parts:
        degrees, counts = LOOP["P"]
        show(
            f"{degrees:g} degrees, as planned",
            scenario(base, recording, chosen.seeds, degrees, counts),
            counts,
        )
    if "e" in chosen.parts:  # begun so early that K belongs to 20, 40, 60, 80 %
        for name in ("A", "B"):
            degrees, counts = LOOP[name]
            early = {phase - 6.0: number for phase, number in counts.items()}
            options = WalkingOptions(phases_percent=tuple(early))
            rows = scenario(base, recording, chosen.seeds, degrees, early, options=options)
            show(f"{degrees:g} degrees, 6 % of stance earlier", rows, early)
    if "m" in chosen.parts:
        plain = scenario(base, recording, chosen.seeds, *LOOP["B"], options=WalkingOptions(matched_by=()))
        show("2 degrees, plain mean of unperturbed strides", plain, LOOP["B"][1])
    if "z" in chosen.parts:
        zero = scenario(base, recording, chosen.seeds, 0.0, LOOP["B"][1])
        print(f"\nPulses of no size: {100 * zero[:, 9].mean():.1f} % of the intervals are infinite.")
    print(f"\n{time.process_time() - began:.0f} s of CPU time.")


if __name__ == "__main__":
    main()
