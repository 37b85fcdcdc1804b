# %% [markdown]
# # Correct the loads of an accelerated treadmill
#
# The force transducers of a treadmill measure more than the person: an accelerated belt
# loads them, too. This tutorial measures that load on the empty treadmill, and removes it
# from a recording. `tepsipe compensate` writes the corrected recording in the format of the
# original.
#
# Hnat and van den Bogert (2014) recorded the data on an R-Mill treadmill. The files are in
# the repository csu-hmc/pitch-moment-compensation (Apache-2.0), not in this project. Put `RandomSlowSpeed1.txt` and `RandomSlowSpeed2.txt` into the folder
# `recordings/rmill-treadmill`. Where they are missing, as on some copies of this page, two
# simulated tables with the same columns stand in for them.

# %%
import os
from pathlib import Path

import numpy as np

from tepsipe import compensate_recording

folder = Path(os.environ.get("TEPSIPE_REAL_DATA", "recordings")) / "rmill-treadmill"
names = ("RandomSlowSpeed1.txt", "RandomSlowSpeed2.txt")
recorded = all((folder / name).is_file() for name in names)
if not recorded:
    folder = Path("simulated")
    folder.mkdir(exist_ok=True)
    for seed, name in enumerate(names):
        rng = np.random.default_rng(seed)
        time = np.arange(0.0, 120.0, 0.01)
        noise = np.convolve(rng.standard_normal(time.size), np.hanning(20), mode="same")
        velocity = 1.2 + 0.02 * noise
        ripple = 0.4 * np.sin(2.0 * np.pi * 7.0 * np.cumsum(velocity) * 0.01)
        moment = 2.0 * np.gradient(velocity, time) + ripple
        moment += 0.8 * rng.standard_normal(time.size)
        np.savetxt(
            folder / name,
            np.column_stack([time, moment, velocity]),
            delimiter="\t",
            header="Timestamp (s)\tPitch Moment (Nm)\tBelt Velocity (m/s)",
            comments="",
            fmt="%.6f",
        )
train, test = (str(folder / name) for name in names)
print("recorded" if recorded else "simulated")

# %% [markdown]
# ## Measure the belt-induced load
#
# `tepsipe calibrate` fits models to the first recording of the empty belt and evaluates
# them on the second. R² is the fraction of the load's variance that a model predicts on the
# second recording. The limit is R² of the best linear model of the belt's acceleration. In a terminal, write
#
#     tepsipe calibrate RandomSlowSpeed1.txt RandomSlowSpeed2.txt
#
# The tables have three columns. For files with force plates (C3D, D-Flow), all six loads of
# every plate are calibrated. There, name the channel of the belt velocity with
# `--velocity`.

# %%
# !tepsipe calibrate {train} {test}

# %% [markdown]
# ## Correct a recording
#
# `tepsipe compensate` subtracts the prediction of the recommended model. Here we correct
# the second recording. The belt is empty, so the true load is known: it is zero. We can
# therefore see what remains. In your experiment, name the recording of a person.

# %%
# !tepsipe compensate {test} --models treadmill_models.json --output slow2.txt

# %% [markdown]
# *removed R2* is the R² of the calibration, because the recording is the one on which the
# model was evaluated. The half-width of the errors is larger without a filter than behind
# the low-pass, because the models do not describe the moment above 6 Hz. In the R-Mill
# recordings, most of the moment is vibration above 6 Hz.
#
# The copy has the same columns and samples; only the load is changed. Further lines, which
# begin with `#`, name the models.

# %%
lines = Path("slow2.txt").read_text().splitlines()
print("\n".join(line[:110] for line in lines[:9]))

# %% [markdown]
# ## In a notebook
#
# `compensate_recording` returns the loads before and after the correction, with the 95 %
# interval of the corrected load. Without a name for the output it writes nothing.

# %%
done = compensate_recording(test, "treadmill_models.json")
done.plot()
(load,) = done.loads.values()
inside = np.abs(load.after)[load.within] < load.half_width[load.within]
print(
    f"true load (0) within the interval in {100.0 * inside.mean():.1f} % of the samples"
)

# %% [markdown]
# ## Outside the calibrated range
#
# A model extrapolates if the belt moves faster or accelerates more than in the
# calibration. The command says so. With `--strict` it writes nothing and returns 1.

# %%
table = np.loadtxt(test, skiprows=1)
table[:, 2] = 1.2 + 3.0 * (table[:, 2] - 1.2)
header = Path(test).read_text().splitlines()[0]
np.savetxt("wild.txt", table, delimiter="\t", header=header, comments="", fmt="%.6f")
# !tepsipe compensate wild.txt --models treadmill_models.json --output wild_compensated.txt --strict; echo "exit code $?"

# %% [markdown]
# ## What can go wrong
#
# - **A person changes the load.** The models are those of the empty belt. Friction grows
#   with the weight on the belt, and pulses under a standing person need the trials of a
#   [weight](../recordings/weight-and-empty.md).
# - **Another source of the velocity.** Measure it in the same way in all recordings. A
#   velocity that is logged late needs a model with a lead, such as `fir`.
# - **A faulty plate.** No model mends a wrong sign, unit or origin. Let `tepsipe check`
#   [look for them](../checks.md#force-plates-of-a-c3d-file) first.
#
# ## Exercises
#
# 1. Correct the recording with `--model ripple-tracking`. Why is its R² above the limit?
# 2. Calibrate with `--cutoff 20`. How large is the part of the moment that the belt's
#    acceleration explains now?
# 3. Exchange the two recordings. Is the change of R² larger than the differences between
#    the models?
#
# [Calibrate your own treadmill](../recordings/belt.md) lists formats, models and sources
# of the belt velocity.
