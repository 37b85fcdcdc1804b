# %% [markdown]
# # A human ankle under random movement
#
# A motor rotates a person's foot at random, while the angle and the torque are
# measured. The torque has two sources. Passive and active tissue resists at once
# (*intrinsic* impedance, described by *I*, *B* and *K*). The stretch reflex responds
# about 40 ms later. This tutorial separates the two. The ankle is simulated, so the
# true values are known.

# %%
import matplotlib.pyplot as plt

from tepsipe import (
    fit_impedance,
    fit_parallel_cascade,
    frequency_response,
    load_example,
)

ankle = load_example("ankle")
print(ankle.description)
print("true values:", dict(ankle.truth))

figure, axes = plt.subplots(2, 1, figsize=(7, 3.6), sharex=True, layout="constrained")
shown = (ankle.time > 10.0) & (ankle.time < 14.0)
axes[0].plot(ankle.time[shown], ankle.angle[shown], linewidth=1)
axes[1].plot(ankle.time[shown], ankle.torque[shown], linewidth=1)
axes[0].set_ylabel("angle (rad)")
axes[1].set(ylabel="torque (N·m)", xlabel="time (s)")
plt.show()

# %% [markdown]
# ## A first look: the frequency response
#
# For a joint without reflexes, the ratio of torque to angle is
# $K + i\omega B - \omega^2 I$. It is flat at low frequencies and rises with the inertia
# at high frequencies. The *coherence* is the share of the torque's power that is
# linearly related to the angle.

# %%
response = frequency_response(
    ankle.time, ankle.angle, ankle.torque, band_hz=(0.5, 20.0)
)
response.plot()
print(f"lowest coherence: {response.coherence.min():.2f}")

# %% [markdown]
# The coherence is low although the recording has hardly any noise. The joint must
# therefore contain a nonlinear element.
#
# ## The wrong model
#
# `fit_impedance` without perturbations fits *I*, *B* and *K* to the whole record.

# %%
linear = fit_impedance(ankle.time, ankle.angle, ankle.torque)
for name in ("I", "B", "K"):
    print(f"{name} = {linear.quantities[name]}, true value {ankle.truth[name]:g}")
for note in linear.notes:
    print("Note:", note)

# %% [markdown]
# Here the VAF is useful. It is low, because the reflex torque is not a linear
# combination of angle, velocity and acceleration. [Another tutorial](vaf.md) shows a
# case in which the VAF is not useful.
#
# ## Two pathways
#
# `fit_parallel_cascade` adds a reflex pathway in parallel. It consists of a delay, a
# half-wave rectifier of the stretch velocity (only lengthening counts) and a muscle
# model. The best delay is found by a search. Short-range stiffness and further effects
# are included only if cross-validation supports them. We use 100 bootstrap draws here;
# the default of 1000 takes longer.

# %%
fit = fit_parallel_cascade(ankle.time, ankle.angle, ankle.torque, bootstrap_draws=100)
print(fit.summary())

# %%
for name, true in ankle.truth.items():
    quantity = fit.quantities[name]
    print(f"{name:13} {quantity.value:8.4g}, true value {true:g}")
fit.plot()

# %% [markdown]
# The model is fitted to the first half of the record. The second half is held out; the
# VAF in the summary measures how well its torque is predicted.
#
# ## How large is the reflex?

# %%
reflex = fit.details.reflex_torque
print(f"standard deviation of the torque:  {ankle.torque.std():.2f} N·m")
print(f"standard deviation of its reflex: {reflex.std():.2f} N·m")
for finding in (*fit.findings, *fit.notes):
    print("-", finding)

# %% [markdown]
# ## What can go wrong
#
# - **The delay is not determined.** If the movements are slow, a wide range of delays
#   fits equally well. The note above reports this and gives the range. In this case,
#   quote the gain, not the delay.
# - **The movement is too small or too slow.** Without sufficiently fast stretches there
#   is no reflex to find, and the interval of the gain contains 0.
# - **The person does not relax.** Voluntary torque is slow. It is fitted as *slow
#   torque* and does not count in the held-out VAF. If a person reacts to the movement,
#   however, the fit mistakes the reaction for a slow reflex.
# - **Angle and torque are recorded with different clocks.** A delay of 1 ms between
#   them changes *B* by *K* × 1 ms.
#
# For recordings in files, use the study instead. It adds Type B uncertainty, checks and
# a page per trial ([position-controlled
# manipulator](../recordings/position-manipulator.md)).
#
# ## Exercises
#
# 1. Reverse both signals. Which muscle's reflex do you find now, and what is the reflex
#    gain?
# 2. Use the first 20 s only. By how much does the interval of the reflex gain grow?
# 3. Halve `training_fraction`. Does the held-out VAF fall?
#
# Next: [a person on a treadmill](treadmill_person.md).
