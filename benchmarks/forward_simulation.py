# ruff: noqa: E402
"""Time and error of every engine that is installed, on a trial of the ankle dummy, in one run.

    python benchmarks/forward_simulation.py [TRIAL]

TRIAL is a trial's HDF5 file, for example results/trials/dummy/sine-0.5.h5; without it a belt is made up.
"""

import os

for library in ("OMP", "OPENBLAS", "MKL"):
    os.environ[f"{library}_NUM_THREADS"] = "1"

import math
import sys
import time
from pathlib import Path

import numpy as np
import yaml
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicSpline

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))

from tepsipe.io.trial import read_trial
from tepsipe.mechanics.engines import engine_version, installed_engines
from tepsipe.mechanics.forward_dynamics import ForwardSimulation, Joint, simulate_dummy
from tepsipe.mechanics.inverse_dynamics import Foot, Leg
from tepsipe.signals.filters import butterworth_lowpass
from workflow.settings.complete import settings_of

JOINT = Joint(inertia_Nms2_per_rad=0.0, damping_Nms_per_rad=0.1, stiffness_Nm_per_rad=10.0)
STEPS_S = (0.001, 0.002, 0.004)
REPETITIONS = 5
REACTIONS = ("f_y", "f_z", "m_x", "f_ay", "f_az")


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


def exact(instants: np.ndarray, velocity: np.ndarray, leg: Leg, foot: Foot) -> dict[str, np.ndarray]:
    """Angle (rad) and reactions (N, Nm) by DOP853 along the same spline, tolerances 1e-10 and 1e-13."""
    m, r, g, k = leg.mass_kg, leg.com_m, leg.gravity_m_per_s2, JOINT.stiffness_Nm_per_rad
    b, about_ankle = JOINT.damping_Nms_per_rad, leg.inertia_kgm2 + leg.mass_kg * leg.com_m**2
    elapsed = instants - instants[0]
    belt = CubicSpline(elapsed, velocity)
    pieces, last = belt.derivative().c.T.tolist(), elapsed.size - 2
    interval = elapsed[-1] / (elapsed.size - 1)

    def derivative(t: float, x: np.ndarray) -> tuple[float, float]:
        piece = min(int(t / interval), last)
        since, (c2, c1, c0) = t - piece * interval, pieces[piece]
        y_dd = (c2 * since + c1) * since + c0
        torque = b * x[1] + k * x[0]
        return x[1], (m * r * (g * math.sin(x[0]) - y_dd * math.cos(x[0])) - torque) / about_ankle

    with np.errstate(invalid="ignore"):  # a belt that starts at rest has no error to divide by
        theta, theta_d = solve_ivp(
            derivative,
            (0.0, elapsed[-1]),
            (0.0, 0.0),
            method="DOP853",
            t_eval=elapsed,
            rtol=1e-10,
            atol=1e-13,
            max_step=interval,  # no step over a knot of the spline
        ).y
    y_f, y_f_dd, s, c = belt.antiderivative()(elapsed), belt(elapsed, 1), np.sin(theta), np.cos(theta)
    tau = b * theta_d + k * theta
    theta_dd = (m * r * (g * s - y_f_dd * c) - tau) / about_ankle
    f_ay = -m * (y_f_dd + r * (c * theta_dd - s * theta_d**2))
    f_az = -m * (g - r * (s * theta_dd + c * theta_d**2))
    f_y, f_z = foot.mass_kg * y_f_dd - f_ay, foot.mass_kg * g - f_az
    m_x = tau + y_f * f_z - foot.height_m * (f_y - 0.5 * foot.mass_kg * y_f_dd)
    return {"theta": theta, "f_y": f_y, "f_z": f_z, "m_x": m_x, "f_ay": f_ay, "f_az": f_az}


def errors(simulated: ForwardSimulation, true: dict[str, np.ndarray]) -> tuple[float, float]:
    """Largest error of the angle (rad), and of a reaction as a part of the range of its values."""
    off = {name: np.abs(getattr(simulated, name) - values).max() for name, values in true.items()}
    return off["theta"], max(off[name] / np.ptp(true[name]) for name in REACTIONS)


def main() -> None:
    """Print CPU time (ms per simulated second), ratio of the trial's length to it, and errors (rad, -)."""
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
    true = exact(instants, velocity, leg, foot)
    cells = [(engine, step_s) for engine in installed_engines() for step_s in STEPS_S]
    times: dict[tuple[str, float], list[float]] = {cell: [] for cell in cells}
    off = {}
    for engine, step_s in cells:  # the first is not timed: it loads the engine
        off[engine, step_s] = errors(
            simulate_dummy(instants, velocity, leg, foot, JOINT, step_s, engine), true
        )
    for _ in range(REPETITIONS):
        for engine, step_s in cells:  # in turns: what slows the computer down slows all of them
            start = time.process_time()
            simulate_dummy(instants, velocity, leg, foot, JOINT, step_s, engine)
            times[engine, step_s].append(time.process_time() - start)
    print(
        f"{name}: {lasts_s:.0f} s of trial, {np.ptp(true['theta']):.3f} rad from peak to peak; "
        f"CPU time is the median of {REPETITIONS} repetitions, errors are those against DOP853\n"
    )
    print(
        f"{'engine':<18}{'step (ms)':>9}{'CPU (ms/s)':>12}{'times real time':>17}{'angle (rad)':>13}"
        f"{'reactions (-)':>15}"
    )
    for (engine, step_s), spent in times.items():
        cpu = float(np.median(spent))
        angle, reactions = off[engine, step_s]
        print(
            f"{engine + ' ' + engine_version(engine):<18}{1e3 * step_s:>9g}{1e3 * cpu / lasts_s:>12.2f}"
            f"{lasts_s / cpu:>17.0f}{angle:>13.1e}{reactions:>15.1e}"
        )


if __name__ == "__main__":
    main()
