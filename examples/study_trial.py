"""A trial of the study, from its HDF5 file to I, B, K: thesis equation, consistent equation, output error.

snakemake -c2 results/trials/dummy/sine-0.3.h5
python examples/study_trial.py [TRIAL]
"""

import sys

import numpy as np

from tepsipe import (
    Leg,
    SegmentMarkers,
    find_perturbations,
    fit_impedance,
    fit_output_error,
    joint_torque,
    read_trial,
    segment_motion,
)

trial = read_trial(sys.argv[1] if len(sys.argv) > 1 else "results/trials/dummy/sine-0.3.h5")
labels = trial.axes["marker"].tolist()
leg = Leg(mass_kg=0.4, com_m=0.4485, inertia_kgm2=0.027)  # thesis Table 2-2
markers = SegmentMarkers(
    ("ankle", "leg1", "leg2", "leg3", "leg4"),
    np.array([[0.0, 0.0], [-0.012, 0.6], [0.012, 0.5], [-0.012, 0.4], [0.012, 0.3]]),
)

motion = segment_motion(trial.time, trial.signals["marker_position"], markers, leg.com_m, labels=labels)
perturbations = find_perturbations(trial.time, trial.signals["belt_velocity"])

for thesis in (True, False):
    torque = joint_torque(motion, leg, thesis=thesis)
    # the motion is filtered, and so is the torque that follows from it
    fit = fit_impedance(
        trial.time, motion.theta, torque, perturbations=perturbations, cutoff_hz=None, thesis=thesis
    )
    print("as the thesis prints it:" if thesis else "derived consistently:")
    print(fit.summary(), "\n")

belt_fixed = [labels.index(label) for label in ("foot1", "foot2", "foot3", "ankle")]
foot_position = trial.values("marker_position")[:, belt_fixed, 1].mean(axis=1)
fit = fit_output_error(
    motion, foot_position, trial.signals["belt_velocity"], leg, perturbations=perturbations
)
print("without any torque:")
print(fit.summary())
fit.plot().savefig("study_trial.png")
