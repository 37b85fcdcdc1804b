# %% [markdown]
# # Why the VAF cannot tell a right torque from a wrong one
#
# The *variance accounted for* (VAF) is the usual measure of fit in system
# identification:
#
# $$\mathrm{VAF} = \left(1 - \frac{\sum (\tau - \hat\tau)^2}{\sum \tau^2}\right) \cdot 100\ \%.$$
#
# A VAF near 100 % means that *I*, *B* and *K* predict the torque they were fitted to.
# It does not mean that this torque is the torque of the joint. In this tutorial, a
# wrong sign in the equation of motion more than triples *I* and removes a third of *K*,
# and the VAF rises.
#
# ## One recording, two equations
#
# The simulated leg has five markers. Inverse dynamics computes the ankle torque from
# their motion and the mass of the leg:
#
# $$\tau = -\left[m\,\ddot y\,r\cos\theta + I_l\,\ddot\theta - m\,(g + \ddot z)\,r\sin\theta\right].$$
#
# If one term counts the angle as positive in one direction and the other terms count it
# as positive in the opposite direction, the signs of two terms are reversed.
# `joint_torque(..., thesis=True)` uses such an equation. It is the equation printed in
# the thesis that this project reproduces, applied to an angle of the opposite sign
# ([decision 3](../decisions/0003-torque-pathways.md)).

# %%
from tepsipe import fit_impedance, joint_torque, load_example, segment_motion

recording = load_example("dummy")
motion = segment_motion(
    recording.time,
    recording.positions,
    recording.markers,
    recording.leg.com_m,
    labels=recording.labels,
)

fits = {}
for name, mixed in (("consistent", False), ("mixed signs", True)):
    torque = joint_torque(motion, recording.leg, thesis=mixed)
    # the markers are filtered already, and so is the torque computed from them
    fits[name] = fit_impedance(
        recording.time,
        motion.theta,
        torque,
        perturbations=recording.perturbations,
        cutoff_hz=None,
    )

print(f"{'':12} {'I':>8} {'B':>8} {'K':>8} {'VAF (%)':>9}")
for name, fit in fits.items():
    print(f"{name:12} {fit.I:8.4f} {fit.B:8.4f} {fit.K:8.3f} {fit.vaf:9.2f}")
truth = recording.truth
print(f"{'truth':12} {truth['I']:8.4f} {truth['B']:8.4f} {truth['K']:8.3f}")

# %% [markdown]
# The equation with mixed signs has the higher VAF, but neither its *I* nor its *K* is
# close to the true value.
#
# ## Why
#
# For small angles the two torques differ by
#
# $$\tau_\mathrm{mixed} - \tau = 2 I_\mathrm{leg}\,\ddot\theta - 2 m g r\,\theta .$$
#
# Both $\ddot\theta$ and $\theta$ are regressors of the fit. The error is therefore a
# linear combination of regressors. *I* absorbs the first term, *K* absorbs the second,
# and nothing remains in the residual. The size of the error depends only on the leg.

# %%
leg = recording.leg
added_inertia = 2 * leg.inertia_kgm2
lost_stiffness = 2 * leg.mass_kg * leg.gravity_m_per_s2 * leg.com_m
consistent, mixed = fits["consistent"], fits["mixed signs"]
print(
    f"I: predicted change {added_inertia:+.4f}, found {mixed.I - consistent.I:+.4f} N·m·s²/rad"
)
print(
    f"K: predicted change {-lost_stiffness:+.3f}, found {mixed.K - consistent.K:+.3f} N·m/rad"
)

# %%
import matplotlib.pyplot as plt

figure, axes = plt.subplots(1, 2, figsize=(9, 3.2), layout="constrained")
window = recording.perturbations[0]
span = slice(window.start - 20, window.stop + 20)
for ax, (name, fit) in zip(axes, fits.items(), strict=True):
    ax.plot(
        fit.curve.x[span],
        fit.curve.measured[span],
        color="0.5",
        linewidth=3,
        label="inverse dynamics",
    )
    ax.plot(
        fit.curve.x[span],
        fit.curve.predicted[span],
        color="C1",
        linewidth=1,
        label="I, B, K",
    )
    ax.set(title=f"{name}: VAF {fit.vaf:.2f} %, K = {fit.K:.2f}", xlabel="time (s)")
axes[0].set_ylabel("torque (N·m)")
axes[0].legend()
plt.show()

# %% [markdown]
# Both panels show a nearly perfect fit. Only one torque is right.
#
# The VAF rises because the extra inertia makes the torque itself larger, while the
# noise stays the same.
#
# ## What reveals the error
#
# A test reveals the error if it does not use the same torque both for the fit and for
# its evaluation. This project includes three such tests.
#
# **Simulate the leg.** The parameters must reproduce the motion, not only the torque.
# `simulate_joint` simulates a leg that is driven only by the belt.

# %%
from tepsipe import simulate_joint, vaf

errors = {}
for name, fit in fits.items():
    moved = simulate_joint(
        recording.time,
        recording.belt_velocity,
        leg,
        I=fit.I,
        B=fit.B,
        K=fit.K,
        engine="equations",
    )
    # relative to rest, where the leg leans a little
    rest = slice(0, recording.perturbations[0].start)
    simulated = moved.theta - moved.theta[rest].mean()
    measured = motion.theta - motion.theta[rest].mean()
    errors[name] = simulated - measured
    print(f"{name:12} VAF of the simulated angle: {vaf(measured, simulated):10.2f} %")

# %% [markdown]
# The parameters of the consistent equation predict most of the movement over the whole
# minute. The parameters of the equation with mixed signs do not, although they fitted
# their own torque almost perfectly.
#
# **Estimate without a torque.** `fit_joint_likelihood` and `fit_output_error` fit the
# motion itself.
#
# **Use a known joint.** If a spring of known stiffness replaces the joint, every error
# of the equation becomes visible. The ankle dummy of the thesis was built for this
# purpose.
#
# ## What can go wrong
#
# - A high VAF after averaging or filtering is even weaker evidence, because both remove
#   the noise and leave the error.
# - An error that is *not* a linear combination of $\theta$, $\dot\theta$ and
#   $\ddot\theta$, such as a delay or friction, does lower the VAF. A low VAF is a
#   warning, but a high VAF is no proof.
# - A belt-induced force in proportion to the acceleration of the belt does not lower
#   the VAF ([which filter](../planning.md#which-filter)).
#
# ## Exercises
#
# 1. Give the leg a wrong mass, `Leg(mass_kg=0.5, com_m=..., inertia_kgm2=...)`. Predict
#    the change of *I* and *K* before you compute it. Does the VAF change?
# 2. Delay the torque by two samples (`np.roll`). Which of *I*, *B* and *K* changes
#    most, and what happens to the VAF?
# 3. Find a smooth error of the torque that lowers the VAF to 90 % and leaves *K*
#    unchanged.
#
# Next: [plan an experiment](plan.md).
