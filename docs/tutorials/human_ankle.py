# %% [markdown]
# # A human ankle under random movement
#
# A motor rotates the foot of a person at random and measures angle and torque. The
# torque has two sources: the passive and active tissue that resists at once
# (*intrinsic* impedance: *I*, *B*, *K*), and the stretch reflex, which answers about 40
# ms later. This tutorial separates the two. The ankle is simulated, so the true values
# are known.

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
# For a joint without reflexes, torque over angle is $K + i\omega B - \omega^2 I$: flat
# at low frequencies, rising with the inertia at high ones. The *coherence* is the share
# of the torque's power that follows the angle linearly.

# %%
response = frequency_response(
    ankle.time, ankle.angle, ankle.torque, band_hz=(0.5, 20.0)
)
response.plot()
print(f"lowest coherence: {response.coherence.min():.2f}")

# %% [markdown]
# The coherence is low although the recording has hardly any noise. Something in this
# joint is not linear.
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
# Here the VAF is useful: it is low, because the reflex is no sum of angle, velocity and
# acceleration ([when it is not useful](vaf.md)).
#
# ## Two pathways
#
# `fit_parallel_cascade` adds a reflex pathway in parallel: delay, half-wave rectifier
# of the stretch velocity (only lengthening counts), and a muscle. The delay is
# searched, and short-range stiffness and further effects are included only where
# cross-validation finds them. We take 100 bootstrap draws here; the default of 1000
# takes longer.

# %%
fit = fit_parallel_cascade(ankle.time, ankle.angle, ankle.torque, bootstrap_draws=100)
print(fit.summary())

# %%
for name, true in ankle.truth.items():
    quantity = fit.quantities[name]
    print(f"{name:13} {quantity.value:8.4g}, true value {true:g}")
fit.plot()

# %% [markdown]
# The first half of the record is fitted. The second half is held out, and its torque is
# predicted with the VAF in the summary.
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
# - **The delay is not determined.** Slow movements let a wide range of delays fit
#   equally well. The note above says so and gives the range: quote the gain, not the
#   delay.
# - **The movement is too small or too slow.** Without stretches that are fast enough,
#   there is no reflex to find, and the gain has an interval that contains 0.
# - **The person does not relax.** Voluntary torque is slow. It is fitted as *slow
#   torque* and does not count in the held-out VAF, but a person who reacts to the
#   movement looks like a slow reflex.
# - **Angle and torque have different clocks.** A delay of 1 ms between them changes *B*
#   by *K* × 1 ms.
#
# For recordings in files, use the study instead: it adds Type B, checks and a page per
# trial ([position-controlled manipulator](../recordings/position-manipulator.md)).
#
# ## Exercises
#
# 1. Reverse both signals. Which muscle's reflex do you find now, and what does the
#    reflex gain say?
# 2. Use the first 20 s only. How does the interval of the reflex gain grow?
# 3. Halve `training_fraction`. Does the held-out VAF fall?
#
# Next: [a person on a treadmill](treadmill_person.md).
