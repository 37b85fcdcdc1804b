# %% [markdown]
# # From a recording to I, B and K
#
# This tutorial takes about ten minutes. It starts with the angle and the torque of a
# joint and ends with its inertia *I*, damping *B* and stiffness *K*, each with a 95 %
# interval. The recording is simulated, so the true values are known and you can see
# whether the intervals contain them.
#
# ## A recording
#
# `load_example` returns a recording that is installed with the library. A leg stands on
# an elastic ankle, and a treadmill belt under the foot makes 14 short pulses.

# %%
from tepsipe import find_perturbations, fit_impedance, load_example

recording = load_example("dummy")
print(recording.description)
print(
    f"{recording.time.size} samples at {1 / recording.time[1]:.0f} Hz, {recording.time[-1]:.0f} s"
)

# %% [markdown]
# Your own recording needs the same three arrays on one regular clock, and the belt
# velocity to find the pulses:
#
# | Array | Unit | Sign |
# |---|---|---|
# | `time` | s | increasing |
# | `angle` | rad | your choice |
# | `torque` | N·m | positive when the torque resists a positive angle |
# | `belt_velocity` | m/s | any |
#
# The first seconds and two pulses look like this.

# %%
import matplotlib.pyplot as plt

figure, axes = plt.subplots(3, 1, figsize=(7, 5), sharex=True, layout="constrained")
shown = recording.time < 9.0
for ax, signal, label in zip(
    axes,
    (recording.belt_velocity, recording.angle, recording.torque),
    ("belt velocity (m/s)", "angle (rad)", "torque (N·m)"),
    strict=True,
):
    ax.plot(recording.time[shown], signal[shown], linewidth=1)
    ax.set_ylabel(label)
axes[-1].set_xlabel("time (s)")
plt.show()

# %% [markdown]
# ## The perturbations
#
# `find_perturbations` returns one window per pulse, from the belt velocity. Each window
# starts when the belt starts to move and ends when it is at rest again.

# %%
perturbations = find_perturbations(recording.time, recording.belt_velocity)
print(len(perturbations), "perturbations, the first at", perturbations[0])

# %% [markdown]
# ## The fit
#
# In every window, the joint is described by
#
# $$\tau = I\,\ddot\theta + B\,\dot\theta + K\,(\theta - \theta_\mathrm{rest}).$$
#
# `fit_impedance` filters angle and torque alike, estimates the three parameters in each
# window, and averages over the windows. The scatter over the windows gives the
# intervals.

# %%
fit = fit_impedance(
    recording.time, recording.angle, recording.torque, perturbations=perturbations
)
print(fit.summary())

# %% [markdown]
# The recording was simulated with known values. All three intervals should contain
# them.

# %%
for name, true in recording.truth.items():
    low, high = fit.intervals[name]
    verdict = "inside" if low < true < high else "outside"
    print(f"{name}: {low:.4f} to {high:.4f}, true value {true:g}: {verdict}")

# %%
fit.plot()

# %% [markdown]
# The figure shows the measured torque and the torque that *I*, *B* and *K* predict. The
# fitted windows are shaded.
#
# ## Keep the result
#
# `fit.to_frame()` is a pandas table, one row per quantity.

# %%
table = fit.to_frame()
table.to_csv("impedance.csv")
table

# %% [markdown]
# ## What the interval includes
#
# The last line of the summary says that these intervals contain the scatter within the
# record only (*Type A*). A torque sensor with a gain error of 1 % changes *I*, *B* and
# *K* by 1 % in every window, so no scatter reveals it. State what you know about your
# instruments, and the intervals include it (*Type B*).

# %%
wider = fit_impedance(
    recording.time,
    recording.angle,
    recording.torque,
    perturbations=perturbations,
    uncertainty={"torque_scale": 0.01, "torque_delay_s": 0.0005},
)
print("Type A:           ", fit.quantities["K"])
print("Type A and Type B:", wider.quantities["K"])

# %% [markdown]
# ## What can go wrong
#
# **Exchanged arguments.** The fit runs, and the result has notes that say what is
# wrong. A valid record has no notes.

# %%
exchanged = fit_impedance(
    recording.time,
    recording.torque,
    recording.angle,
    perturbations=perturbations,
    cutoff_hz=20.0,
)
for note in exchanged.notes:
    print("-", note)

# %% [markdown]
# **Degrees instead of radians.** Name the unit with `Signal`, and the library converts
# it. Without the unit, *K* would be too small by a factor of 57.

# %%
import numpy as np

from tepsipe import Signal

degrees = Signal(np.rad2deg(recording.angle), "deg")
print(
    fit_impedance(
        recording.time, degrees, recording.torque, perturbations=perturbations
    ).quantities["K"]
)

# %% [markdown]
# **Gaps.** Input that cannot be used is refused with one sentence.

# %%
from tepsipe import InputError

broken = recording.angle.copy()
broken[1000:1005] = np.nan
try:
    fit_impedance(recording.time, broken, recording.torque, perturbations=perturbations)
except InputError as refused:
    print(refused)

# %% [markdown]
# [All notes and refusals](../when-it-stops.md#a-result-has-notes) are listed with their
# causes.
#
# ## Exercises
#
# 1. Use only the first three perturbations (`perturbations[:3]`). By what factor does
#    the interval of *K* grow, and why by more than $\sqrt{14/3}$?
# 2. Filter at 5 Hz (`cutoff_hz=5`). Read the note, then compare the estimates with the
#    truth.
# 3. Reverse the sign of the torque. Which sentence tells you?
# 4. Estimate the same joint from the camera markers alone with `fit_joint_likelihood`
#    ([example](../api.md#tepsipe.fit_joint_likelihood)). Its interval of *K* is far
#    narrower. Which information does it use that the windows do not?
#
# Next: [why the VAF cannot tell a right torque from a wrong one](vaf.md).
