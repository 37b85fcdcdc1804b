# %% [markdown]
# # Gallery
#
# This page shows the figures that the public functions draw, with the code for each.

# %%
from tepsipe import (
    belt_recording,
    calibrate_treadmill,
    fit_admittance,
    fit_impedance,
    fit_joint_likelihood,
    frequency_response,
    load_example,
    simulate_joint,
)

dummy = load_example("dummy")
manipulator = load_example("manipulator")
ankle = load_example("ankle")

# %% [markdown]
# ## Torque of a leg on a belt
#
# Windowed least squares fits *I*, *B* and *K* to the torque. Grey: measured torque.
# Coloured: torque predicted from *I*, *B* and *K*.

# %%
windows = fit_impedance(
    dummy.time, dummy.angle, dummy.torque, perturbations=dummy.perturbations
)
windows.plot()

# %% [markdown]
# ## The same joint from markers and belt, without a torque
#
# The joint likelihood fits the angle over the whole trial, including the swing between
# the pulses.

# %%
likelihood = fit_joint_likelihood(
    dummy.time,
    dummy.positions,
    dummy.markers,
    dummy.leg,
    labels=dummy.labels,
    belt_fixed=dummy.belt_fixed,
    perturbations=dummy.perturbations,
    belt_velocity=dummy.belt_velocity,
    softening=False,
)
likelihood.plot()

# %% [markdown]
# ## One perturbation on your own axes
#
# `plot(ax=...)` draws on your own axes, so you can zoom in and add further signals.

# %%
import matplotlib.pyplot as plt

pulse = dummy.perturbations[3]
begin, end = dummy.time[pulse.start] - 0.2, dummy.time[pulse.stop] + 1.5
figure, axes = plt.subplots(2, 1, figsize=(7, 4.5), sharex=True, layout="constrained")
axes[0].plot(dummy.time, dummy.belt_velocity, linewidth=1)
axes[0].set_ylabel("belt velocity (m/s)")
windows.plot(ax=axes[1])
axes[1].set_xlim(begin, end)
plt.show()

# %% [markdown]
# ## Frequency response of a joint, with coherence

# %%
response = frequency_response(
    manipulator.time,
    manipulator.torque,
    manipulator.angle,
    period_s=manipulator.period_s,
    band_hz=(1.0, 20.0),
)
response.plot()

# %% [markdown]
# ## Admittance and its fit

# %%
fit_admittance(response).plot()

# %% [markdown]
# ## A joint with a reflex is not linear
#
# The figure shows the impedance of the simulated ankle. Its low coherence shows that a
# linear model cannot predict the torque.

# %%
frequency_response(ankle.time, ankle.angle, ankle.torque, band_hz=(0.5, 20.0)).plot()

# %% [markdown]
# ## A simulated joint
#
# `simulate_joint` simulates a leg on a moving belt, here with three stiffnesses: half,
# once and twice the true value.

# %%
figure, ax = plt.subplots(figsize=(7, 3), layout="constrained")
shown = dummy.time < 9.0
for stiffness in (5.0, 10.0, 20.0):
    moved = simulate_joint(
        dummy.time[shown],
        dummy.belt_velocity[shown],
        dummy.leg,
        I=0.02,
        B=0.15,
        K=stiffness,
        engine="equations",
    )
    ax.plot(
        dummy.time[shown], moved.theta, linewidth=1, label=f"K = {stiffness:g} N·m/rad"
    )
ax.set(xlabel="time (s)", ylabel="angle (rad)")
ax.legend()
plt.show()

# %% [markdown]
# ## Models of a treadmill
#
# An accelerating belt loads its force plate. `calibrate_treadmill` fits models to one
# recording and evaluates them on another.

# %%
import numpy as np

from tepsipe import lowpass

rate_hz, duration_s = 100.0, 60.0


def recorded(seed, name):
    """Pitch moment and belt velocity of a treadmill whose frame resonates at 12 Hz."""
    rng = np.random.default_rng(seed)
    time = np.arange(0.0, duration_s, 1.0 / rate_hz)
    velocity = 1.2 + 0.1 * lowpass(
        rng.standard_normal(time.size), rate_hz, cutoff_hz=8.0
    )
    acceleration, w = np.gradient(velocity, time), 2.0 * np.pi * 12.0
    moment, rate = np.zeros_like(time), 0.0
    for k in range(1, time.size):
        rate += (
            w**2 * (5.0 * acceleration[k - 1] - moment[k - 1]) - 0.4 * w * rate
        ) / rate_hz
        moment[k] = moment[k - 1] + rate / rate_hz
    noisy = moment + 0.3 * rng.standard_normal(time.size)
    return belt_recording(time, noisy, velocity, unit="Nm", name=name)


calibration = calibrate_treadmill(
    recorded(1, "first"), recorded(2, "second"), models=["hnat2014", "fir"]
)
calibration.plot()
