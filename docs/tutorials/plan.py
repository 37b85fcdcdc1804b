# %% [markdown]
# # Plan an experiment
#
# Before anyone stands on the treadmill, two questions can be answered: how precisely
# will the stiffness *K* be known, and what limits it? In this tutorial you plan pulses
# and cameras for the ankle dummy and for a standing person, and write the trial sheet.
#
# ## The starting point
#
# The command `tepsipe plan` simulates a trial of your design and predicts the
# uncertainty of *I*, *B* and *K* from the equations of the estimator. Its defaults are
# the ankle dummy of the thesis: 14 pulses of 0.3 m/s and cameras with a noise of 6.5
# µm.

# %%
# !tepsipe plan

# %% [markdown]
# The columns mean:
#
# | Column | Meaning |
# |---|---|
# | `value` | the value you expect; give yours with `--stiffness`, `--damping`, `--inertia` |
# | `u` | combined standard uncertainty |
# | `Type A` | from noise; falls with the number of pulses |
# | `Type B` | from masses, lengths and calibrations; does not fall |
# | `bound` | Cramér-Rao bound: no unbiased estimator does better |
# | `95 % +-` | half width of the 95 % interval, relative to the value |
#
# Type B dominates here by far. More pulses would be wasted; a better scale would not.
#
# ## Cameras
#
# With passive cameras the noise of a marker is larger. With `--json`, the results can
# be read by a program.

# %%
import json
import subprocess

import pandas as pd


def planned(*options, quantity="K"):
    """Row of a quantity from `tepsipe plan`."""
    command = ["tepsipe", "plan", "--json", *map(str, options)]
    found = json.loads(
        subprocess.run(command, capture_output=True, text=True, check=True).stdout
    )
    return next(row for row in found["plan"] if row["quantity"] == quantity)


rows = []
for noise_m in (1e-5, 2e-4):
    for pathway in ("leg", "joint-likelihood"):
        row = planned(
            "--amplitude", 0.1, "--marker-noise", noise_m, "--pathway", pathway
        )
        rows.append(
            {
                "noise (mm)": 1e3 * noise_m,
                "estimator": pathway,
                "Type A (N·m/rad)": row["predicted_u"],
                "bias (N·m/rad)": row["bias"],
                "95 % ± (%)": row["half_width_percent"],
            }
        )
pd.DataFrame(rows).round(3)

# %% [markdown]
# At 0.1 m/s, windowed least squares (`leg`) loses *K* with noisy cameras: noise in the
# angle biases it, and no number of pulses removes a bias. The joint likelihood uses the
# whole trial and keeps *K*. So decide on the estimator before you buy cameras.
#
# ## Pulses
#
# Larger pulses help, until people step or the belt's drive gives up.

# %%
import matplotlib.pyplot as plt

figure, ax = plt.subplots(figsize=(6, 3), layout="constrained")
amplitudes = [0.1, 0.2, 0.4]
for label, options in (
    ("cameras of 0.01 mm", ("1e-5",)),
    ("cameras of 0.2 mm", ("2e-4",)),
):
    widths = [
        planned(
            "--marker-noise",
            *options,
            "--amplitude",
            a,
            "--pathway",
            "leg",
            quantity="B",
        )["half_width_percent"]
        for a in amplitudes
    ]
    ax.semilogy(amplitudes, widths, "o-", label=label)
ax.set(xlabel="peak velocity of the pulse (m/s)", ylabel="95 % interval of B (± %)")
ax.legend()
plt.show()

# %% [markdown]
# The *shape* of the pulse matters, too. A belt that returns within the pulse leaves the
# slow swing of the leg unexcited, and that swing carries the information on stiffness.
# `--optimise` finds the best pulse within your limits ([best
# pulses](../planning.md#best-pulses)).
#
# ## A standing person
#
# People sway, and sway limits the precision, not the cameras.

# %%
# !tepsipe plan --standing --amplitude 0.4 --number 20

# %% [markdown]
# The last lines answer how many responses are needed. For ±20 % a few are enough; ±10 %
# cannot be reached by any number, because treadmill model, joint centre and feet
# (`--person-type-b`) alone exceed it. Plan calibration trials of the empty belt and of
# a weight near the person's mass instead.
#
# ## The trial sheet
#
# A study is described by a trial sheet, one row per recording. The planned numbers go
# there. The calibration trials use the pulses of the person, in both directions, and
# one of each is held out to validate the treadmill model.

# %%
trials = pd.DataFrame(
    [
        ("empty", "forward", "calibrate", "-"),
        ("empty", "backward", "validate", "-"),
        ("weight", "forward", "calibrate", "-"),
        ("weight", "backward", "validate", "-"),
        *[
            ("standing", f"{task}-{way}", "-", task)
            for task in ("calm", "tense")
            for way in ("forward", "backward")
        ],
    ],
    columns=["experiment", "condition", "role", "task"],
)
pulses, interval_s, rest_s = 10, 6.0, 4.0
trials["duration_s"] = 2 * rest_s + pulses * interval_s
trials["log"] = trials["experiment"] + "-" + trials["condition"] + ".c3d"
trials["source"] = "recorded"
for column in (
    "profile",
    "amplitude",
    "interval_s",
    "command",
    "calibration",
    "markers",
    "emg",
):
    trials[column] = "-"
trials.to_csv("trials.tsv", sep="\t", index=False)
trials[["experiment", "condition", "role", "task", "duration_s", "log"]]

# %% [markdown]
# ## What can go wrong
#
# - **A plan is as good as its numbers.** Measure the noise of your cameras, log and
#   plate at rest: the standard deviation of one sample in one direction.
# - **Intervals of the wrong quantity.** *B* and *I* are harder to determine than *K*.
#   Look at the quantity that you will report.
# - **Regular intervals.** A person who can predict the pulse prepares for it. Randomise
#   the interval, and plan with its mean.
#
# ## Exercises
#
# 1. A colleague offers cameras at 1000 Hz with twice the noise. Are they better for *B*
#    (`--camera-rate`)?
# 2. How precise must the leg's mass be known before more pulses are worth while
#    (`--tolerance leg_mass_kg=...`)?
# 3. Halve `--person-type-b`. How many responses does ±10 % need now?
#
# All options are explained in [plan an experiment](../planning.md). Next: [a human
# ankle under random movement](human_ankle.md).
