"""From your own arrays to I, B, K with intervals and a plot.

python examples/own_arrays.py [TABLE]
"""

import sys
from pathlib import Path

import numpy as np

from tepsipe import find_perturbations, fit_impedance

table = sys.argv[1] if len(sys.argv) > 1 else Path(__file__).parent / "data" / "perturbed_joint.csv"
time, angle, torque, belt_velocity = np.loadtxt(table, delimiter=",", skiprows=1).T  # s, rad, Nm, m/s

perturbations = find_perturbations(time, belt_velocity)
fit = fit_impedance(time, angle, torque, perturbations=perturbations)

print(fit.summary())
print(f"K = {fit.K:.2f} N·m/rad, 95 % interval {fit.intervals['K'][0]:.2f} to {fit.intervals['K'][1]:.2f}")
fit.to_frame().to_csv("own_arrays.csv")
fit.plot().savefig("own_arrays.png")
