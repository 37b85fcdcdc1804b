"""Efficiency of the joint likelihood against the Cramér-Rao bound, and coverage of its intervals.

    .venv/bin/python benchmarks/joint_likelihood.py --seeds 200 > benchmarks/joint_likelihood.md

One motion is integrated for each condition; noise, trigger and clocks are drawn for every seed. The
bound holds for the exact motion and the true noise levels. The motion of the foot is unknown at
every frequency up to 100 Hz, and so are delay, joint centre, lag, gain and drift of the log, and the
leg's free swing. Its derivatives are differences of the transfer function, written
down here.
"""

import argparse
import time

import dummy_trials as lab
import numpy as np

from tepsipe.experiments.dummy.leg_pathways import analyse_dummy
from tepsipe.experiments.dummy.options import Pathway
from tepsipe.mechanics.impedance_model import SMALL

CONDITIONS = ("sine-0.1", "sine-0.3", "sine-0.5", "minjerk-0.3")
NOISES_M = (0.0000065, 0.0001)
PATHWAYS = {
    "linear": Pathway("leg", "aligned", "joint-likelihood-linear"),
    "joint": Pathway("leg", "aligned", "joint-likelihood"),
}
TODAY = {"today": Pathway("leg", "aligned", "output-error")}


def bound(motion: lab.Motion, instruments: lab.Instruments) -> np.ndarray:
    """Cramér-Rao bound of the standard deviations of I, B, K for a linear joint."""
    n, leg = motion.instants.size, lab.LEG
    kept = slice(round(0.1 * n / lab.RATE_HZ), round(100.0 * n / lab.RATE_HZ))
    s = (2j * np.pi * np.fft.rfftfreq(n, 1.0 / lab.RATE_HZ))[kept]
    # the net displacement is no step between the trial's end and its start: it leaves as a smooth ramp
    u = np.arange(n) / n
    ramp = (motion.foot[-1] - motion.foot[0]) * u**3 * (10.0 - 15.0 * u + 6.0 * u**2)
    foot = np.fft.rfft(motion.foot - ramp)[kept]
    p = leg.mass_kg * leg.com_m
    x = np.array([leg.inertia_kgm2 + p * leg.com_m + motion.inertia, *motion.small[1:], 0.0, 0.0, 1.0, 0.0])

    along = np.array([row[1] for row in lab.LAYOUT])

    def response(x):
        swing = -p * s**2 / (x[0] * s**2 + x[1] * s + x[2] - p * leg.gravity_m_per_s2) * np.exp(-s * x[3])
        on_leg = 1.0 + (along[:, None] + x[6]) * swing
        return np.array([*[np.ones_like(s)] * 3, *on_leg, x[5] * np.exp(-s * x[4]) * s])

    steps = np.array([1e-6, 1e-5, 1e-4, 1e-7, 1e-7, 1e-6, 1e-6])
    slopes = np.array([(response(x + d) - response(x - d)) * foot / (2.0 * d.sum()) for d in np.diag(steps)])
    inverse = 1.0 / (x[0] * s**2 + x[1] * s + x[2] - p * leg.gravity_m_per_s2)

    def markers_and_log(angle, log):
        return np.array([*[np.zeros_like(s)] * 3, *np.outer(along, angle), log])

    swings = [markers_and_log(inverse * forcing, np.zeros_like(s)) for forcing in (np.ones_like(s), s)]
    since = np.arange(n) - 0.5 * n
    drift = np.fft.rfft(since / lab.RATE_HZ * motion.foot_dd)[kept]
    columns = np.array([*slopes, *swings, markers_and_log(np.zeros_like(s), drift)])
    noise = np.full(9, instruments.marker_noise_m)
    noise[8] = 0.5 * instruments.log_noise_m_per_s
    white = np.diag(1.0 / (np.sqrt(n) * noise))
    direction = white @ response(x)
    direction = direction / np.linalg.norm(direction, axis=0)
    columns = white @ columns
    columns = columns - direction * np.sum(direction.conj() * columns, axis=1)[:, None]
    flat = columns.reshape(len(columns), -1)
    flat = np.concatenate([flat.real, flat.imag], axis=1)
    scale = np.linalg.norm(flat, axis=1)
    information = 2.0 * (flat / scale[:, None]) @ (flat / scale[:, None]).T
    return (np.sqrt(np.diag(np.linalg.inv(information))) / scale)[:3]


