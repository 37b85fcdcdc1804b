"""From your own arrays to I, B, K with intervals and a plot.

python examples/own_arrays.py [TABLE]

TABLE is comma-separated, with a header and the columns time (s), angle (rad), torque (Nm) and belt velocity
(m/s). Without it, a simulated dummy is estimated, whose truth is I = 0.02, B = 0.15, K = 10.
"""

import sys

import numpy as np

from tepsipe import find_perturbations, fit_impedance, load_example

if len(sys.argv) > 1:
    time, angle, torque, belt_velocity = np.loadtxt(sys.argv[1], delimiter=",", skiprows=1).T
else:
    example = load_example("dummy")
    time, angle, torque = example.time, example.angle, example.torque
    belt_velocity = example.belt_velocity

perturbations = find_perturbations(time, belt_velocity, until="rest", angle=angle)  # a passive joint
fit = fit_impedance(time, angle, torque, perturbations=perturbations)

print(fit.summary())
print(f"K = {fit.K:.2f} N·m/rad, 95 % interval {fit.intervals['K'][0]:.2f} to {fit.intervals['K'][1]:.2f}")
fit.to_frame().to_csv("own_arrays.csv")
fit.plot().savefig("own_arrays.png")
