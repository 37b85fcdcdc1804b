"""A human joint under random movement: frequency response, coherence, parallel cascade.

    python examples/human_joint.py [TABLE TIME ANGLE TORQUE]

TABLE is comma-separated and has a header; the other arguments name its columns (s, rad, Nm, a torque that
resists a positive angle being positive). Without arguments, a simulated ankle is estimated, whose intrinsic
stiffness is 80 N·m/rad and whose stretch reflex has a gain of 5 N·m·s/rad and a delay of 40 ms.
"""

import sys

import numpy as np

from tepsipe import fit_parallel_cascade, frequency_response, load_example

if len(sys.argv) > 1:
    with open(sys.argv[1], encoding="utf-8") as file:
        names = file.readline().strip().split(",")
    columns = [names.index(name) for name in sys.argv[2:5]]
    time, angle, torque = np.loadtxt(sys.argv[1], delimiter=",", skiprows=1, usecols=columns).T
else:
    example = load_example("ankle")
    time, angle, torque = example.time, example.angle, example.torque

impedance = frequency_response(time, angle, torque, band_hz=(0.2, 20.0))  # torque over angle
print(impedance.to_frame().iloc[::10].to_string(index=False))
print(f"unrelated signals stay below a coherence of {impedance.coherence_threshold():.2f} in 95 % of cases")
impedance.plot().savefig("human_joint_response.png")

fit = fit_parallel_cascade(time, angle, torque, bootstrap_draws=300)
print(fit.summary())
fit.plot().savefig("human_joint_torque.png")
