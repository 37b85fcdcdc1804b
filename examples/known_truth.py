"""Estimates of simulated joints beside their truth: markers of a leg on a belt, and a manipulator.

python examples/known_truth.py
"""

from tepsipe import fit_admittance, fit_joint_likelihood, frequency_response, load_example

dummy = load_example("dummy")
print(dummy.description)
likelihood = fit_joint_likelihood(
    dummy.time,
    dummy.positions,
    dummy.markers,
    dummy.leg,
    labels=dummy.labels,
    belt_fixed=dummy.belt_fixed,
    perturbations=dummy.perturbations,
    belt_velocity=dummy.belt_velocity,
)
print(likelihood.summary())
print(f"truth: {dict(dummy.truth)}\n")

manipulator = load_example("manipulator")
print(manipulator.description)
response = frequency_response(
    manipulator.time,
    manipulator.torque,
    manipulator.angle,
    period_s=manipulator.period_s,
    band_hz=(1.0, 20.0),
)
admittance = fit_admittance(response)
print(admittance.summary())
print(f"truth: {dict(manipulator.truth)}")
admittance.plot().savefig("known_truth.png")
