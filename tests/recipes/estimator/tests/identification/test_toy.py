"""The toy gives a known joint back, and its intervals cover it."""

import numpy as np
from builders import LEG, RATE_HZ, Joint, swing
from scipy.stats import t

from tepsipe.identification.estimators import NEEDS_TORQUE, Record, estimate
from tepsipe.mechanics.inverse_dynamics import leg_pathway_torque
from tepsipe.signals.perturbations import WindowOptions, filtered_perturbations

WINDOW = WindowOptions(
    rest_before_s=2.0,
    rest_after_s=1.0,
    rest_margin_s=0.1,
    threshold_fraction=0.05,
    signal_to_noise=5.0,
    merge_s=0.06,
)


def test_intervals_cover_the_joint(rng):
    joint = Joint(rest=0.005)
    moved = swing(joint)
    torque = leg_pathway_torque("leg", LEG, moved.motion)
    torque += rng.normal(0.0, 0.01, torque.size)
    found = filtered_perturbations(moved.belt_velocity, RATE_HZ, WINDOW, "belt")
    record = {"motion": moved.motion, "torque": torque, "perturbations": found}
    assert {*record, "at_rest"} == set(NEEDS_TORQUE)
    fit = estimate("toy", Record(**record, at_rest=moved.motion.time < 1.9))
    u, freedom = fit.type_a
    truth = np.array([joint.inertia, joint.damping, joint.stiffness])
    assert (np.abs(fit.mean - truth) < t.ppf(0.975, freedom) * u).all()
