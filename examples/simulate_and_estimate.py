"""Simulate a joint of known impedance on a perturbed belt, add noise, and estimate it again.

python examples/simulate_and_estimate.py
"""

import numpy as np

from tepsipe import Leg, find_perturbations, fit_impedance, simulate_joint

leg = Leg(mass_kg=0.4, com_m=0.4485, inertia_kgm2=0.027)
time = np.arange(0.0, 64.0, 1.0 / 250.0)
belt_velocity = np.zeros_like(time)
for onset_s in np.arange(3.0, 57.0, 4.0):  # 100 ms jerks of 0.3 m/s: one period of a sine
    pulse = (time >= onset_s) & (time < onset_s + 0.1)
    belt_velocity[pulse] = 0.3 * np.sin(2.0 * np.pi * 10.0 * (time[pulse] - onset_s))

simulated = simulate_joint(time, belt_velocity, leg, I=0.002, B=0.1, K=10.0)
perturbations = find_perturbations(time, belt_velocity)

rng = np.random.default_rng(20140612)
for noise in (0.0, 0.01, 0.1):
    angle = simulated.theta + noise * simulated.theta.std() * rng.standard_normal(time.size)
    torque = simulated.torque + noise * simulated.torque.std() * rng.standard_normal(time.size)
    fit = fit_impedance(time, angle, torque, perturbations=perturbations)
    print(f"noise of {100.0 * noise:g} % of the signals, truth I = 0.002, B = 0.1, K = 10:")
    print(fit.summary(), "\n")
fit.plot().savefig("simulate_and_estimate.png")
