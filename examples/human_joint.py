"""A human joint under random movement: frequency response, coherence, parallel cascade.

    python examples/human_joint.py [TABLE TIME ANGLE TORQUE]

TABLE is comma-separated and has a header; the other arguments name its columns (s, rad, Nm, a torque that
resists a positive angle being positive). Without arguments a joint is simulated whose intrinsic stiffness is
80 N·m/rad and whose stretch reflex has a gain of 5 N·m·s/rad and a delay of 40 ms.
"""

import sys

import numpy as np

from tepsipe import fit_parallel_cascade, frequency_response, lowpass


def simulated_joint(rate_hz=250.0, duration_s=60.0, seed=1):
    """Time (s), angle (rad) and torque (Nm) of a joint with I = 0.015, B = 1, K = 80 and a stretch reflex."""
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, duration_s, 1.0 / rate_hz)
    angle = lowpass(rng.standard_normal(time.size), rate_hz, cutoff_hz=4.0)
    angle *= 0.02 / angle.std()
    rate = np.gradient(angle, time)
    torque = 0.015 * np.gradient(rate, time) + 1.0 * rate + 80.0 * angle
    late = np.interp(time - 0.04, time, np.maximum(rate, 0.0))  # stretch, 40 ms before
    kernel = np.exp(-0.5 * ((np.arange(0.0, 0.3, 1.0 / rate_hz) - 0.1) / 0.03) ** 2)
    torque += 5.0 * np.convolve(late, kernel / kernel.sum())[: time.size]
    return time, angle, torque + 0.1 * rng.standard_normal(time.size)


if len(sys.argv) > 1:
    names = np.genfromtxt(sys.argv[1], delimiter=",", names=True, max_rows=1).dtype.names
    columns = [names.index(name) for name in sys.argv[2:5]]
    time, angle, torque = np.loadtxt(sys.argv[1], delimiter=",", skiprows=1, usecols=columns).T
else:
    time, angle, torque = simulated_joint()

impedance = frequency_response(time, angle, torque, band_hz=(0.2, 20.0))  # torque over angle
print(impedance.to_frame().iloc[::10].to_string(index=False))
print(f"unrelated signals stay below a coherence of {impedance.coherence_threshold():.2f} in 95 % of cases")
impedance.plot().savefig("human_joint_response.png")

fit = fit_parallel_cascade(time, angle, torque, bootstrap_draws=300)
print(fit.summary())
fit.plot().savefig("human_joint_torque.png")
