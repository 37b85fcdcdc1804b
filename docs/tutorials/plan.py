# %% [markdown]
# # Plan an experiment
#
# Two questions can be answered before anyone stands on the treadmill. How precisely
# will the stiffness *K* be known? What limits this precision? In this tutorial you plan
# pulses and cameras for the ankle dummy and for a standing person, and write the trial
# sheet.
#
# ## The starting point
#
# The command `tepsipe plan` simulates a trial of your design and predicts the
# uncertainty of *I*, *B* and *K* from the equations of the estimator. Its defaults
# describe the ankle dummy of the thesis, with 14 pulses of 0.3 m/s and a camera noise
# of 6.5 µm.

# %%
# !tepsipe plan

# %% [markdown]
# The columns mean:
#
# | Column | Meaning |
# |---|---|
# | `value` | expected value; set it with `--stiffness`, `--damping`, or in a design file |
# | `u` | combined standard uncertainty |
# | `Type A` | from noise; falls with the number of pulses |
# | `Type B` | from masses, lengths and calibrations; does not fall |
# | `bound` | Cramér-Rao bound: no unbiased estimator does better |
# | `95 % +-` | half width of the 95 % interval, relative to the value |
#
# Type B dominates here by far. More pulses would not help; weighing the leg on a better
# scale would.
#
# ## Cameras
#
# Passive cameras measure markers with more noise. With `--json`, `tepsipe plan` prints
# results that a program can read.

# %%
import json
from contextlib import redirect_stdout
from functools import cache
from io import StringIO

import pandas as pd

from tepsipe.cli import main


@cache
def plan(noise_m, amplitude, pathway):
    """Rows of `tepsipe plan` by their quantities."""
    options = {"marker-noise": noise_m, "amplitude": amplitude, "pathway": pathway}
    # in this process: the start of another would take longer than the plan
    with redirect_stdout(StringIO()) as printed:
        main(["plan", "--json", *(f"--{k}={v}" for k, v in options.items())])
    return {row["quantity"]: row for row in json.loads(printed.getvalue())["plan"]}


rows = []
for noise_m in (1e-5, 2e-4):
    for pathway in ("leg", "joint-likelihood"):
        row = plan(noise_m, 0.1, pathway)["K"]
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
# At 0.1 m/s, windowed least squares (`leg`) cannot estimate *K* if the cameras are
# noisy. Noise in the angle biases the estimate, and more pulses do not remove a bias.
# The plan fits every pulse on its own. If at least three pulses repeat each other, the
# analysis avoids this bias by products of different pulses ([method](../method.md)), but
# Type A remains. The joint likelihood uses the whole trial and still estimates *K*.
# Therefore, choose the estimator before you buy cameras.
#
# ## Pulses
#
# Larger pulses help, until people step or the drive of the belt reaches its limit.

# %%
import matplotlib.pyplot as plt

# figures in the notebook again: the command draws without a screen
# %matplotlib inline

figure, ax = plt.subplots(figsize=(6, 3), layout="constrained")
amplitudes = [0.1, 0.2, 0.4]
for label, noise_m in (("cameras of 0.01 mm", 1e-5), ("cameras of 0.2 mm", 2e-4)):
    widths = [plan(noise_m, a, "leg")["B"]["half_width_percent"] for a in amplitudes]
    ax.semilogy(amplitudes, widths, "o-", label=label)
ax.set(xlabel="peak velocity of the pulse (m/s)", ylabel="95 % interval of B (± %)")
ax.legend()
plt.show()

# %% [markdown]
# The *shape* of the pulse matters, too. If the belt returns within the pulse, it does
# not excite the slow swing of the leg, which carries the information on stiffness.
# `--optimise` finds the best pulse within your limits ([best
# pulses](../planning.md#best-pulses)).
#
# ## A standing person
#
# People sway, and this sway, not the camera noise, limits the precision.

# %%
# !tepsipe plan --experiment standing --amplitude 0.4 --number 20

# %% [markdown]
# The last lines state how many responses are needed. For ±20 %, a few are enough. No
# number of responses achieves ±10 %, because the uncertainty from the treadmill model,
# the joint centre and the feet (`type_b` in a design file) alone exceeds it. Instead of more
# responses, plan calibration trials with the empty belt and with a weight close to the
# person's mass.
#
# ## The trial sheet
#
# A trial sheet describes a study, with one row per recording. We enter the planned
# numbers there. The calibration trials use the same pulses as the trials of the person,
# in both directions. One trial of the empty belt and one of the weight are held out to
# validate the treadmill model.

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
# - **A plan is only as good as its inputs.** Measure the noise of your cameras, log and
#   plate at rest, as the standard deviation of one sample in one direction.
# - **Intervals of the wrong quantity.** *B* and *I* are harder to determine than *K*.
#   Look at the quantity that you will report.
# - **Regular pulses.** A person who can predict the pulse prepares for it. Randomise
#   the time between pulses, and plan with its mean.
#
# ## Exercises
#
# 1. A colleague offers cameras at 1000 Hz with twice the noise. Are they better for *B*
#    (`--camera-rate`)?
# 2. How precisely must the leg's mass be known before more pulses become worthwhile
#    (`leg_mass_kg` in the section `tolerances` of a design file)?
# 3. Halve `type_b` in a design file. How many responses does ±10 % need now?
#
# The page [plan an experiment](../planning.md) explains all options. Next: [a human
# ankle under random movement](human_ankle.md).
