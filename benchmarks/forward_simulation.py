# ruff: noqa: E402
"""Time to simulate a trial of the ankle dummy, relative to the trial and to the bare steps of PyBullet.

    python benchmarks/forward_simulation.py [TRIAL]

TRIAL is a trial's HDF5 file, for example results/trials/dummy/sine-0.5.h5; without it a belt is made up.
"""

import os

for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ[f"{library}_NUM_THREADS"] = "1"

import sys
import time
from pathlib import Path

import numpy as np
import pybullet
import yaml

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from tepsipe.io.trial import read_trial
from tepsipe.mechanics import forward_dynamics as forward_simulation
from tepsipe.mechanics.forward_dynamics import Joint, simulate_dummy
from tepsipe.mechanics.inverse_dynamics import Foot, Leg
from tepsipe.signals.filters import butterworth_lowpass
from workflow.support.settings import settings_of

JOINT = Joint(inertia_Nms2_per_rad=0.0, damping_Nms_per_rad=0.1, stiffness_Nm_per_rad=10.0)
STEPS_S = (0.001, 0.002, 0.004)
REPETITIONS = 5


def recorded(path: Path, analysis: dict) -> tuple[np.ndarray, np.ndarray]:
    """Instants (s) and filtered belt velocity (m/s) of a trial."""
    trial = read_trial(path)
    cutoff, order = analysis["lowpass_cutoff_hz"], analysis["lowpass_order"]
    return trial.time, butterworth_lowpass(trial.values("belt_velocity"), trial.rate_hz, cutoff, order)


def made_up(duration_s: float = 70.0, rate_hz: float = 250.0) -> tuple[np.ndarray, np.ndarray]:
    """A belt that makes one period of a 10 Hz sine of 0.5 m/s every 4 s (s, m/s)."""
    instants = np.arange(round(duration_s * rate_hz)) / rate_hz
    pulsed = (instants % 4.0 < 0.1) & (instants >= 8.0) & (instants < 64.0)
    return instants, np.where(pulsed, 0.5 * np.sin(2.0 * np.pi * 10.0 * (instants % 4.0)), 0.0)


def bare_steps(leg: Leg, foot: Foot, step_s: float, steps: int) -> None:
    """PyBullet with the same dummy in it, stepped ``steps`` times (-) of ``step_s`` (s) and nothing else."""
    with forward_simulation._built(leg, foot, JOINT, step_s) as dummy:
        step, client = pybullet.stepSimulation, dummy.client
        for _ in range(steps):
            step(client)


def main() -> None:
    """Print times (ms), the ratio of the trial's length to them, and theirs to that of bare steps."""
    config = yaml.safe_load((ROOT / "config" / "config.yaml").read_text(encoding="utf-8"))
    config = settings_of(config)["dummy"]
    geometry = config["geometry"]
    leg = Leg(
        mass_kg=geometry["leg_mass_kg"],
        com_m=geometry["leg_com_m"],
        inertia_kgm2=geometry["leg_inertia_kgm2"],
        gravity_m_per_s2=geometry["gravity_m_per_s2"],
    )
    foot = Foot(geometry["foot_mass_kg"], geometry["foot_height_m"])
    given = len(sys.argv) > 1
    instants, velocity = recorded(Path(sys.argv[1]), config["analysis"]) if given else made_up()
    lasts_s = instants[-1] - instants[0]
    name = Path(sys.argv[1]).name if given else "made up"
    print(f"{name}: {lasts_s:.0f} s of trial, median of {REPETITIONS} repetitions\n")
    print(f"{'step (ms)':>9}{'simulated (ms)':>16}{'times real time':>17}{'times bare steps':>18}")
    for step_s in STEPS_S:
        steps = round(lasts_s / step_s) + 1
        whole, bare = np.empty((2, REPETITIONS))
        for k in range(REPETITIONS):  # in turns: what slows the computer down slows both
            start = time.perf_counter()
            simulate_dummy(instants, velocity, leg, foot, JOINT, step_s)
            between = time.perf_counter()
            bare_steps(leg, foot, step_s, steps)
            whole[k], bare[k] = between - start, time.perf_counter() - between
        print(
            f"{1e3 * step_s:>9g}{1e3 * np.median(whole):>16.0f}{lasts_s / np.median(whole):>17.0f}"
            f"{np.median(whole / bare):>18.2f}"
        )


if __name__ == "__main__":
    main()
