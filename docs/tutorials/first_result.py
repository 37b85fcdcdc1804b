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
# Your own recording needs the same three arrays (time, angle and torque), sampled at
# the same regular times. The belt velocity is needed only to find the pulses. The units
# and signs are:
#
# | Array | Unit | Sign |
# |---|---|---|
# | `time` | s | increasing |
# | `angle` | rad | your choice |
# | `torque` | N·m | positive when the torque resists a positive angle |
# | `belt_velocity` | m/s | any |
#
# The next figure shows the first nine seconds, with two pulses.

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
# `find_perturbations` finds the pulses in the belt velocity and returns one window per
# pulse. Each window starts when the belt starts to move. With `until="rest"`, it ends when
# the joint is at rest again; otherwise it ends when the belt stops.
#
# Use `until="rest"` for a passive joint like this one, because its free decay after the
# pulse narrows the interval of *K*. Do not use it for a joint with reflexes or voluntary
# torque, or for one that softens, because these act on the decay as well.

# %%
perturbations = find_perturbations(
    recording.time, recording.belt_velocity, until="rest", angle=recording.angle
)
print(len(perturbations), "perturbations, the first at", perturbations[0])

# %% [markdown]
# ## The fit
#
# In every window, the joint is described by
#
# $$\tau = I\,\ddot\theta + B\,\dot\theta + K\,(\theta - \theta_\mathrm{rest}).$$
#
# `fit_impedance` filters angle and torque with the same filter, estimates the three
# parameters in each window, and averages over the windows. The intervals are computed
# from the scatter over the windows.

# %%
fit = fit_impedance(
    recording.time, recording.angle, recording.torque, perturbations=perturbations
)
print(fit.summary())

# %% [markdown]
# The recording was simulated, so the true values are known. All three intervals should
# contain them.

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
# ## Save the result
#
# `fit.to_frame()` returns a pandas table with one row per quantity.

# %%
table = fit.to_frame()
table.to_csv("impedance.csv")
table

# %% [markdown]
# ## What the interval includes
#
# The last line of the summary states that these intervals include only the scatter
# within the record (*Type A*). A gain error of 1 % in the torque sensor changes *I*,
# *B* and *K* by 1 % in every window, so the scatter does not reveal it. If you state
# the uncertainty of your instruments, the intervals include it as well (*Type B*).

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
# **Exchanged arguments.** The fit runs, but notes on the result describe what is wrong.
# The result above has no notes.

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
# **Degrees instead of radians.** If you name the unit with `Signal`, the library
# converts the values. Without the unit, *K* would be too small by a factor of 57.

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
# **Gaps.** Input that cannot be used raises an `InputError` with a one-sentence
# message.

# %%
from tepsipe import InputError

broken = recording.angle.copy()
broken[1000:1005] = np.nan
try:
    fit_impedance(recording.time, broken, recording.torque, perturbations=perturbations)
except InputError as refused:
    print(refused)

# %% [markdown]
# A [separate page](../when-it-stops.md#a-result-has-notes) lists all notes and error
# messages with their causes.
#
# ## Exercises
#
# 1. Let the windows end when the belt stops (`recording.perturbations`). By what factor
#    does the interval of *K* grow, and why do those of *I* and *B* hardly change?
# 2. Use only the first three perturbations (`perturbations[:3]`). By what factor does
#    the interval of *K* grow, and why is this factor larger than $\sqrt{14/3}$?
# 3. Filter at 5 Hz (`cutoff_hz=5`). Read the note, then compare the estimates with the
#    truth.
# 4. Reverse the sign of the torque. Which message reveals the error?
# 5. Estimate the same joint without a torque, from the camera markers and the belt, with
#    `fit_joint_likelihood` ([example](../api.md#tepsipe.fit_joint_likelihood)). Its interval of *K* is far
#    narrower. Which information does it use that the windowed fit ignores?
#
# Next: [why the VAF cannot tell a right torque from a wrong one](vaf.md).