def draws(motion: lab.Motion, instruments: lab.Instruments, seeds: range, pathways: dict) -> dict:
    """Pathway -> estimates and standard errors (working, then small I, B, K), truth, CPU time of a fit."""
    estimates = {name: ([], []) for name in pathways}
    truth, spent = None, 0.0
    for seed in seeds:
        trial = motion.trial(np.random.default_rng([seed, 7]), instruments)
        start = time.process_time()
        analysis = analyse_dummy(trial, lab.OPTIONS, pathways)
        spent += time.process_time() - start
        for name, fit in analysis.regressions.items():
            small = getattr(fit, "small", fit.mean)
            errors = analysis.budgets[name].type_a
            estimates[name][0].append([*fit.mean, *small])
            own = analysis.quantities[name]
            of_small = [own[q].u_type_a for q in SMALL] if SMALL[0] in own else errors
            estimates[name][1].append([*errors, *of_small])
        if truth is None:
            truth = np.array([*motion.at_work(fit.perturbations), *motion.small])
    each = spent / len(seeds) / len(pathways)
    return {name: (np.array(a), np.array(b), truth, each) for name, (a, b) in estimates.items()}


def row(*cells) -> str:
    """Row of a table."""
    return "| " + " | ".join(str(c) for c in cells) + " |"


def numbers(values, digits: int) -> str:
    """Numbers with so many decimals."""
    return " ".join(f"{v:.{digits}f}" for v in values)


def linear_table(seeds: range, today: range) -> None:
    """Efficiency on a linear joint."""
    print("## Linear joint (K = 10 N·m/rad, B = 0.1 N·m·s/rad)\n")
    print(
        row(
            "condition",
            "noise (mm)",
            "bound / variance, linear",
            "law that softens",
            "output error",
            "coverage, linear (%)",
            "bias / bound, linear",
            "CPU-s",
        )
    )
    print("|---" * 8 + "|")
    for condition in CONDITIONS:
        motion = lab.Motion(condition, lab.LINEAR_RUBBER)
        for noise in NOISES_M:
            instruments = lab.Instruments(marker_noise_m=noise)
            limit = bound(motion, instruments)
            estimates = draws(motion, instruments, seeds, {"linear": PATHWAYS["linear"]})
            estimates |= draws(motion, instruments, today, {"joint": PATHWAYS["joint"]})
            old = draws(motion, instruments, today, TODAY)["today"][0][:, :3]
            x, errors, truth, cpu = estimates["linear"]
            other = estimates["joint"][0][:, 3:]
            z = (x[:, 3:] - truth[3:]) / errors[:, 3:]
            print(
                row(
                    condition,
                    f"{1e3 * noise:g}",
                    numbers(limit**2 / x[:, 3:].var(axis=0, ddof=1), 2),
                    numbers(limit**2 / other.var(axis=0, ddof=1), 2),
                    numbers(limit**2 / old.var(axis=0, ddof=1), 2),
                    numbers(100.0 * (np.abs(z) < 1.96).mean(axis=0), 0),
                    numbers((x[:, 3:].mean(axis=0) - truth[3:]) / limit, 2),
                    f"{cpu:.2f}",
                ),
                flush=True,
            )


def softening_table(seeds: range) -> None:
    """Coverage on the shipped rubber."""
    print("\n## Rubber of the shipped laboratory: `joint-likelihood`\n")
    print(
        row(
            "condition",
            "noise (mm)",
            "standard error, working (%)",
            "bias, working (%)",
            "coverage, working (%)",
            "standard error, small (%)",
            "bias, small (%)",
            "coverage, small (%)",
        )
    )
    print("|---" * 8 + "|")
    for condition in CONDITIONS:
        motion = lab.Motion(condition)
        for noise in NOISES_M:
            estimates = draws(
                motion, lab.Instruments(marker_noise_m=noise), seeds, {"joint": PATHWAYS["joint"]}
            )
            x, errors, truth, _ = estimates["joint"]
            cells = []
            for part in (slice(0, 3), slice(3, 6)):
                z = (x[:, part] - truth[part]) / errors[:, part]
                cells += [
                    numbers(100.0 * errors[:, part].mean(axis=0) / truth[part], 2),
                    numbers(100.0 * (x[:, part].mean(axis=0) / truth[part] - 1.0), 2),
                    numbers(100.0 * (np.abs(z) < 1.96).mean(axis=0), 0),
                ]
            print(row(condition, f"{1e3 * noise:g}", *cells), flush=True)


def main() -> None:
    """Write both tables as Markdown to the standard output."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seeds", type=int, default=200, help="trials per condition")
    parser.add_argument(
        "--today",
        type=int,
        default=40,
        help="of them by output error and with softening, and trials of the shipped rubber",
    )
    given = parser.parse_args()
    print("# Joint likelihood of the dummy: efficiency and coverage\n")
    print(
        f"`benchmarks/joint_likelihood.py`, {given.seeds} seeds ({given.today} for output error,\n"
        "for the law that softens, and for the shipped rubber). "
        "Three numbers in a cell: I, B, K.\n"
    )
    linear_table(range(given.seeds), range(given.today))
    softening_table(range(given.today))


if __name__ == "__main__":
    main()
